// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/joint_program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/tool_pose.hpp"

namespace osteomill::io {
namespace {

using geometry::Pose;
using geometry::Vector3;

constexpr double kStep = 20e-3;       // between two poses that are solved for, at most, m
constexpr double kTurn = 0.1;         // and of the tool's axis, rad
constexpr double kCorner = 0.17;      // a path that turns by more stands still there (10 deg), rad
constexpr double kLongestSlide = 20;  // of a joint for a metre of the tip: more is a jump, m
constexpr double kLongestTurn = 200;  // likewise, rad
constexpr double kInAir = 0.1e-3;     // chord error where nothing is cut, m
constexpr int kHalvings = 8;

/// Any pose with the tool where it is to be: the turn about its axis is free.
Pose pose_of(const workpiece::ToolPose& tool) {
  Pose X = Pose::Identity();
  X.translation() = tool.tip_W;
  X.linear() = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), tool.axis_W).toRotationMatrix();
  return X;
}

class Joints {
 public:
  explicit Joints(const CarryingRobot& robot) : robot_(robot), rest_(robot.chain) {}

  /// Sets the first joint for the whole path by its middle.
  void begin(const workpiece::ToolPose& middle, double position) {
    Eigen::VectorXd start(robot_.chain.size());
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      const robot::Joint& joint = robot_.chain.joints[static_cast<std::size_t>(i)];
      start[i] = 0.5 * (joint.low + joint.high);
    }
    const Eigen::VectorXd q = solved(robot_.chain, robot_.X_BW * pose_of(middle), start, position);
    first_ = q[0];
    q_ = q.tail(q.size() - 1);
    const Vector3 shift = first_ * robot_.chain.joints.front().direction;
    rest_.joints.erase(rest_.joints.begin());
    for (robot::Joint& joint : rest_.joints) joint.point += shift;
    rest_.X_BT0.translation() += shift;
  }

  void go_back_to(const Eigen::VectorXd& q) { q_ = q.tail(q.size() - 1); }

  /// From where the last call ended.
  Eigen::VectorXd at(const workpiece::ToolPose& tool, double position) {
    q_ = solved(rest_, robot_.X_BW * pose_of(tool), q_, position);
    Eigen::VectorXd q(q_.size() + 1);
    q << first_, q_;
    return q;
  }

 private:
  static Eigen::VectorXd solved(const robot::SerialChain& chain, const Pose& X_BT,
                                const Eigen::VectorXd& start, double position) {
    robot::InverseOptions options;
    options.free_about_tool_axis = true;
    const robot::InverseResult found = robot::inverse(chain, X_BT, start, options);
    if (found.converged) return found.q;
    throw InvalidInput(Fault{"robot.work", fmt::format("{:.1f} mm along the path", position * 1e3),
                             "must be within reach: " + found.reason,
                             "move the work by robot.work.position_mm and turn_deg"});
  }

  const CarryingRobot& robot_;
  robot::SerialChain rest_;  ///< without the first joint
  double first_ = 0.0;
  Eigen::VectorXd q_;  ///< of the rest
};

workpiece::ToolPose tool_at(const MachineMove& move, double share) {
  return workpiece::between({move.start_W, move.axis_start_W}, {move.end_W, move.axis_end_W},
                            share);
}

/// Whether the path turns so much between two moves that the tool has to stand still.
bool corner(const MachineMove& move, const MachineMove& next) {
  const Vector3 along = move.end_W - move.start_W;
  const Vector3 on = next.end_W - next.start_W;
  return move.cut != next.cut || !(along.norm() > 0.0) || !(on.norm() > 0.0) ||
         workpiece::angle_between(along.normalized(), on.normalized()) > kCorner;
}

void check_jump(const CarryingRobot& robot, const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                double way, double position) {
  for (Eigen::Index i = 0; i < from.size(); ++i) {
    const robot::Joint& joint = robot.chain.joints[static_cast<std::size_t>(i)];
    const double longest = (joint.prismatic ? kLongestSlide : kLongestTurn) * std::max(way, 1e-4);
    if (std::abs(to[i] - from[i]) <= longest) continue;
    throw InvalidInput(
        Fault{"robot.work", fmt::format("{:.1f} mm along the path", position * 1e3),
              "must be milled without a jump of the joints: " + joint.name + " would jump there",
              "move the work by robot.work.position_mm and turn_deg"});
  }
}

}  // namespace

