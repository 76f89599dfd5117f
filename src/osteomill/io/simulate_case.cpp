// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_case.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
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
constexpr Quantity kDensity{1.0, "kg/m3"};
constexpr Quantity kGain{1e3, "N/(mm/s)"};
constexpr Quantity kPlain{};
constexpr numerics::SecondOrderLag kDefaultServo{118.0, 0.7};
constexpr numerics::SecondOrderLag kVeryFastServo{5000.0, 1.0};

void bind_zone(Section& s, simulate::ProfileZone& zone, double length) {
  s.number("from_mm", zone.from, kMm, non_negative(),
           "start of the zone from the edge of the bone");
  s.number("to_mm", zone.to, kMm, positive(), "end of the zone");
  s.number("gain_n_per_mm_per_s", zone.gain, kGain, non_negative(),
           "cutting force per feed, K of F = K v");
  s.number("gain_end_n_per_mm_per_s", zone.gain_end, kGain, non_negative(),
           "gain at the end of the zone, linear between; absent: constant");
  std::vector<double> numbers;
  s.numbers("lines", numbers, kPlain, between(1, 1000), "lines that have the zone; absent: all",
            Need::optional);
  for (const double number : numbers) zone.lines.push_back(static_cast<int>(number));
  // 1 um: rounding of mm.
  if (zone.to <= zone.from) s.fault("to_mm", "must be greater than from_mm");
  if (zone.to > length + 1e-6) {
    s.fault("to_mm", fmt::format("must be <= stock.length_mm = {:g} mm", length / units::mm));
  }
}

void bind_line_profile(Section& s, StockCase& stock) {
  simulate::LineProfile& profile = stock.profile;
  s.number("length_mm", profile.line_length, kMm, positive(), "length of bone under each line",
           Need::optional);
  s.number("peak_to_mean", profile.peak_to_mean, kPlain, between(1.0, 2.0),
           "largest over mean force within a tooth period", Need::optional);
  s.number("edge_force_n", profile.edge_force, kNewton, non_negative(),
           "mean force at any feed while fully engaged", Need::optional);
  s.tables("zones", "material along the lines; a later zone holds over an earlier one",
           Need::required, [&](Section& zone, std::size_t) {
             simulate::ProfileZone to;
             bind_zone(zone, to, profile.line_length);
             profile.zones.push_back(to);
           });
}

void bind_box(Section& s, StockCase& stock) {
  s.triple("lower_mm", stock.lower, kMm, any(), "lower corner in the work frame");
  s.triple("upper_mm", stock.upper, kMm, any(), "upper corner in the work frame");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (s.has("lower_mm") && s.has("upper_mm") && !(stock.upper[axis] > stock.lower[axis])) {
      s.fault("upper_mm", "must be greater than lower_mm on every axis");
      break;
    }
  }
}

void bind_tibia(Section& s, workpiece::TibiaSection& tibia) {
  s.number("length_mm", tibia.length, kMm, positive(), "size along x", Need::optional);
  s.number("width_mm", tibia.width, kMm, positive(), "size along y", Need::optional);
  s.number("height_mm", tibia.height, kMm, positive(), "size below z = 0", Need::optional);
  s.number("rim_mm", tibia.rim, kMm, positive(), "thickness of the cortical rim", Need::optional);
  s.number("graded_mm", tibia.graded, kMm, non_negative(),
           "width inside the rim over which the bone softens linearly", Need::optional);
  s.number("cortical_density_kg_per_m3", tibia.cortical.density, kDensity, positive(),
           "density of the rim", Need::optional);
  s.number("cancellous_density_kg_per_m3", tibia.cancellous.density, kDensity, positive(),
           "density inside", Need::optional);
  s.number("cortical_force_scale", tibia.cortical.force_scale, kPlain, non_negative(),
           "cutting force of the rim relative to [bone]", Need::optional);
  s.number("cancellous_force_scale", tibia.cancellous.force_scale, kPlain, non_negative(),
           "cutting force inside relative to [bone]", Need::optional);
}

