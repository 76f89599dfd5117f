// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/control_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/robot_chain_case.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/simulate_result.hpp"
#include "osteomill/simulate/variants.hpp"
#include "osteomill/thermal/thermal_dose.hpp"

namespace osteomill::io {
namespace {

using Json = nlohmann::ordered_json;

struct ControlCase {
  SimulateCase job;
  int count = 0;  ///< of variants; 0: the bone as it is
  simulate::VariantOptions variants;
  control::SupervisorLimits supervisor;
};

void bind_variants(Section& section, ControlCase& to) {
  section.table("variants", "seeded variants of bone and sensor", Need::optional, [&](Section& s) {
    simulate::VariantOptions& options = to.variants;
    s.integer("count", to.count, between(0, 100000), "number of variants; 0: the bone as it is",
              Need::optional);
    int seed = 1;
    s.integer("seed", seed, between(0, 2147483647), "of all that is random", Need::optional);
    options.seed = static_cast<std::uint64_t>(seed);
    s.number("gain_sigma", options.gain_sigma, {}, between(0.0, 1.0),
             "standard deviation of the factor on the gain", Need::optional);
    s.number("correlation_mm", options.correlation, {units::mm, "mm"}, positive(),
             "length over which the factor's correlation falls to 1/e", Need::optional);
    s.number("noise_n", options.noise, {1.0, "N"}, non_negative(),
             "standard deviation of each mean force", Need::optional);
    std::vector<double> delay(options.delay.begin(), options.delay.end());
    s.numbers("delay_updates", delay, {}, between(1, 100),
              "least and most control periods from a force to its feed, drawn evenly",
              Need::optional);
    if (delay.size() == 2 && delay[0] <= delay[1]) {
      options.delay = {static_cast<int>(delay[0]), static_cast<int>(delay[1])};
    } else {
      s.fault("delay_updates", "must be two numbers, the smaller first");
    }
    s.flag("hard_zones", options.hard_zones, "a zone 4.4 times as hard somewhere on each line");
  });
}

void bind_supervisor(Section& section, control::SupervisorLimits& limits) {
  section.table("supervisor", "limits that stop the machine", Need::optional, [&](Section& s) {
    s.number("force_n", limits.force, {1.0, "N"}, positive(), "largest sample", Need::optional);
    s.number("torque_nmm", limits.torque, {units::n_mm, "N mm"}, positive(), "largest mean torque",
             Need::optional);
    s.number("force_rate_n_per_s", limits.force_rate, {1.0, "N/s"}, positive(),
             "largest rise of the mean force", Need::optional);
    s.number("stall_time_s", limits.stall_time, {1.0, "s"}, positive(),
             "longest time with a command and no motion", Need::optional);
    s.number("sample_age_ms", limits.sample_age, {units::ms, "ms"}, positive(),
             "oldest sample that is believed", Need::optional);
    double celsius = limits.temperature - thermal::kZeroCelsius;
    s.number("temperature_c", celsius, {1.0, "°C"}, between(-50, 300),
             "hottest bone that stays; known with [heat]", Need::optional);
    limits.temperature = celsius + thermal::kZeroCelsius;
    s.number("no_go_margin_mm", limits.no_go_margin, {units::mm, "mm"}, non_negative(),
             "least distance from the tool to a no-go region", Need::optional);
    s.integer("watchdog_periods", limits.watchdog_periods, between(1, 1000),
              "control periods that may go by without a look of the supervisor", Need::optional);
  });
}

void bind_sensor(Section& section, netft::ClientOptions& sensor) {
  section.table(
      "sensor", "Net F/T force sensor of --sensor netft", Need::optional, [&](Section& s) {
        s.text("address", sensor.address, "IP address", Need::optional);
        s.integer("port", sensor.port, between(1, 65535), "UDP port", Need::optional);
        s.number("counts_per_newton", sensor.counts_per_newton, {1.0, "1/N"}, positive(),
                 "as the sensor's page of its calibration says", Need::optional);
        s.number("counts_per_newton_metre", sensor.counts_per_newton_metre, {1.0, "1/(N m)"},
                 positive(), "as the sensor's page of its calibration says", Need::optional);
      });
}

void bind_control(Section& section, ControlCase& to) {
  bind_simulate(section, to.job);
  bind_carrying_robot(section, to.job.robot);
  bind_sensor(section, to.job.sensor);
  bind_variants(section, to);
  bind_supervisor(section, to.supervisor);
}

/// The runs that one run of the case stands for.
void expand(const ControlCase& one, std::vector<SimulateCase>& cases) {
  SimulateCase job = one.job;
  job.supervisor = one.supervisor;
  job.supervisor->highest_feed = job.controller.limits.highest;
  job.supervisor->highest_rapid = job.path.rapid_feed;
  job.supervisor->period = job.controller.period;
  const auto add = [&](const SimulateCase& made) {
    cases.push_back(made);
    // A sensor without noise repeats itself in uniform bone.
    if (made.machine.force_noise == 0.0) cases.back().supervisor->frozen_periods = 0;
  };
  if (one.count == 0) return add(job);
  if (job.stock.kind != StockKind::line_profile) {
    throw InvalidInput(Fault{"variants.count", std::to_string(one.count),
                             "needs stock.kind = \"line-profile\"", "leave [variants] out"});
  }
  simulate::VariantOptions variants = one.variants;
  variants.map_error = job.map.trust.position_error;
  for (int number = 0; number < one.count; ++number) {
    const simulate::Variant variant = simulate::vary(job.stock.profile, job.machine, variants,
                                                     static_cast<std::uint64_t>(number));
    SimulateCase made = job;
    made.name = fmt::format("{}-{:02}", job.name, number);
    made.variant_of = job.name;
    made.stock.profile = variant.profile;
    made.machine = variant.machine;
    add(made);
  }
}

Json percentile(std::vector<double> times, double share) {
  if (times.empty()) return nullptr;
  const auto at = static_cast<std::size_t>(share * static_cast<double>(times.size() - 1));
  std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(at), times.end());
  return times[at] / units::um;  // seconds to microseconds: the same factor
}

/// The value below which the share lies; null when there is none.
Json quantile(std::vector<int> values, double share) {
  if (values.empty()) return nullptr;
  const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

/// From the cycle in which the fault was seen, ms at a servo period of 1 ms.
Json after(const std::optional<std::uint32_t>& cycle, std::uint32_t seen) {
  return cycle ? Json(static_cast<std::int32_t>(*cycle - seen)) : Json(nullptr);
}

Json stop_of(const SupervisedStop& stop) {
  const auto after = [&](const std::optional<double>& time) {
    return time ? Json((*time - stop.event.time) / units::ms) : Json(nullptr);
  };
  return {{"feed_held_after_ms", after(stop.held)},
          {"at_rest_after_ms", after(stop.rest)},
          {"spindle_inhibited_after_ms", after(stop.spindle)}};
}

Json machine_of(const SimulatedRun& run) {
  const MachineSummary& machine = *run.machine;
  Json stop = nullptr;
  if (machine.stop) {
    const MachineStop& was = *machine.stop;
    stop = {{"cause", control::name(was.event.cause)},
            {"detail", was.detail},
            {"feed_held_after_ms", after(was.held, was.seen)},
            {"at_rest_after_ms", after(was.rest, was.seen)},
            {"spindle_inhibited_after_ms", after(was.spindle, was.seen)}};
  }
  return {{"run", run.input.name},
          {"machine_time_s", machine.machine_time},
          {"servo_cycles", machine.cycles},
          {"servo_cycles_lost", machine.lost},
          {"feed_delay_cycles_p50", quantile(machine.feed_delays, 0.5)},
          {"feed_delay_cycles_p99", quantile(machine.feed_delays, 0.99)},
          {"feed_delay_cycles_max", quantile(machine.feed_delays, 1.0)},
          {"off_path_um_max", machine.off_path / units::um},
          {"off_axis_deg_max", machine.off_axis / units::deg},
          {"longest_gap_ms", machine.longest_gap / units::ms},
          {"bone_lag_cycles_max", machine.bone_lag},
          {"force_samples", machine.sensor.received},
          {"force_samples_lost", machine.sensor.lost},
          {"stop", stop}};
}

struct Totals {
  double time = 0.0;
  double above = 0.0;
  double peak = 0.0;
  double limit = 0.0;
  int count = 0;
};

}  // namespace

void bind_control_keys(Section& section) {
  ControlCase unused;
  bind_control(section, unused);
}

std::vector<SimulateCase> read_control_cases(const std::vector<CaseRun>& runs) {
  std::vector<SimulateCase> cases;
  FaultList faults;
  for (const CaseRun& run : runs) {
    faults.gather([&] {
      ControlCase made;
      prepare(made.job, run);
      made.job.expanded =
          Section::read(run, [&](Section& section) { bind_control(section, made); });
      complete(made.job);
      netft::check(made.job.sensor);
      expand(made, cases);
    });
  }
  faults.raise();
  return cases;
}

Json control_document_of(const std::vector<SimulatedRun>& runs, double wall_time, double jitter) {
  Json document = document_of(runs, wall_time);
  Json events = Json::array();
  Json stopped_by = nullptr;
  std::vector<double> times;
  int overruns = 0;
  for (const SimulatedRun& run : runs) {
    for (const control::LoopEvent& event : run.loop.events) {
      stopped_by = control::name(event.cause);
      events.push_back({{"run", run.input.name},
                        {"time_s", event.time},
                        {"kind", "stop"},
                        {"cause", control::name(event.cause)},
                        {"value", std::isfinite(event.value) ? Json(event.value) : Json(nullptr)},
                        {"limit", event.limit}});
      if (run.stop) events.back()["stop"] = stop_of(*run.stop);
    }
    times.insert(times.end(), run.loop.compute_times.begin(), run.loop.compute_times.end());
    overruns += run.loop.overruns;
  }
  document["events"] = events;
  document["timing"] = {
      {"period_ms", runs.empty() ? 0.0 : runs[0].input.controller.period / units::ms},
      {"compute_us_p50", percentile(times, 0.5)},
      {"compute_us_p999", percentile(times, 0.999)},
      {"wake_up_jitter_us_max", jitter < 0.0 ? Json(nullptr) : Json(jitter / units::um)},
      {"overruns", overruns}};
  Json machines = Json::array();
  for (const SimulatedRun& run : runs) {
    if (run.machine) machines.push_back(machine_of(run));
  }
  if (!machines.empty()) document["machine"] = machines;
  document["variants"] = variants_of(runs);
  document["stopped_by"] = stopped_by;
  return document;
}

std::string supervisor_sentence(const std::vector<SimulateCase>& cases) {
  if (cases.empty() || !cases.front().supervisor) return "";
  const control::SupervisorLimits& limits = *cases.front().supervisor;
  std::string sentence = fmt::format("supervisor: stops at {:g} N, {:g} N mm", limits.force,
                                     limits.torque / units::n_mm);
  const auto any = [&](const auto& has) { return std::any_of(cases.begin(), cases.end(), has); };
  if (any([](const SimulateCase& one) { return one.heat.has_value(); })) {
    sentence +=
        fmt::format(", {:g} °C of bone that stays", limits.temperature - thermal::kZeroCelsius);
  }
  if (any([](const SimulateCase& one) { return !one.regions.no_go.empty(); })) {
    sentence += fmt::format(", {:g} mm from no-go regions", limits.no_go_margin / units::mm);
  }
  const bool same = std::all_of(cases.begin(), cases.end(), [&](const SimulateCase& one) {
    return one.supervisor->force == limits.force && one.supervisor->torque == limits.torque &&
           one.supervisor->temperature == limits.temperature &&
           one.supervisor->no_go_margin == limits.no_go_margin;
  });
  return sentence + (same ? "" : "; other limits for other runs");
}

std::vector<std::string> variants_of(const std::vector<SimulatedRun>& runs) {
  std::vector<std::pair<std::string, Totals>> groups;
  for (const SimulatedRun& run : runs) {
    if (run.input.variant_of.empty()) continue;
    if (groups.empty() || groups.back().first != run.input.variant_of) {
      groups.push_back({run.input.variant_of, {}});
    }
    Totals& totals = groups.back().second;
    totals.time += run.summary.cutting_time;
    totals.above += run.summary.time_above_limit;
    totals.peak = std::max(totals.peak, run.summary.peak_force);
    totals.limit = run.input.force_limit;
    ++totals.count;
  }
  std::vector<std::string> sentences;
  for (const auto& [name, totals] : groups) {
    sentences.push_back(fmt::format(
        "{}: {} variants, mean {:.2f} s, above {:g} N for {:.4f} s in all, largest peak {:.1f} N",
        name, totals.count, totals.time / totals.count, totals.limit, totals.above, totals.peak));
  }
  return sentences;
}

}  // namespace osteomill::io
