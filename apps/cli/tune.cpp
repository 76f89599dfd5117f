// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "documents.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/plot.hpp"
#include "osteomill/io/tune_case.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using control::Margins;

Json finite_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json margins_of(const Margins& found) {
  return {{"gain_margin", finite_or_null(found.gain_margin)},
          {"phase_margin_deg", finite_or_null(found.phase_margin / units::deg)},
          {"crossover_rad_per_s", found.crossover_frequency}};
}

Json loop_of(const control::SugitaLoop& loop, double entry_feed) {
  return {{"reference_force_n", loop.reference_force},
          {"gain_up", loop.gain_up},
          {"gain_down", loop.gain_down},
          {"entry_feed_mm_per_s", entry_feed / units::mm_per_s}};
}

struct Result {
  io::TuneCase input;
  io::Tuning tuning;
  control::SugitaLoop given;
  double unit = 0.0;  ///< gain on the sum of a gain of 1, m/s per N

  double given_entry() const {
    return input.job.controller.predictive ? input.job.controller.predictive->entry_feed : 0.0;
  }
};

Json document_of(const Result& result) {
  const io::Tuning& tuning = result.tuning;
  Json document = {{"bare_critical_loop_gain", tuning.bare_critical_loop_gain},
                   {"given", loop_of(result.given, result.given_entry())},
                   {"proposed", loop_of(tuning.proposed, tuning.entry_feed)}};
  Json plants = Json::array();
  for (const io::TunedCorner& corner : tuning.corners) {
    plants.push_back({{"gain_n_per_mm_per_s", corner.plant.force_gain / 1e3},
                      {"delay_updates", corner.plant.delay_updates},
                      {"critical_gain", corner.critical_gain / result.unit},
                      {"given_up", margins_of(corner.given_up)},
                      {"given_down", margins_of(corner.given_down)},
                      {"proposed_up", margins_of(corner.proposed_up)},
                      {"proposed_down", margins_of(corner.proposed_down)}});
  }
  document["plants"] = plants;
  Json runs = Json::array();
  for (const io::TunedRun& run : tuning.runs) {
    runs.push_back({{"loop", run.name},
                    {"delay_updates", run.delay},
                    {"status", simulate::name(run.summary.status)},
                    {"cutting_time_s", run.summary.cutting_time},
                    {"mean_force_n", run.summary.mean_force},
                    {"peak_force_n", run.summary.peak_force},
                    {"time_above_limit_s", run.summary.time_above_limit}});
  }
  document["simulated"] = runs;
  return document;
}

std::string pair_of(const Margins& up, const Margins& down, bool phase) {
  const auto text = [&](const Margins& found) {
    const double value = phase ? found.phase_margin / units::deg : found.gain_margin;
    if (!std::isfinite(value)) return std::string("none");
    return phase ? fmt::format("{:.0f}", value) : fmt::format("{:.2f}", value);
  };
  return text(up) + " / " + text(down);
}

std::vector<std::vector<std::string>> rows_of(const Result& result) {
  std::vector<std::vector<std::string>> rows = {{"bone, N/(mm/s)", "delay", "critical gain",
                                                 "gain margin, given", "phase, deg",
                                                 "gain margin, proposed", "phase, deg"}};
  for (const io::TunedCorner& corner : result.tuning.corners) {
    rows.push_back({fmt::format("{:g}", corner.plant.force_gain / 1e3),
                    std::to_string(corner.plant.delay_updates),
                    fmt::format("{:.4f}", corner.critical_gain / result.unit),
                    pair_of(corner.given_up, corner.given_down, false),
                    pair_of(corner.given_up, corner.given_down, true),
                    pair_of(corner.proposed_up, corner.proposed_down, false),
                    pair_of(corner.proposed_up, corner.proposed_down, true)});
  }
  return rows;
}