void bind_ct(Section& s, StockCase& stock) {
  s.file("file", stock.file, "CT: DICOM folder, NIfTI, NRRD, MetaImage or InVesalius project");
  s.text("series", stock.series, "which series of a DICOM folder", Need::optional);
  s.triple("origin_mm", stock.origin, kMm, any(), "origin of the work frame in the patient frame");
  s.triple("x_axis", stock.x_axis, kPlain, any(), "x of the work frame in the patient frame",
           Need::optional);
  s.triple("z_axis", stock.z_axis, kPlain, any(),
           "z of the work frame, towards the spindle, in the patient frame", Need::optional);
  workpiece::BoneFromCt& bone = stock.bone_from_ct;
  s.number("threshold_hu", bone.threshold_hu, {1.0, "HU"}, between(-1000, 4000), "bone from here",
           Need::optional);
  s.number("density_at_0_hu_kg_per_m3", bone.density.at_zero.value, kDensity, any(),
           "apparent density at 0 HU", Need::optional);
  s.number("density_per_hu_kg_per_m3", bone.density.per_hounsfield.value, kDensity, positive(),
           "apparent density for each HU", Need::optional);
}

void bind_stock(Section& section, StockCase& stock) {
  section.table("stock", "bone before the cut", Need::required, [&](Section& s) {
    s.choice<StockKind>("kind", stock.kind,
                        {{"line-profile", StockKind::line_profile},
                         {"block", StockKind::block},
                         {"tibia-section", StockKind::tibia_section},
                         {"ct", StockKind::ct}},
                        "what the bone is given by");
    s.text("note", stock.note, "what the reader of the result has to know of it", Need::optional);
    if (s.when(stock.kind == StockKind::line_profile)) bind_line_profile(s, stock);
    if (s.when(stock.kind == StockKind::block || stock.kind == StockKind::ct)) bind_box(s, stock);
    if (s.when(stock.kind == StockKind::block)) {
      s.number("density_kg_per_m3", stock.density, kDensity, positive(), "density of the block");
      s.number("force_scale", stock.force_scale, kPlain, non_negative(),
               "cutting force relative to [bone]; absent: by density");
    }
    if (s.when(stock.kind == StockKind::tibia_section)) bind_tibia(s, stock.tibia);
    if (s.when(stock.kind == StockKind::ct)) bind_ct(s, stock);
    if (s.when(stock.kind != StockKind::line_profile)) {
      s.number("spacing_mm", stock.spacing, kMm, up_to(5.0), "edge of a voxel", Need::optional);
      // The largest stock that is taken: 400 million voxels, about 2 GB.
      double voxels = 1.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        voxels *= std::max(0.0, stock.upper[axis] - stock.lower[axis]) / stock.spacing;
      }
      if (voxels > 4e8) {
        s.fault("spacing_mm", fmt::format("makes {:.2g} voxels; at most 4e+08 are taken", voxels),
                "use a larger spacing or a smaller region");
      }
    }
  });
}

void bind_path(Section& section, PathCase& path, simulate::LineProfile& profile, StockKind stock) {
  section.table("path", "what the cutter is to do", Need::required, [&](Section& s) {
    const bool profiled = stock == StockKind::line_profile;
    if (s.when(!profiled)) {
      s.choice<PathKind>("kind", path.kind,
                         {{"lines", PathKind::lines},
                          {"zigzag", PathKind::zigzag},
                          {"points", PathKind::points},
                          {"gcode", PathKind::gcode}},
                         "how the path is given");
    }
    const bool gcode = !profiled && path.kind == PathKind::gcode;
    if (s.when(!gcode)) {
      s.number("feed_mm_per_s", path.feed, kMmPerS, up_to(1000.0), "programmed feed");
      s.number("spindle_speed_rpm", path.spindle_speed, kRpm, up_to(200000.0), "spindle speed");
    }
    if (s.when(profiled)) {
      s.integer("lines", profile.lines, between(1, 1000), "number of lines", Need::optional);
      s.number("lead_in_mm", profile.lead_in, kMm, non_negative(), "air before each line",
               Need::optional);
      s.number("lead_out_mm", profile.lead_out, kMm, non_negative(), "air behind each line",
               Need::optional);
      s.number("radial_depth_mm", profile.radial_depth, kMm, positive(), "radial depth of cut",
               Need::optional);
      s.number("axial_depth_mm", profile.axial_depth, kMm, positive(), "axial depth of cut",
               Need::optional);
    }
    if (s.when(!profiled)) {
      s.number("rapid_mm_per_s", path.rapid_feed, kMmPerS, up_to(1000.0), "feed of rapid moves",
               Need::optional);
    }
    if (s.when(!profiled && (path.kind == PathKind::lines || path.kind == PathKind::zigzag))) {
      s.triple("start_mm", path.start, kMm, any(), "tip at the start of the first line");
      s.triple("along_mm", path.along, kMm, any(), "from the start to the end of a line");
      s.triple("step_over_mm", path.step_over, kMm, any(), "from one line to the next",
               Need::optional);
      s.integer("count", path.lines, between(1, 10000), "number of lines", Need::optional);
      s.number("clearance_mm", path.clearance, kMm, positive(), "height of the way back",
               Need::optional);
    }
    if (s.when(!profiled && path.kind == PathKind::points)) {
      s.tables("points", "corners of the path of the tip", Need::required,
               [&](Section& point, std::size_t) {
                 std::array<double, 3> at{};
                 point.number("x_mm", at[0], kMm, any(), "x in the work frame");
                 point.number("y_mm", at[1], kMm, any(), "y in the work frame");
                 point.number("z_mm", at[2], kMm, any(), "z in the work frame");
                 path.points.push_back(at);
               });
      if (s.has("points") && path.points.size() == 1) s.fault("points", "must be two or more");
    }
    if (s.when(gcode)) s.file("file", path.file, "G-code program");
  });
}

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