std::vector<JointMove> joint_program(const CarryingRobot& robot,
                                     const std::vector<MachineMove>& path, double full_feed,
                                     double chord_error) {
  const double length = path.back().to;
  const auto middle = std::find_if(path.begin(), path.end(), [&](const MachineMove& move) {
    return move.cut && move.to >= 0.5 * length;
  });
  if (middle == path.end()) return {};
  Joints joints(robot);
  joints.begin(tool_at(*middle, 0.5), 0.5 * length);

  std::vector<JointMove> moves;
  for (std::size_t number = 0; number < path.size(); ++number) {
    const MachineMove& move = path[number];
    const double way = (move.end_W - move.start_W).norm();
    const double turn = workpiece::angle_between(move.axis_start_W, move.axis_end_W);
    const bool stop = number + 1 == path.size() || corner(move, path[number + 1]);
    if (way == 0.0 || moves.empty()) {
      // The approach, from wherever the robot stands.
      moves.push_back({joints.at(tool_at(move, 1.0), move.to), 0.0, false, true});
      continue;
    }
    auto pieces = static_cast<int>(std::ceil(std::max(way / kStep, turn / kTurn)));
    std::vector<JointMove> there;
    for (int halvings = 0;; ++halvings, pieces *= 2) {
      there.clear();
      joints.go_back_to(moves.back().q);
      double worst = 0.0;
      for (int i = 1; i <= pieces; ++i) {
        const double share = static_cast<double>(i) / pieces;
        const double position = move.from + share * (move.to - move.from);
        const Eigen::VectorXd from = there.empty() ? moves.back().q : there.back().q;
        const Eigen::VectorXd q = joints.at(tool_at(move, share), position);
        check_jump(robot, from, q, way / pieces, position);
        const Vector3 tip = robot.tool_in_work(0.5 * (from + q)).translation();
        worst = std::max(worst, (tip - tool_at(move, share - 0.5 / pieces).tip_W).norm());
        const double time = move.cut ? way / pieces / full_feed : 0.0;
        there.push_back({q, time, move.cut, stop && i == pieces});
      }
      if (worst <= (move.cut ? chord_error : kInAir)) break;
      if (halvings == kHalvings) {
        throw InvalidInput(
            Fault{"robot.work", fmt::format("{:.1f} mm along the path", move.from * 1e3),
                  "must be milled away from where the robot is singular: its joints turn too fast",
                  "move the work by robot.work.position_mm and turn_deg"});
      }
    }
    moves.insert(moves.end(), there.begin(), there.end());
  }
  return moves;
}

std::string gcode_of(const CarryingRobot& robot, const std::vector<JointMove>& moves,
                     double spindle_speed) {
  std::string text = fmt::format("G17 G21 G40 G49 G54 G80 G90 G93\nM52 P1\nS{:.3f} M3\n",
                                 spindle_speed / units::rpm);
  for (std::size_t number = 0; number < moves.size(); ++number) {
    const JointMove& move = moves[number];
    if (number == 0 || move.stop != moves[number - 1].stop) {
      text += move.stop ? "G61.1\n" : "G64 P0.005 Q0\n";
    }
    text += move.cut ? "G1" : "G0";
    for (Eigen::Index i = 0; i < move.q.size(); ++i) {
      const robot::Joint& joint = robot.chain.joints[static_cast<std::size_t>(i)];
      const double value = move.q[i] / (joint.prismatic ? units::mm : units::deg);
      fmt::format_to(std::back_inserter(text), " {}{:.7f}", joint.name, value);
    }
    if (move.cut) fmt::format_to(std::back_inserter(text), " F{:.6f}", 60.0 / move.time);
    text += '\n';
  }
  return text + "G94\nM5\nM2\n";
}

}  // namespace osteomill::io