std::vector<std::vector<std::string>> simulated_of(const Result& result) {
  std::vector<std::vector<std::string>> rows = {{"loop", "delay", "status", "cutting time, s",
                                                 "mean force, N", "peak force, N",
                                                 "above limit, s"}};
  for (const io::TunedRun& run : result.tuning.runs) {
    rows.push_back({run.name, std::to_string(run.delay), simulate::name(run.summary.status),
                    fmt::format("{:.1f}", run.summary.cutting_time),
                    fmt::format("{:.2f}", run.summary.mean_force),
                    fmt::format("{:.1f}", run.summary.peak_force),
                    fmt::format("{:.3f}", run.summary.time_above_limit)});
  }
  return rows;
}

std::vector<std::string> sentences_of(const Result& result) {
  const control::SugitaLoop& to = result.tuning.proposed;
  std::vector<std::string> sentences = {
      fmt::format("given:    reference_force_n = {:.2f}, gain_up = {:.4f}, gain_down = {:.4f}",
                  result.given.reference_force, result.given.gain_up, result.given.gain_down),
      fmt::format("proposed: reference_force_n = {:.2f}, gain_up = {:.4f}, gain_down = {:.4f}, "
                  "predictive.entry_feed_mm_per_s = {:.2f}",
                  to.reference_force, to.gain_up, to.gain_down,
                  result.tuning.entry_feed / units::mm_per_s),
      "margins: of the gain up / of the gain down; below 1 and below 0 degrees the loop is "
      "unstable",
      fmt::format("without servo, at one period of delay, the loop is critical at G K_f = {:.6f} "
                  "= 2 sin^2(pi/10)",
                  result.tuning.bare_critical_loop_gain)};
  if (result.tuning.runs.empty()) {
    sentences.push_back(
        "the reference force is that of the case: only a stock of kind "
        "\"line-profile\" is simulated to find one");
  }
  return sentences;
}

std::string label_of(const control::LinearPlant& plant) {
  return fmt::format("{:g} N/(mm/s), delay {}", plant.force_gain / 1e3, plant.delay_updates);
}

/// From a hundredth of the Nyquist frequency up to a share of it, evenly in the logarithm.
std::vector<double> frequencies_of(double period, double share) {
  std::vector<double> list;
  const int count = 400;
  for (int i = 0; i <= count; ++i) {
    const double part = 0.01 * std::pow(100.0 * share, static_cast<double>(i) / count);
    list.push_back(std::numbers::pi / period * part);
  }
  return list;
}

void draw_bode(const Result& result, const std::filesystem::path& file) {
  io::Panel size{.y = {.label = "|L|", .low = 0.01, .high = 100.0, .logarithmic = true},
                 .series = {},
                 .limits = {{1.0, "crossover"}}};
  io::Panel phase{.y = {.label = "phase, deg", .low = -360.0, .high = 0.0},
                  .series = {},
                  .limits = {{-180.0, "critical"}}};
  const double gain = result.tuning.proposed.gain_down * result.unit;
  for (const io::TunedCorner& corner : result.tuning.corners) {
    io::Series sizes{.label = label_of(corner.plant), .x = {}, .y = {}};
    io::Series phases{.label = "", .x = {}, .y = {}};
    double turned = 0.0;
    double last = 0.0;
    // The taps have their first zero at two fifths of the Nyquist frequency.
    for (const double w : frequencies_of(corner.plant.period, 0.39)) {
      const std::complex<double> value = control::open_loop(corner.plant, gain, w);
      // Followed from -90 degrees, where an integrator begins, so that it does not jump.
      const double angle = std::arg(value) / units::deg;
      if (!phases.x.empty()) turned -= 360.0 * std::round((angle - last) / 360.0);
      last = angle;
      sizes.x.push_back(w);
      sizes.y.push_back(std::abs(value));
      phases.x.push_back(w);
      phases.y.push_back(angle + turned);
    }
    size.series.push_back(sizes);
    phase.series.push_back(phases);
  }
  io::draw(io::LinePlot{.title = "Open loop with the proposed gain down",
                        .x = {.label = "frequency, rad/s", .logarithmic = true},
                        .panels = {size, phase},
                        .width = 800,
                        .height = 620},
           file);
}

