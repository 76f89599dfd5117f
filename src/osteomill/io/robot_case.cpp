// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/robot_case.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/catalogue.hpp"
#include "osteomill/io/profile_drawing.hpp"

namespace osteomill::io {
namespace {

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kDeg{units::deg, "deg"};
constexpr Quantity kShare{1.0, "of AP"};

void joint_range(Section& section, const char* key, robot::JointRange& range, const char* meaning) {
  std::vector<double> values{range.low, range.high};
  section.numbers(key, values, kDeg, between(-720.0, 720.0), meaning, Need::optional);
  if (values.size() != 2) {
    section.fault(key, "must be [low, high]");
  } else {
    range = {values[0], values[1]};
  }
}

void length_range(Section& section, const char* key, double& low, double& high,
                  const char* meaning) {
  std::vector<double> values{low, high};
  section.numbers(key, values, kMm, between(-1000.0, 1000.0), meaning, Need::optional);
  if (values.size() != 2 || values[0] >= values[1]) {
    section.fault(key, "must be [low, high] with low < high");
  } else {
    low = values[0];
    high = values[1];
  }
}

}  // namespace

void bind_implant_family(Section& section, robot::ImplantFamily& family) {
  section.numbers("anteroposterior_mm", family.anteroposterior, kMm, between(5.0, 200.0),
                  "anteroposterior dimension AP of each size, growing");
  section.number("distal_half_length", family.distal_half_length, kShare, between(0.05, 0.45),
                 "half of the distal cut", Need::optional);
  section.number("anterior", family.anterior, kShare, up_to(1.0),
                 "height of the anterior cut at its chamfer", Need::optional);
  section.number("posterior", family.posterior, kShare, up_to(1.0),
                 "depth of the posterior cut at its chamfer", Need::optional);
  section.number("anterior_chamfer_deg", family.anterior_chamfer_angle, kDeg, between(10.0, 80.0),
                 "between distal cut and anterior chamfer", Need::optional);
  section.number("posterior_chamfer_deg", family.posterior_chamfer_angle, kDeg, between(10.0, 80.0),
                 "between distal cut and posterior chamfer", Need::optional);
  section.number("anterior_tilt_deg", family.anterior_tilt, kDeg, between(-15.0, 30.0),
                 "of the anterior cut, opening proximally", Need::optional);
  section.number("posterior_tilt_deg", family.posterior_tilt, kDeg, between(-15.0, 30.0),
                 "of the posterior cut, opening proximally", Need::optional);
  section.number("anterior_length", family.anterior_length, kShare, up_to(2.0),
                 "of the anterior cut", Need::optional);
  section.number("posterior_length", family.posterior_length, kShare, up_to(2.0),
                 "of the posterior cut", Need::optional);
  section.free_table("provenance", "source, how obtained, condition");
}

robot::ImplantFamily implant_family(const std::string& name) {
  robot::ImplantFamily family;
  CaseRun entry{name, catalogue_entry("implants", name), {}};
  Section::read(entry, [&](Section& section) { bind_implant_family(section, family); });
  family.name = name;
  robot::check(family);
  return family;
}

void bind_implant(Section& section, ImplantCase& implant) {
  section.exactly_one_of({"family", "dimensions", "profile", "drawing"});
  section.text("family", implant.family, "name of an entry of data/implants", Need::optional);
  robot::ImplantFamily own;
  own.name = "own dimensions";
  if (section.table("dimensions", "a family of profiles by its dimensions", Need::optional,
                    [&](Section& table) { bind_implant_family(table, own); })) {
    implant.dimensions = own;
  }
  section.table("profile", "six corners, from the anterior cut around to the posterior cut",
                Need::optional, [&](Section& table) {
                  table.numbers("x_mm", implant.profile_x, kMm, between(-500.0, 500.0),
                                "distal coordinates");
                  table.numbers("y_mm", implant.profile_y, kMm, between(-500.0, 500.0),
                                "anterior coordinates");
                  if (implant.profile_x.size() != implant.profile_y.size()) {
                    table.fault("y_mm", "must be as many as x_mm");
                  }
                });
  section.file("drawing", implant.drawing,
               "DXF or SVG with one polyline of six corners, anterior to posterior",
               Need::optional);
  section.number("drawing_unit_mm", implant.drawing_unit, kMm, positive(),
                 "one unit of the drawing", Need::optional);
  if (section.when(section.has("family") || section.has("dimensions"))) {
    section.integer("size", implant.size, between(1, 100), "counted from the smallest");
  }
}

Implant implant_of(const ImplantCase& implant) {
  if (!implant.family.empty()) {
    const ValueTree entry = catalogue_entry("implants", implant.family);
    std::string obtained = "unknown";
    if (entry.values.contains("provenance") && entry.values["provenance"].contains("obtained")) {
      obtained = entry.values["provenance"]["obtained"].get<std::string>();
    }
    return {robot::profile_of(implant_family(implant.family), implant.size),
            fmt::format("{}, size {}", implant.family, implant.size), obtained};
  }
  if (implant.dimensions) {
    return {robot::profile_of(*implant.dimensions, implant.size),
            fmt::format("own dimensions, size {}", implant.size), "given"};
  }
  if (!implant.drawing.empty()) {
    return {robot::make_profile(read_polyline(implant.drawing, implant.drawing_unit)),
            implant.drawing.filename().string(), "drawn"};
  }
  std::vector<robot::Vector2> corners;
  for (std::size_t i = 0; i < implant.profile_x.size(); ++i) {
    corners.emplace_back(implant.profile_x[i], implant.profile_y[i]);
  }
  return {robot::make_profile(corners), "own profile", "given"};
}

void bind_guide_positioner(Section& section, robot::GuidePositioner& robot) {
  section.number("l1_mm", robot.link1, kMm, up_to(1000.0), "from the first to the second axis");
  section.number("l2_mm", robot.link2, kMm, between(0.0, 1000.0),
                 "from the second axis to the tip of the guide, slide retracted");
  section.number("slide_stroke_mm", robot.slide_stroke, kMm, between(0.0, 1000.0),
                 "travel of a sliding guide tip; 0 when it has none", Need::optional);
  section.number("tool_thickness_mm", robot.tool_thickness, kMm, between(0.0, 30.0),
                 "of blade or mill; the guide is moved outward by half of it", Need::optional);
  joint_range(section, "theta1_range_deg", robot.range1, "limits of the first joint [low, high]");
  joint_range(section, "theta2_range_deg", robot.range2, "limits of the second joint [low, high]");
  section.free_table("provenance", "source, how obtained, condition");
}

void bind_placement_options(Section& section, PlacementOptionsCase& options) {
  section.number("distal_overhang_mm", options.distal_overhang, kMm, between(0.0, 100.0),
                 "bone anterior of the distal cut in its plane", Need::optional);
  section.choice(
      "branch", options.placement.branch,
      {{"outermost", robot::BranchRule::outermost}, {"nearest", robot::BranchRule::nearest}},
      "which of the two positions of the second axis on a cut line", Need::optional);
  section.number("placement_margin_mm", options.placement.margin, kMm, between(0.0, 100.0),
                 "the place stays allowed when the axis is off by this in any direction",
                 Need::optional);
  section.number("precision_mm", options.placement.precision, kMm, between(1e-6, 10.0),
                 "of the certificate: no place is better by more", Need::optional);
}

void bind_placement_errors(Section& section, robot::PlacementErrors& errors) {
  section.number("position_sd_mm", errors.position, kMm, between(0.0, 50.0),
                 "of the first axis, each direction: the manual adjustment", Need::optional);
  section.number("varus_valgus_sd_deg", errors.varus_valgus, kDeg, between(0.0, 20.0),
                 "tilt of the axis", Need::optional);
  section.number("internal_external_sd_deg", errors.internal_external, kDeg, between(0.0, 20.0),
                 "tilt of the axis", Need::optional);
  section.number("half_width_mm", errors.half_width, kMm, between(0.0, 100.0),
                 "of the bone to each side", Need::optional);
  section.integer("samples", errors.samples, between(10, 1e7), "of the Monte Carlo",
                  Need::optional);
  int seed = static_cast<int>(errors.seed);
  section.integer("seed", seed, between(0, 2147483647), "of the Monte Carlo", Need::optional);
  errors.seed = static_cast<std::uint64_t>(seed);
}

void bind_robot_place(Section& section, RobotPlaceCase& c) {
  section.table("implant", "what is cut", Need::required,
                [&](Section& table) { bind_implant(table, c.implant); });
  section.table("robot", "the guide positioner", Need::required,
                [&](Section& table) { bind_guide_positioner(table, c.robot); });
  section.table("options", "of the placement", Need::optional, [&](Section& table) {
    bind_placement_options(table, c.options);
    table.number("error_radius_mm", c.error_radius, kMm, between(0.0, 100.0),
                 "also find the best place that may be off by this in any direction");
  });
  section.table("errors", "of the robot's place, for the Monte Carlo", Need::optional,
                [&](Section& table) { bind_placement_errors(table, c.errors); });
  section.table("map", "of the largest gap over the place, drawn with -o", Need::optional,
                [&](Section& table) {
                  length_range(table, "x_mm", c.map_x_low, c.map_x_high, "distal [low, high]");
                  length_range(table, "y_mm", c.map_y_low, c.map_y_high, "anterior [low, high]");
                  table.number("step_mm", c.map_step, kMm, positive(), "between grid points",
                               Need::optional);
                });
}

void bind_robot_size(Section& section, RobotSizeCase& c) {
  PlacementOptionsCase options;
  section.table("size", "the link lengths to compare", Need::required, [&](Section& table) {
    table.texts("families", c.families, "entries of data/implants");
    length_range(table, "l1_mm", c.study.l1_low, c.study.l1_high,
                 "first to second axis [low, high]");
    length_range(table, "l2_mm", c.study.l2_low, c.study.l2_high,
                 "second axis to guide tip [low, high]");
    table.number("step_mm", c.study.step, kMm, positive(), "of the grid", Need::optional);
    table.flag("refine", c.study.refine, "improve the best pairs of the grid continuously");
    table.number("slide_stroke_mm", c.study.slide_stroke, kMm, between(0.0, 1000.0),
                 "travel of a sliding guide tip; 0 when it has none", Need::optional);
    table.number("tool_thickness_mm", c.study.cuts.tool_thickness, kMm, between(0.0, 30.0),
                 "of blade or mill", Need::optional);
  });
  section.table("options", "of the placement", Need::optional,
                [&](Section& table) { bind_placement_options(table, options); });
  robot::PlacementErrors errors;
  if (section.table("errors", "of the robot's place: the study again with a margin for them",
                    Need::optional, [&](Section& table) {
                      bind_placement_errors(table, errors);
                      table.number("kept_share", c.kept_share, {1.0, ""}, between(0.01, 0.999),
                                   "of the samples that every placement shall keep allowed",
                                   Need::optional);
                    })) {
    c.errors = errors;
  }
  c.study.cuts.distal_overhang = options.distal_overhang;
  c.study.branch = options.placement.branch;
  c.study.margin = options.placement.margin;
}

namespace {

/// An axis behind A2's link: a further link, or a slide.
void bind_planar_axis(Section& table, robot::PlanarAxis& axis) {
  table.choice("kind", axis.kind,
               {{"revolute", robot::AxisKind::revolute}, {"prismatic", robot::AxisKind::prismatic}},
               "turns a link, or slides");
  const bool slides = axis.kind == robot::AxisKind::prismatic;
  if (table.when(!slides)) {
    double stiffness = robot::size8_secant_stiffness();
    table.number("length_mm", axis.length, kMm, between(0.0, 1000.0), "of the link that it turns");
    robot::JointRange range = axis.range;
    joint_range(table, "range_deg", range, "limits of the joint [low, high]");
    table.number("stiffness_nm_per_rad", stiffness, {1.0, "N m/rad"}, non_negative(),
                 "of the axis; 0: rigid; default: 0.1 deg at 2 N m, [plaskos2006] 5.4",
                 Need::optional);
    if (!slides) {
      axis.range = range;
      axis.stiffness = stiffness;
    }
  }
  if (table.when(slides)) {
    double low = 0.0, high = 0.04, stiffness = 0.0;
    table.number("direction_deg", axis.direction, kDeg, between(-180.0, 180.0),
                 "of travel, from the link before it, anticlockwise", Need::optional);
    length_range(table, "range_mm", low, high, "travel [low, high]");
    table.number("stiffness_n_per_mm", stiffness, {units::n_per_mm, "N/mm"}, non_negative(),
                 "of the slide; 0: rigid", Need::optional);
    if (slides) {
      axis.range = {low, high};
      axis.stiffness = stiffness;
    }
  }
}

}  // namespace

void bind_robot_position(Section& section, RobotPositionCase& c) {
  section.table("implant", "what is cut", Need::required,
                [&](Section& table) { bind_implant(table, c.implant); });
  section.table("robot", "the guide positioner", Need::required,
                [&](Section& table) { bind_guide_positioner(table, c.robot); });
  section.table("options", "of the placement", Need::optional,
                [&](Section& table) { bind_placement_options(table, c.options); });
  section.tables("further_axis", "axes between the second link and the slide, in the plane of cuts",
                 Need::optional, [&](Section& table, std::size_t) {
                   robot::PlanarAxis axis;
                   bind_planar_axis(table, axis);
                   c.further.push_back(axis);
                 });
  c.chain = section.table(
      "chain", "solve for all axes together: both branches, limits, slide", Need::optional,
      [&](Section& table) {
        table.choice("redundancy", c.redundancy,
                     {{"joint-centre", robot::Redundancy::joint_centre},
                      {"smallest-displacement", robot::Redundancy::smallest_displacement},
                      {"stiffest", robot::Redundancy::stiffest}},
                     "what the freedom that a cut leaves is used for", Need::optional);
        table.number("stiffness1_nm_per_rad", c.stiffness1, {1.0, "N m/rad"}, non_negative(),
                     "of A1; 0: rigid; default: 0.1 deg at 2 N m, [plaskos2006] 5.4",
                     Need::optional);
        table.number("stiffness2_nm_per_rad", c.stiffness2, {1.0, "N m/rad"}, non_negative(),
                     "of A2", Need::optional);
        table.number("slide_stiffness_n_per_mm", c.slide_stiffness, {units::n_per_mm, "N/mm"},
                     non_negative(), "of the slide; 0: rigid", Need::optional);
      });
  c.chain = c.chain || !c.further.empty();
  section.table("axis", "where the first axis is; the best place when absent", Need::optional,
                [&](Section& table) {
                  table.number("x_mm", c.axis_x, kMm, between(-500.0, 500.0), "distal");
                  table.number("y_mm", c.axis_y, kMm, between(-500.0, 500.0), "anterior");
                  if (table.has("x_mm") != table.has("y_mm")) {
                    table.fault("y_mm", "must stand together with x_mm");
                  }
                });
  section.table("sequence", "order of the cuts and the way between them", Need::optional,
                [&](Section& table) {
                  table.texts("order", c.order,
                              "distal, anterior_chamfer, anterior, posterior_chamfer, posterior",
                              Need::optional);
                  table.number("clearance_mm", c.sequence.clearance, kMm, between(0.0, 100.0),
                               "to keep from the bone between cuts", Need::optional);
                  table.number("joint_step_deg", c.sequence.joint_step, kDeg, between(0.1, 20.0),
                               "of the search for a way", Need::optional);
                  table.number("bone_cover_mm", c.bone_cover, kMm, between(0.0, 50.0),
                               "bone outside of the profile; 0: what the overhang implies",
                               Need::optional);
                  c.sequence.order.clear();
                  for (const std::string& one : c.order) {
                    bool known = false;
                    for (const robot::Cut cut : robot::kCuttingOrder) {
                      if (one != robot::name(cut)) continue;
                      c.sequence.order.push_back(cut);
                      known = true;
                    }
                    if (!known) {
                      table.fault("order", "must name cuts; \"" + one + "\" is none",
                                  "known: distal, anterior_chamfer, anterior, posterior_chamfer, "
                                  "posterior");
                    }
                  }
                });
  section.table("joints", "gears and sensors", Need::optional, [&](Section& table) {
    table.number("play1_deg", c.play1, kDeg, between(0.0, 10.0), "backlash of the first axis",
                 Need::optional);
    table.number("play2_deg", c.play2, kDeg, between(0.0, 10.0), "backlash of the second axis",
                 Need::optional);
    table.number("gear1", c.gear1, {1.0, "motor turns a joint turn"}, positive(),
                 "reduction of the first axis", Need::optional);
    table.number("gear2", c.gear2, {1.0, "motor turns a joint turn"}, positive(),
                 "reduction of the second axis", Need::optional);
    table.number("zero1_deg", c.zero1, kDeg, any(), "Hall reading where theta1 = 0",
                 Need::optional);
    table.number("zero2_deg", c.zero2, kDeg, any(), "Hall reading where theta2 = 0",
                 Need::optional);
  });
}

void bind_robot_place_keys(Section& section) {
  RobotPlaceCase c;
  bind_robot_place(section, c);
}

void bind_robot_size_keys(Section& section) {
  RobotSizeCase c;
  bind_robot_size(section, c);
}

void bind_robot_position_keys(Section& section) {
  RobotPositionCase c;
  bind_robot_position(section, c);
}

}  // namespace osteomill::io
