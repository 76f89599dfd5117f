// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/robot_chain_case.hpp"

#include <Eigen/Geometry>
#include <numbers>

#include "osteomill/base/units.hpp"

namespace osteomill::io {
namespace {

using robot::Vector3;

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kDeg{units::deg, "deg"};
constexpr Quantity kNewton{1.0, "N"};

Vector3 triple(Section& section, const char* key, Quantity quantity, const Vector3& before,
               const char* meaning, Need need = Need::optional) {
  std::array<double, 3> values{before.x(), before.y(), before.z()};
  section.triple(key, values, quantity, any(), meaning, need);
  return {values[0], values[1], values[2]};
}

Vector3 direction(Section& section, const char* key, const Vector3& before, const char* meaning) {
  const Vector3 v = triple(section, key, {1.0, ""}, before, meaning);
  if (!(v.norm() > 1e-9)) {
    section.fault(key, "must not be zero");
    return before;
  }
  return v.normalized();
}

robot::Pose pose(Section& section) {
  robot::Pose pose = robot::Pose::Identity();
  pose.translation() = triple(section, "position_mm", kMm, Vector3::Zero(), "of the origin");
  const Vector3 turn = triple(section, "turn_deg", kDeg, Vector3::Zero(), "rotation vector");
  if (turn.norm() > 0.0) {
    pose.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  }
  return pose;
}

/// The name of a robot and its dimensions; returns the name, empty when there is none.
std::string bind_model(Section& table, robot::SerialChain& chain, Need need) {
  std::string model;
  table.text("model", model, "seven-axis: the robot of Sugita 2009", need);
  if (!table.when(!model.empty())) return model;
  robot::SevenAxisDimensions d;
  const auto constant = [&](const char* key, double& value) {
    table.number(key, value, kMm, any(), "constant of eq. 2; a placeholder", Need::optional);
  };
  constant("c2_mm", d.c2);
  constant("c3_mm", d.c3);
  constant("c4_mm", d.c4);
  constant("c5_mm", d.c5);
  d.g9 = triple(table, "g9_mm", kMm, d.g9, "tool vector of eq. 2; a placeholder");
  if (model == "seven-axis") {
    chain = robot::seven_axis_robot(d);
  } else if (!model.empty()) {
    table.fault("model", "must be seven-axis; other robots of `robot reach` list joints");
  }
  return model;
}

enum class PartKind { fixation, spring, gear, tube, beam };

robot::Compliance part_of(Section& section) {
  std::string name;
  PartKind kind = PartKind::spring;
  section.text("name", name, "of the part");
  section.choice("kind", kind,
                 {{"fixation", PartKind::fixation},
                  {"spring", PartKind::spring},
                  {"gear", PartKind::gear},
                  {"tube", PartKind::tube},
                  {"beam", PartKind::beam}},
                 "fixation: pins in bone; spring: gives way in translation; gear: turns about an "
                 "axis; tube: the milling tube with the cutter's shaft; beam: a round cantilever");
  const Vector3 at = triple(section, "at_mm", kMm, Vector3::Zero(),
                            "where it is: the spring, the gear's axis, the root of tube and beam");
  robot::Compliance part{name, at, robot::Matrix6::Zero()};
  if (section.when(kind == PartKind::fixation)) {
    robot::Fixation fixation = robot::Fixation::bicortical;
    double density = 0.674;
    double lever = 0.05;
    section.choice(
        "technique", fixation,
        {{"bicortical", robot::Fixation::bicortical}, {"augmented", robot::Fixation::augmented}},
        "two pins through both cortices, or through an intramedullary rod");
    section.number("mineral_density_g_per_cm2", density, {1.0, "g/cm2"}, between(0.520, 0.721),
                   "of the bone; within the tested ones");
    section.number("load_offset_mm", lever, kMm, positive(),
                   "assumed offset of the load in the tests", Need::optional);
    if (kind == PartKind::fixation) {
      part = robot::fixation_compliance(robot::fixation_at(fixation, density), at, lever);
      part.name = name;
    }
  }
  if (section.when(kind == PartKind::spring)) {
    const Vector3 k =
        triple(section, "stiffness_n_per_mm", {units::n_per_mm, "N/mm"},
               Vector3::Constant(125.0 * units::n_per_mm), "along x, y, z", Need::required);
    if (kind == PartKind::spring && k.minCoeff() > 0.0) {
      part = robot::translation_spring(name, at, k);
    } else if (kind == PartKind::spring) {
      section.fault("stiffness_n_per_mm", "must be > 0 in each direction");
    }
  }
  if (section.when(kind == PartKind::gear)) {
    double stiffness = robot::size8_secant_stiffness();
    const Vector3 axis = direction(section, "axis", Vector3::UnitZ(), "of the gear");
    section.number("stiffness_nm_per_rad", stiffness, {1.0, "N m/rad"}, positive(),
                   "of the gear; default: 0.1 deg at 2 N m, [plaskos2006] 5.4", Need::optional);
    if (kind == PartKind::gear) part = robot::hinge_spring(name, at, axis, stiffness);
  }
  if (section.when(kind == PartKind::tube || kind == PartKind::beam)) {
    double length = 0.05;
    double diameter = 0.006;
    double modulus = 197e9;
    const Vector3 along = direction(section, "along", Vector3::UnitX(), "from root to end");
    section.number("length_mm", length, kMm, up_to(1000.0), "from root to end");
    if (section.when(kind == PartKind::beam)) {
      section.number("diameter_mm", diameter, kMm, up_to(200.0), "of a full round bar");
      section.number("youngs_modulus_gpa", modulus, {units::gpa, "GPa"}, positive(), "of the bar",
                     Need::optional);
    }
    if (kind == PartKind::tube) {
      part = robot::cantilever(name, at, along, robot::milling_tube(length));
    } else if (kind == PartKind::beam) {
      robot::Beam beam;
      beam.length = length;
      beam.bending_inertia = robot::tube_inertia(diameter, 0.0);
      beam.area = 0.25 * std::numbers::pi * diameter * diameter;
      beam.youngs_modulus = modulus;
      part = robot::cantilever(name, at, along, beam);
    }
  }
  return part;
}

}  // namespace

void bind_robot_stiffness(Section& section, RobotStiffnessCase& c) {
  section.tables("part", "the chain from bone to cutter, in any order", Need::required,
                 [&](Section& table, std::size_t) { c.parts.push_back(part_of(table)); });
  section.table("load", "at the cutting edge", Need::required, [&](Section& table) {
    c.edge = triple(table, "edge_mm", kMm, Vector3::Zero(), "where the force acts", Need::required);
    if (table.when(table.has("force_n"))) {
      c.force = triple(table, "force_n", kNewton, Vector3::Zero(), "the force on the cutter");
    }
    c.feed_direction =
        direction(table, "feed_direction", Vector3::UnitX(), "of the predicted force's x");
    c.axis_direction = direction(table, "axis_direction", Vector3::UnitZ(),
                                 "from the cutter's tip to the spindle");
  });
  c.has_cut = section.has("cut");
  if (section.when(c.has_cut)) {
    bind_cutter(section, c.cutter);
    bind_bone(section, c.bone);
    bind_cut(section, c.cut);
    if (c.has_cut) c.caveats = caveats_of(c.cutter, c.bone);
  }
  if (section.when(false)) return;
  if (c.has_cut == c.force.has_value()) {
    section.fault("load.force_n", "must be given, or else [cutter] [bone] [cut] that predict it",
                  "give exactly one of the two");
  }
}

void bind_robot_stiffness_keys(Section& section) {
  RobotStiffnessCase c;
  bind_robot_stiffness(section, c);
}

void bind_robot_reach(Section& section, RobotReachCase& c) {
  section.table(
      "robot", "a serial robot: a named model or its joints", Need::required, [&](Section& table) {
        const std::string model = bind_model(table, c.chain, Need::optional);
        c.placeholders = model == "seven-axis";
        std::vector<robot::DhRow> rows;
        table.tables("joint", "Denavit-Hartenberg rows, from the base", Need::optional,
                     [&](Section& one, std::size_t) {
                       robot::DhRow row;
                       one.text("name", row.name, "of the joint");
                       one.choice("kind", row.prismatic, {{"turning", false}, {"sliding", true}},
                                  "of the joint", Need::optional);
                       one.number("a_mm", row.a, kMm, any(), "along x", Need::optional);
                       one.number("alpha_deg", row.alpha, kDeg, any(), "about x", Need::optional);
                       one.number("d_mm", row.d, kMm, any(), "along z, at zero", Need::optional);
                       one.number("theta_deg", row.theta, kDeg, any(), "about z, at zero",
                                  Need::optional);
                       const Quantity unit = row.prismatic ? kMm : kDeg;
                       std::vector<double> range{row.prismatic ? -1.0 : -180.0 * units::deg,
                                                 row.prismatic ? 1.0 : 180.0 * units::deg};
                       one.numbers(row.prismatic ? "range_mm" : "range_deg", range, unit, any(),
                                   "[low, high]", Need::optional);
                       if (range.size() == 2 && range[0] < range[1]) {
                         row.low = range[0];
                         row.high = range[1];
                       } else {
                         one.fault("range", "must be [low, high] with low < high");
                       }
                       rows.push_back(row);
                     });
        if (model.empty() && !rows.empty()) c.chain = robot::chain_from_dh(rows);
        if (c.chain.joints.empty() && !table.when(false)) {
          table.fault("model", "must be given, or joints listed");
        }
      });
  section.tables("target", "poses of the tool in the base frame", Need::required,
                 [&](Section& table, std::size_t) {
                   RobotReachCase::Target target;
                   table.text("name", target.name, "of the target");
                   target.X_BT = pose(table);
                   c.targets.push_back(target);
                 });
  section.table("options", "of the inverse", Need::optional, [&](Section& table) {
    table.flag("free_about_tool_axis", c.options.free_about_tool_axis,
               "the tool may turn about its own axis");
    c.force = triple(table, "force_n", kNewton, c.force, "on the tool, for its deflection");
    table.integer("starts", c.options.starts, between(0, 1000), "further starting points",
                  Need::optional);
  });
}

void bind_carrying_robot(Section& section, std::optional<CarryingRobot>& to) {
  section.table("robot", "that carries the tool, with --plant linuxcnc", Need::optional,
                [&](Section& table) {
                  CarryingRobot robot;
                  bind_model(table, robot.chain, Need::required);
                  table.table("work", "the work frame in the robot's base frame", Need::required,
                              [&](Section& work) { robot.X_BW = pose(work); });
                  to = robot;
                });
}

void bind_robot_reach_keys(Section& section) {
  RobotReachCase c;
  bind_robot_reach(section, c);
}

void bind_robot_tibia(Section& section, RobotTibiaCase& c) {
  section.table("guide", "its axes in the frame of its base", Need::optional, [&](Section& table) {
    c.guide.centre_B = triple(table, "centre_mm", kMm, Vector3(0.0, 10.0, 40.0) * units::mm,
                              "where the two turning axes meet");
    c.guide.slide_B = direction(table, "slide", c.guide.slide_B, "P/D slide");
    c.guide.flexion_axis_B = direction(table, "flexion_axis", c.guide.flexion_axis_B, "F/E axis");
    c.guide.varus_axis_B = direction(table, "varus_axis", c.guide.varus_axis_B, "V/V axis");
    c.guide.normal_B = direction(table, "normal", c.guide.normal_B, "of the guide's plane");
    table.number("height_mm", c.guide.height, kMm, any(), "of the plane above the centre",
                 Need::optional);
    table.number("slide_range_mm", c.guide.slide_range, kMm, positive(), "total", Need::optional);
    table.number("angle_range_deg", c.guide.angle_range, kDeg, positive(), "total", Need::optional);
  });
  section.table("base", "the guide's base in the anatomy: x lateral, y anterior, z proximal",
                Need::required, [&](Section& table) { c.X_AB = pose(table); });
  section.table("now", "joint values as they stand", Need::optional, [&](Section& table) {
    table.number("slide_mm", c.now.slide, kMm, any(), "P/D", Need::optional);
    table.number("flexion_deg", c.now.flexion, kDeg, any(), "F/E", Need::optional);
    table.number("varus_deg", c.now.varus, kDeg, any(), "V/V", Need::optional);
  });
  section.table("target", "what the screen shall show", Need::required, [&](Section& table) {
    table.number("varus_deg", c.target.varus, kDeg, between(-45.0, 45.0), "varus/valgus");
    table.number("slope_deg", c.target.slope, kDeg, between(-45.0, 45.0), "posterior slope");
    table.number("depth_mm", c.target.depth, kMm, between(-100.0, 100.0),
                 "height of the plane at the anatomy's origin");
    table.number("tolerance_deg", c.tolerance, kDeg, positive(), "of the adjustment",
                 Need::optional);
  });
}

void bind_robot_tibia_keys(Section& section) {
  RobotTibiaCase c;
  bind_robot_tibia(section, c);
}

}  // namespace osteomill::io