void draw_nyquist(const Result& result, const std::filesystem::path& file) {
  io::Panel plane{.y = {.label = "imaginary part", .low = -1.6, .high = 1.6}, .series = {}};
  const double gain = result.tuning.proposed.gain_down * result.unit;
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const io::TunedCorner& corner : result.tuning.corners) {
    io::Series curve{.label = label_of(corner.plant), .x = {}, .y = {}};
    for (const double w : frequencies_of(corner.plant.period, 1.0)) {
      const std::complex<double> value = control::open_loop(corner.plant, gain, w);
      const bool inside = std::abs(value.real()) < 2.2 && std::abs(value.imag()) < 1.6;
      curve.x.push_back(inside ? value.real() : none);
      curve.y.push_back(inside ? value.imag() : none);
    }
    plane.series.push_back(curve);
  }
  io::Series circle{.label = "unit circle", .x = {}, .y = {}, .mark = io::Mark::dashed};
  for (int i = 0; i <= 180; ++i) {
    circle.x.push_back(std::cos(2.0 * std::numbers::pi * i / 180.0));
    circle.y.push_back(std::sin(2.0 * std::numbers::pi * i / 180.0));
  }
  plane.series.push_back(circle);
  plane.series.push_back({.label = "-1", .x = {-1.0}, .y = {0.0}, .mark = io::Mark::points});
  io::draw(io::LinePlot{.title = "Nyquist curve with the proposed gain down",
                        .x = {.label = "real part", .low = -2.2, .high = 2.2},
                        .panels = {plane},
                        .width = 800,
                        .height = 600},
           file);
}

void draw_steps(const Result& result, const std::filesystem::path& file) {
  io::LinePlot plot{.title = "Mean force after a step of the reference, gain down both ways",
                    .x = {.label = "time, s"},
                    .panels = {},
                    .width = 800,
                    .height = 620};
  const auto panel_of = [&](const char* name, double gain) {
    io::Panel panel{.y = {.label = fmt::format("force, {}", name), .low = 0.0, .high = 2.0},
                    .series = {}};
    for (const io::TunedCorner& corner : result.tuning.corners) {
      io::Series force{.label = label_of(corner.plant), .x = {}, .y = {}};
      const std::vector<double> values = control::step_response(corner.plant, gain, 200);
      for (std::size_t i = 0; i < values.size(); ++i) {
        force.x.push_back(corner.plant.period * static_cast<double>(i + 1));
        force.y.push_back(std::abs(values[i]) < 3.0 ? values[i]
                                                    : std::numeric_limits<double>::quiet_NaN());
      }
      panel.series.push_back(force);
    }
    return panel;
  };
  plot.panels = {panel_of("as given", result.given.gain_down * result.unit),
                 panel_of("proposed", result.tuning.proposed.gain_down * result.unit)};
  io::draw(plot, file);
}

Shown show(const io::CaseRun& run) {
  Result result{io::read_tune_case(run), {}, {}, 0.0};
  result.given = std::get<control::SugitaLoop>(result.input.job.controller.law);
  result.unit = control::gain_on_sum(result.given, 1.0);
  result.tuning = io::tune(result.input, console_progress());
  Shown shown{.document = document_of(result),
              .expanded = result.input.job.expanded,
              .rows = rows_of(result),
              .sentences = sentences_of(result)};
  if (!result.tuning.runs.empty()) shown.tables = {simulated_of(result)};
  shown.warnings = result.tuning.warnings;
  shown.document["warnings"] = shown.warnings;
  shown.figures = {{"bode",
                    "Size and phase of the open loop at the corners of the range; the delay turns "
                    "the phase only",
                    [=](const auto& file) { draw_bode(result, file); }},
                   {"nyquist", "Nyquist curves: each leaves -1 on its left",
                    [=](const auto& file) { draw_nyquist(result, file); }},
                   {"step", "Step responses of the linear loop",
                    [=](const auto& file) { draw_steps(result, file); }}};
  return shown;
}

}  // namespace

void add_tune(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = program.add_subcommand(
      "tune", "gains of the force loop with margins, for a range of bones and delays");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { show_runs(*arguments, "tune", show); });
}

}  // namespace osteomill::cli
