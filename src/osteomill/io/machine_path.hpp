// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/geometry/pose.hpp"
#include "osteomill/simulate/line_profile.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::io {

/// A straight move of the tool's tip.
struct MachineMove {
  geometry::Vector3 start_W = geometry::Vector3::Zero();  ///< m
  geometry::Vector3 end_W = geometry::Vector3::Zero();    ///< m
  double from = 0.0;  ///< place along the case's path at its start, m
  double to = 0.0;    ///< and at its end; the same for a move that is not part of that path
  bool cut = false;   ///< part of the case's path
  /// From where the machine is found straight up or down to the height of its end; the move behind
  /// it starts there.
  bool lift = false;
  geometry::Vector3 axis_start_W = geometry::Vector3::UnitZ();  ///< of the tool, to the spindle
  geometry::Vector3 axis_end_W = geometry::Vector3::UnitZ();
};

/// What a machine does to mill the lines of a profile: each line in one move, and between two
/// lines away from the wall by `clearance`, back, and up to the wall again.
std::vector<MachineMove> machine_path(const simulate::LineProfileWorkpiece& workpiece,
                                      double clearance);

/// What a machine does to follow a path: all of it, the rapids too, at the feed that the controller
/// sets, after an approach to its start: up first, `clearance` above all of it, then across.
std::vector<MachineMove> machine_path(const workpiece::ToolPath& path, double clearance);

/// The same as a program for LinuxCNC: cuts with G1 at `full_feed`, m/s, under adaptive feed (M52
/// P1), the moves between them with G0, exact stops.
std::string gcode_of(const std::vector<MachineMove>& path, double full_feed, double spindle_speed);

/// Follows a machine along its path from the positions that it reports.
class PathFollower {
 public:
  /// `tolerance`: how far from the path a machine may stand that is to go on with it, m. A chain of
  /// turning axes is not exactly on it: see joint_program().
  explicit PathFollower(std::vector<MachineMove> path, double tolerance = 1e-6);

  struct Place {
    double position = 0.0;                                  ///< along the case's path, m
    bool cut = false;                                       ///< within a move of that path
    bool finished = false;                                  ///< the last move has come to its end
    double off = 0.0;                                       ///< distance from that move, m
    geometry::Vector3 axis_W = geometry::Vector3::UnitZ();  ///< of the tool, as planned
  };
  /// The next position, p_WT in W. The first one is where the approach begins, unless it lies on a
  /// cut: then the machine goes on with that one, as after a stop.
  Place update(const geometry::Vector3& p_W);

 private:
  std::vector<MachineMove> path_;
  double tolerance_ = 0.0;
  std::size_t at_ = 0;
  bool begun_ = false;
};

}  // namespace osteomill::io
