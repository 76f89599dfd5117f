// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_case.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/heat_section.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/thermal/thermal_dose.hpp"

namespace osteomill::io {
namespace {

using control::SumReading;

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kMmPerS{units::mm_per_s, "mm/s"};
constexpr Quantity kMmPerS2{units::mm, "mm/s2"};
constexpr Quantity kRpm{units::rpm, "rpm"};
constexpr Quantity kNewton{1.0, "N"};
constexpr Quantity kPlain{};
constexpr numerics::SecondOrderLag kDefaultServo{118.0, 0.7};
constexpr numerics::SecondOrderLag kVeryFastServo{5000.0, 1.0};

void bind_sugita(Section& s, control::SugitaLoop& loop) {
  s.number("reference_force_n", loop.reference_force, kNewton, positive(),
           "mean force that the loop holds", Need::optional);
  s.number("gain_up", loop.gain_up, kPlain, positive(), "loop gain when the feed rises, per N",
           Need::optional);
  s.number("gain_down", loop.gain_down, kPlain, positive(), "loop gain when the feed falls, per N",
           Need::optional);
  s.choice<SumReading>(
      "reading", loop.reading,
      {{"override", SumReading::override}, {"mean", SumReading::mean}, {"sum", SumReading::sum}},
      "unit of the gain: % of the full feed, mm/s on the mean, mm/s on the sum", Need::optional);
}

void bind_model_adaptive(Section& s, control::ModelAdaptiveOptions& options) {
  s.number("margin", options.margin, kPlain, between(0.05, 1.0),
           "share of limits.force_n that the peak force is to reach", Need::optional);
  s.number("confidence", options.confidence, kPlain, between(0.0, 10.0),
           "standard errors that are added to the predicted gain", Need::optional);
  s.number("floor_feed_mm_per_s", options.floor_feed, kMmPerS, positive(),
           "never slower, so that the loop cannot stall", Need::optional);
  s.number("hardest_rise_per_mm", options.hardest_rise, {1.0 / units::mm, "1/mm"}, non_negative(),
           "how much the gain may rise unforeseen, relative to itself, per mm", Need::optional);
  s.number("settle_mm", options.settle, kMm, non_negative(),
           "past a predicted entry, before the estimate is trusted with more feed", Need::optional);
}

void bind_model_predictive(Section& s, control::ModelPredictiveOptions& options) {
  s.number("margin", options.margin, kPlain, between(0.05, 1.0),
           "share of limits.force_n that the peak force is to reach", Need::optional);
  s.number("confidence", options.confidence, kPlain, between(0.0, 10.0),
           "standard errors that are added to the predicted strength", Need::optional);
  s.number("floor_feed_mm_per_s", options.floor_feed, kMmPerS, positive(),
           "never slower, so that the loop cannot stall", Need::optional);
  s.number("unforeseen_rise_per_mm", options.unforeseen_rise, {1.0 / units::mm, "1/mm"},
           non_negative(), "how much the gain may rise although the map does not show it, per mm",
           Need::optional);
}

void bind_map(Section& section, BoneMapCase& map) {
  section.table(
      "map", "what is known of the bone before it is cut", Need::optional, [&](Section& s) {
        s.number("error_mm", map.trust.position_error, kMm, non_negative(),
                 "the bone is within +- this along the path of where the map has it",
                 Need::optional);
        s.number(
            "offset_mm", map.offset, kMm, between(-1000, 1000),
            "how far along the path the map of the simulation lies from its bone; with [variants] "
            "it is drawn within error_mm",
            Need::optional);
        s.number("gain_error", map.trust.gain_error, kPlain, between(0.0, 10.0),
                 "standard deviation of the map's cutting gain, relative", Need::optional);
        s.number("correlation_mm", map.trust.correlation, kMm, positive(),
                 "along the path, over which that error falls to 1/e", Need::optional);
        s.choice<BoneMapCase::Shows>(
            "shows", map.shows,
            {{"stock", BoneMapCase::Shows::stock}, {"plan", BoneMapCase::Shows::plan}},
            "with [variants]: the bone that is cut, or the one that it varies", Need::optional);
      });
}

void bind_predictive(Section& s, control::PredictiveMode& mode) {
  s.number("entry_feed_mm_per_s", mode.entry_feed, kMmPerS, positive(), "feed at the entry",
           Need::optional);
  s.number("lead_mm", mode.lead, kMm, non_negative(), "how far before the predicted contact",
           Need::optional);
  s.number("hold_mm", mode.hold, kMm, non_negative(), "how far past it", Need::optional);
  s.number("uncertainty_mm", mode.uncertainty, kMm, non_negative(),
           "of the predicted contact: widens both sides", Need::optional);
  s.flag("until_engaged", mode.until_engaged, "hold until the cutter is fully engaged");
}

void bind_controller(Section& section, SimulateCase& to) {
  enum class Law { constant, sugita, model_adaptive, model_predictive };
  control::FeedController& controller = to.controller;
  section.table("controller", "what sets the feed", Need::required, [&](Section& s) {
    Law law = Law::constant;
    s.choice<Law>("kind", law,
                  {{"constant", Law::constant},
                   {"sugita", Law::sugita},
                   {"model-adaptive", Law::model_adaptive},
                   {"model-predictive", Law::model_predictive}},
                  "constant feed, the published force loop, the law that identifies the bone, or "
                  "the one that looks ahead in the map");
    s.number("period_ms", controller.period, {units::ms, "ms"}, up_to(1000.0),
             "time between two commands", Need::optional);
    if (s.when(law == Law::constant)) {
      control::ConstantFeed constant;
      s.number("feed_mm_per_s", constant.feed, kMmPerS, positive(),
               "in place of the programmed feed");
      if (law == Law::constant) controller.law = constant;
    }
    if (s.when(law == Law::sugita)) {
      control::SugitaLoop loop;
      bind_sugita(s, loop);
      if (law == Law::sugita) controller.law = loop;
    }
    if (s.when(law == Law::model_adaptive)) {
      bind_model_adaptive(s, to.model_options);
      to.model_adaptive = law == Law::model_adaptive;
    }
    if (s.when(law == Law::model_predictive)) {
      bind_model_predictive(s, to.predictive_options);
      to.model_predictive = law == Law::model_predictive;
    }
    control::PredictiveMode mode;
    if (s.table("predictive", "slow entry into bone; absent: none", Need::optional,
                [&](Section& below) { bind_predictive(below, mode); })) {
      controller.predictive = mode;
    }
  });
}

/// What the model-predictive law keeps beside the force.
void bind_plan_limits(Section& s, control::PlanLimits& limits, std::optional<double>& temperature) {
  std::optional<double> tooth, deflection, stiffness;
  s.number("feed_per_tooth_mm", tooth, kMm, positive(),
           "largest feed per tooth, for controller.kind = \"model-predictive\"; absent: any");
  s.number("deflection_mm", deflection, kMm, positive(),
           "largest deflection of the tip, for \"model-predictive\"; absent: any");
  s.number("tool_stiffness_n_per_mm", stiffness, {units::n_per_mm, "N/mm"}, positive(),
           "of the tool at its tip, for deflection_mm: see osteomill modes");
  std::optional<double> celsius;
  s.number("temperature_c", celsius, {1.0, "°C"}, between(38.0, 300.0),
           "of the bone that stays, for \"model-predictive\": needs [heat]; absent: any");
  if (celsius) temperature = *celsius + thermal::kZeroCelsius;
  if (tooth) limits.feed_per_tooth = *tooth;
  if (deflection && stiffness) limits.force_of_deflection = *deflection * *stiffness;
  if (deflection.has_value() != stiffness.has_value()) {
    s.fault(deflection ? "tool_stiffness_n_per_mm" : "deflection_mm",
            "must stand beside the other of the two");
  }
}

void bind_limits(Section& section, SimulateCase& to) {
  control::FeedLimits& limits = to.controller.limits;
  section.table("limits", "what must hold", Need::optional, [&](Section& s) {
    s.number("force_n", to.force_limit, kNewton, positive(),
             "largest force: time above it is counted", Need::optional);
    s.number("max_feed_mm_per_s", limits.highest, kMmPerS, positive(), "largest feed",
             Need::optional);
    s.number("min_feed_mm_per_s", limits.lowest, kMmPerS, non_negative(),
             "smallest feed; above 0 the loop cannot stall", Need::optional);
    std::optional<double> acceleration;
    s.number("max_acceleration_mm_per_s2", acceleration, kMmPerS2, positive(),
             "largest change of the commanded feed; absent: any");
    if (acceleration) limits.acceleration = *acceleration;
    bind_plan_limits(s, to.predictive_options.limits, to.temperature_limit);
    if (limits.lowest > limits.highest) {
      s.fault("min_feed_mm_per_s", "must not be greater than max_feed_mm_per_s");
    }
  });
}

void bind_chatter(Section& section, control::ChatterLimits& chatter) {
  section.table("chatter", "speeds and depths that do not chatter, for \"model-predictive\"",
                Need::optional, [&](Section& s) {
                  std::vector<double> speeds, depths;
                  s.numbers("spindle_speeds_rpm", speeds, kRpm, positive(), "rising");
                  s.numbers("stable_depths_mm", depths, kMm, positive(),
                            "one a speed: see osteomill stability");
                  s.number(
                      "gain_n_per_mm_per_s", chatter.gain, {1e3, "N/(mm/s)"}, positive(),
                      "mean force over feed of the bone that they hold for, cut depth_mm deep");
                  std::optional<double> depth;
                  s.number("depth_mm", depth, kMm, positive(),
                           "depth at which gain_n_per_mm_per_s was measured; absent: that of a "
                           "line-profile");
                  if (depth) chatter.depth = *depth;
                  s.number("margin", chatter.margin, kPlain, positive(),
                           "stable depth over depth of the cut", Need::optional);
                  if (speeds.size() != depths.size())
                    s.fault("stable_depths_mm", "must be as many as speeds");
                  for (std::size_t i = 0; i < std::min(speeds.size(), depths.size()); ++i) {
                    chatter.lobes.push_back({speeds[i], depths[i]});
                  }
                });
}

void bind_machine(Section& section, simulate::Machine& machine) {
  section.table("machine", "servo and sensor", Need::optional, [&](Section& s) {
    numerics::SecondOrderLag servo = kDefaultServo;
    bool ideal = false;
    s.flag("ideal_servo", ideal, "the feed is the command at once");
    if (s.when(!ideal)) {
      s.number("servo_frequency_rad_per_s", servo.natural_frequency, {1.0, "rad/s"}, positive(),
               "natural frequency of the feed servo", Need::optional);
      s.number("servo_damping_ratio", servo.damping_ratio, kPlain, positive(),
               "damping ratio of the feed servo", Need::optional);
      machine.servo = servo;
    }
    if (ideal) machine.servo.reset();
    simulate::SpindleDrive spindle;
    if (s.table("spindle", "a spindle whose speed the model-predictive law may set; absent: none",
                Need::optional, [&](Section& below) {
                  below.number("min_rpm", spindle.lowest, kRpm, positive(), "slowest speed");
                  below.number("max_rpm", spindle.highest, kRpm, positive(), "fastest speed");
                  below.number("time_constant_s", spindle.time_constant, {1.0, "s"}, positive(),
                               "of the drive, a first-order lag", Need::optional);
                })) {
      machine.spindle = spindle;
    }
    s.number("sample_rate_hz", machine.sample_rate, {1.0, "Hz"}, positive(), "of the force sensor",
             Need::optional);
    s.number("start_feed_mm_per_s", machine.start_feed, kMmPerS, non_negative(),
             "feed at the start", Need::optional);
    s.number("force_noise_n", machine.force_noise, kNewton, non_negative(),
             "standard deviation of each mean force", Need::optional);
    s.integer("delay_updates", machine.delay_updates, between(1, 100),
              "control periods from a force to the feed that it sets", Need::optional);
    int seed = 1;
    s.integer("seed", seed, between(0, 2147483647), "of the noise", Need::optional);
    machine.seed = static_cast<std::uint64_t>(seed);
  });
}

void bind_heat(Section& section, std::optional<simulate::BoneHeatOptions>& heat) {
  simulate::BoneHeatOptions options;
  double initial = options.field.initial_temperature - thermal::kZeroCelsius;
  double coolant = options.field.coolant_temperature - thermal::kZeroCelsius;
  const Quantity celsius{1.0, "°C"}, plain_transfer{1.0, "W/(m² K)"}, sink{1.0, "W/(m³ K)"};
  if (!section.table("heat", "temperature of the bone; absent: not worked out", Need::optional,
                     [&](Section& s) {
                       s.number("spacing_mm", options.spacing, kMm, up_to(5.0),
                                "edge of a cell of the temperature field", Need::optional);
                       s.number("margin_mm", options.margin, kMm, non_negative(),
                                "bone around what the cutter reaches", Need::optional);
                       s.number("initial_temperature_c", initial, celsius, between(-50, 100),
                                "of the bone", Need::optional);
                       s.number("coolant_temperature_c", coolant, celsius, between(-50, 100),
                                "of the air or the irrigation", Need::optional);
                       s.number("convection_w_per_m2_k", options.field.convection, plain_transfer,
                                non_negative(),
                                "at open bone: air 10, drip 100-1000, jet 1000-10000",
                                Need::optional);
                       s.number("perfusion_w_per_m3_k", options.field.perfusion, sink,
                                non_negative(), "heat that blood carries off", Need::optional);
                       bind_partition(s, options.partition);
                     })) {
    return;
  }
  options.field.initial_temperature = initial + thermal::kZeroCelsius;
  options.field.blood_temperature = options.field.initial_temperature;
  options.field.coolant_temperature = coolant + thermal::kZeroCelsius;
  heat = options;
}

}  // namespace

void prepare(SimulateCase& to, const CaseRun& run) {
  to.name = run.name;
  to.machine.servo = kDefaultServo;
}

void complete(SimulateCase& made) {
  made.machine.period = made.controller.period;
  made.machine.flutes = made.cutter.cutter.flutes;
  made.machine.spindle_speed = made.path.spindle_speed;
  if (control::SugitaLoop* loop = std::get_if<control::SugitaLoop>(&made.controller.law)) {
    loop->full_feed = made.controller.limits.highest;
  }
  if (made.model_adaptive) {
    // The law knows the machine that it runs on; an ideal servo is as good as a very fast one.
    made.model_options.servo = made.machine.servo.value_or(kVeryFastServo);
    made.model_options.period = made.controller.period;
    made.model_options.force_limit = made.force_limit;
    made.controller.law = control::ModelAdaptive(made.model_options);
  }
  made.machine.map_offset = made.map.offset;
  if (made.controller.predictive) {
    double& uncertainty = made.controller.predictive->uncertainty;
    uncertainty = std::max(uncertainty, made.map.trust.position_error);
  }
  simulate::LineProfile& profile = made.stock.profile;
  profile.cutter_radius = made.cutter.cutter.radius;
  profile.flutes = made.cutter.cutter.flutes;
  profile.programmed_feed = made.path.feed;
  profile.spindle_speed = made.path.spindle_speed;
  FaultList faults;
  if (made.stock.kind != StockKind::line_profile) {
    faults.gather([&] { settle(made.bone, made.cutter.cutter, made.path.spindle_speed); });
  }
  if (made.stock.kind == StockKind::line_profile) faults.gather([&] { simulate::check(profile); });
  if (made.finish && !made.regions.plan)
    faults.gather([] {
      throw InvalidInput(Fault{"finish", "no [plan]", "needs a [plan] to be measured against",
                               "give the plan, or take [finish] out"});
    });
  if (made.path.spindle_speed > 0.0) faults.gather([&] { simulate::check(made.machine); });
  faults.gather([&] { control::check(made.controller); });
  control::ChatterLimits& chatter = made.predictive_options.chatter;
  if (chatter.depth == 0.0 && made.stock.kind == StockKind::line_profile) {
    chatter.depth = profile.axial_depth;
  }
  if (chatter.depth == 0.0 && !chatter.lobes.empty()) {
    faults.gather([] {
      throw InvalidInput(Fault{"chatter.depth_mm", "absent",
                               "must say at which depth gain_n_per_mm_per_s was measured",
                               "osteomill force gives the mean force at a depth and a feed"});
    });
  }
  if (made.temperature_limit && !(made.heat && made.model_predictive)) {
    faults.gather([] {
      throw InvalidInput(Fault{"limits.temperature_c", "",
                               "needs [heat] and controller.kind = \"model-predictive\"",
                               "supervisor.temperature_c stops at a temperature"});
    });
  }
  if (made.machine.spindle && !made.model_predictive) {
    faults.gather([&] {
      throw InvalidInput(Fault{"machine.spindle", "", "is set by no law but \"model-predictive\"",
                               "leave it out"});
    });
  }
  faults.raise();
}

void bind_simulate(Section& section, SimulateCase& to) {
  bind_stock(section, to.stock);
  bind_path(section, to.path, to.stock);
  bind_cutter(section, to.cutter);
  if (section.when(to.stock.kind != StockKind::line_profile)) {
    bind_regions(section, to.regions);
    bind_bone(section, to.bone);
    bind_heat(section, to.heat);
    bind_finish(section, to.finish);
    ToolCase tool;
    if (bind_tool(section, tool, Need::optional)) to.tool = tool;
  }
  bind_controller(section, to);
  bind_map(section, to.map);
  bind_chatter(section, to.predictive_options.chatter);
  bind_limits(section, to);
  bind_machine(section, to.machine);
}

void bind_simulate_keys(Section& section) {
  SimulateCase unused;
  bind_simulate(section, unused);
}

std::vector<SimulateCase> read_simulate_cases(const std::vector<CaseRun>& runs) {
  std::vector<SimulateCase> cases;
  FaultList faults;
  for (const CaseRun& run : runs) {
    faults.gather([&] {
      SimulateCase made;
      prepare(made, run);
      made.expanded = Section::read(run, [&](Section& section) { bind_simulate(section, made); });
      complete(made);
      cases.push_back(std::move(made));
    });
  }
  faults.raise();
  return cases;
}

}  // namespace osteomill::io
