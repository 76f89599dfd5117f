// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "osteomill/geometry/pose.hpp"
#include "osteomill/io/machine_path.hpp"
#include "osteomill/robot/serial_chain.hpp"

namespace osteomill::io {

/// A serial robot that carries the tool, and where the work is.
struct CarryingRobot {
  robot::SerialChain chain;
  geometry::Pose X_BW = geometry::Pose::Identity();  ///< the work frame in the robot's base frame

  /// The tool in the work frame.
  geometry::Pose tool_in_work(const Eigen::VectorXd& q) const {
    return X_BW.inverse() * robot::forward(chain, q);
  }
};

/// A piece of a move, straight in the joints.
struct JointMove {
  Eigen::VectorXd q;  ///< at its end, m or rad
  double time = 0.0;  ///< at full feed, s; 0: as fast as the joints go
  bool cut = false;   ///< part of the case's path
  bool stop = false;  ///< exactly at rest at its end
};

/// A machine's path in the joints of a robot. The first joint, a slide, is set once and stands
/// while the others mill; what they leave free, the turn about the tool's own axis among it, keeps
/// them away from their limits. Between two values of the joints the tip is within `chord_error`,
/// m, of the path, and moves at `full_feed`, m/s. InvalidInput when a place is out of reach or asks
/// for a jump of the joints; it names the place.
std::vector<JointMove> joint_program(const CarryingRobot& robot,
                                     const std::vector<MachineMove>& path, double full_feed,
                                     double chord_error = 5e-6);

/// The same as a program for LinuxCNC, whose axes are called as the joints are: each cut in inverse
/// time (G93), so that the tip has the feed whatever the joints do, under adaptive feed (M52 P1).
/// Exact stops where JointMove::stop says so, else blended within 5 um.
std::string gcode_of(const CarryingRobot& robot, const std::vector<JointMove>& moves,
                     double spindle_speed);

}  // namespace osteomill::io