void bind_controller(Section& section, control::FeedController& controller, bool& adaptive,
                     control::ModelAdaptiveOptions& options) {
  enum class Law { constant, sugita, model_adaptive };
  section.table("controller", "what sets the feed", Need::required, [&](Section& s) {
    Law law = Law::constant;
    s.choice<Law>("kind", law,
                  {{"constant", Law::constant},
                   {"sugita", Law::sugita},
                   {"model-adaptive", Law::model_adaptive}},
                  "constant feed, the published force loop, or the law that identifies the bone");
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
      bind_model_adaptive(s, options);
      adaptive = law == Law::model_adaptive;
    }
    control::PredictiveMode mode;
    if (s.table("predictive", "slow entry into bone; absent: none", Need::optional,
                [&](Section& below) { bind_predictive(below, mode); })) {
      controller.predictive = mode;
    }
  });
}

void bind_limits(Section& section, control::FeedLimits& limits, double& force) {
  section.table("limits", "what must hold", Need::optional, [&](Section& s) {
    s.number("force_n", force, kNewton, positive(), "largest force: time above it is counted",
             Need::optional);
    s.number("max_feed_mm_per_s", limits.highest, kMmPerS, positive(), "largest feed",
             Need::optional);
    s.number("min_feed_mm_per_s", limits.lowest, kMmPerS, non_negative(),
             "smallest feed; above 0 the loop cannot stall", Need::optional);
    std::optional<double> acceleration;
    s.number("max_acceleration_mm_per_s2", acceleration, kMmPerS2, positive(),
             "largest change of the commanded feed; absent: any");
    if (acceleration) limits.acceleration = *acceleration;
    if (limits.lowest > limits.highest) {
      s.fault("min_feed_mm_per_s", "must not be greater than max_feed_mm_per_s");
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
                       s.number("rubbing_to_bone", options.partition.rubbing_to_bone, kPlain,
                                between(0, 1), "share of the rubbing heat", Need::optional);
                       s.number("shear_strain", options.partition.shear_strain, kPlain, positive(),
                                "of the chip", Need::optional);
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
  simulate::LineProfile& profile = made.stock.profile;
  profile.cutter_radius = made.cutter.cutter.radius;
  profile.flutes = made.cutter.cutter.flutes;
  profile.programmed_feed = made.path.feed;
  FaultList faults;
  if (made.stock.kind == StockKind::line_profile) faults.gather([&] { simulate::check(profile); });
  if (made.path.spindle_speed > 0.0) faults.gather([&] { simulate::check(made.machine); });
  faults.gather([&] { control::check(made.controller); });
  faults.raise();
}

void bind_simulate(Section& section, SimulateCase& to) {
  bind_stock(section, to.stock);
  bind_path(section, to.path, to.stock.profile, to.stock.kind);
  bind_cutter(section, to.cutter);
  if (section.when(to.stock.kind != StockKind::line_profile)) {
    bind_bone(section, to.bone);
    bind_heat(section, to.heat);
  }
  bind_controller(section, to.controller, to.model_adaptive, to.model_options);
  bind_limits(section, to.controller.limits, to.force_limit);
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
