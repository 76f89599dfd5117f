// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/base/units.hpp"
#include "osteomill/io/cutting_section.hpp"
#include "osteomill/io/joint_program.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/robot/compliance.hpp"
#include "osteomill/robot/fixation.hpp"
#include "osteomill/robot/serial_chain.hpp"
#include "osteomill/robot/tibial_guide.hpp"

/// The cases of `osteomill robot stiffness | reach | tibia`.
namespace osteomill::io {

struct RobotStiffnessCase {
  std::vector<robot::Compliance> parts;
  robot::Vector3 edge = robot::Vector3::Zero();
  std::optional<robot::Vector3> force;  ///< N; otherwise the predicted milling force
  bool has_cut = false;
  CutterCase cutter;
  BoneCase bone;
  CutCase cut;
  robot::Vector3 feed_direction = robot::Vector3::UnitX();  ///< of the tool frame's x
  robot::Vector3 axis_direction = robot::Vector3::UnitZ();  ///< from tip to spindle
  std::vector<std::string> caveats;
};
void bind_robot_stiffness(Section& section, RobotStiffnessCase& c);
void bind_robot_stiffness_keys(Section& section);

struct RobotReachCase {
  robot::SerialChain chain;
  bool placeholders = false;  ///< dimensions of the robot are assumed
  struct Target {
    std::string name;
    robot::Pose X_BT = robot::Pose::Identity();
  };
  std::vector<Target> targets;
  robot::InverseOptions options;
  robot::Vector3 force = robot::Vector3::Zero();  ///< for the deflection at each target, N
};
void bind_robot_reach(Section& section, RobotReachCase& c);
/// [robot] of `osteomill control`: a named model, and where the work is.
void bind_carrying_robot(Section& section, std::optional<CarryingRobot>& to);
void bind_robot_reach_keys(Section& section);

struct RobotTibiaCase {
  robot::TibialGuide guide;
  robot::Pose X_AB = robot::Pose::Identity();
  robot::TibialJoints now;
  robot::TibialDisplay target;
  double tolerance = 0.5 * units::deg;
};
void bind_robot_tibia(Section& section, RobotTibiaCase& c);
void bind_robot_tibia_keys(Section& section);

}  // namespace osteomill::io
