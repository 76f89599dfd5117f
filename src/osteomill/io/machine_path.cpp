// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/machine_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "osteomill/base/units.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;

/// A machine that reports its position to less than this has reached a point, m.
constexpr double kReached = 1e-6;
/// The end of the path is in air: near is enough, a real machine does not stand quite still.
constexpr double kAtTheEnd = 10e-6;

double share_along(const MachineMove& move, const Vector3& p) {
  const Vector3 way = move.end_W - move.start_W;
  const double length = way.squaredNorm();
  return length > 0.0 ? std::clamp((p - move.start_W).dot(way) / length, 0.0, 1.0) : 1.0;
}

double distance(const MachineMove& move, const Vector3& p) {
  return (move.start_W + share_along(move, p) * (move.end_W - move.start_W) - p).norm();
}

}  // namespace

std::vector<MachineMove> machine_path(const simulate::LineProfileWorkpiece& workpiece,
                                      double clearance) {
  const double pitch = workpiece.length() / workpiece.lines();
  std::vector<MachineMove> path;
  const auto move_to = [&](const Vector3& end, double position) {
    path.push_back({path.back().end_W, end, position, position, false, false});
  };
  for (int line = 0; line < workpiece.lines(); ++line) {
    const double from = line * pitch;
    const simulate::Place start = workpiece.at(from);
    const Vector3 away(0.0, -clearance, 0.0);
    if (line == 0) {
      path.push_back({start.tip_W, start.tip_W, 0.0, 0.0, false, false});  // the approach
    } else {
      move_to(path.back().end_W + away, from);
      move_to(start.tip_W + away, from);
      move_to(start.tip_W, from);
    }
    path.push_back(
        {start.tip_W, start.tip_W + pitch * start.direction_W, from, from + pitch, true, false});
  }
  return path;
}

std::vector<MachineMove> machine_path(const workpiece::ToolPath& path, double clearance) {
  const Vector3& start = path.moves().front().points_W.front();
  Vector3 above = start;
  for (const workpiece::Move& move : path.moves()) {
    for (const Vector3& point : move.points_W) above.z() = std::max(above.z(), point.z());
  }
  above.z() += clearance;
  std::vector<MachineMove> moves = {{above, above, 0.0, 0.0, false, true},
                                    {above, above, 0.0, 0.0, false, false},
                                    {above, start, 0.0, 0.0, false, false}};
  double position = 0.0;
  for (const workpiece::Move& move : path.moves()) {
    const auto axis = [&](std::size_t point) -> Vector3 {
      return move.axes_W.empty() ? Vector3::UnitZ() : move.axes_W[point];
    };
    for (std::size_t i = 1; i < move.points_W.size(); ++i) {
      const double from = position;
      position += (move.points_W[i] - move.points_W[i - 1]).norm();
      if (position > from) {
        moves.push_back({move.points_W[i - 1], move.points_W[i], from, position, true, false,
                         axis(i - 1), axis(i)});
      }
    }
  }
  for (MachineMove& move : moves) {
    if (!move.cut) move.axis_start_W = move.axis_end_W = moves[3].axis_start_W;
  }
  return moves;
}

std::string gcode_of(const std::vector<MachineMove>& path, double full_feed, double spindle_speed) {
  std::string text = fmt::format("G17 G21 G40 G49 G54 G80 G90 G94\nG61.1\nM52 P1\nS{:.3f} M3\n",
                                 spindle_speed / units::rpm);
  const double feed = full_feed / units::mm_per_min;
  for (const MachineMove& move : path) {
    const Vector3 end = move.end_W / units::mm;
    if (move.lift) {
      fmt::format_to(std::back_inserter(text), "G0 Z{:.6f}\n", end.z());
      continue;
    }
    fmt::format_to(std::back_inserter(text), "{} X{:.6f} Y{:.6f} Z{:.6f}{}\n",
                   move.cut ? "G1" : "G0", end.x(), end.y(), end.z(),
                   move.cut ? fmt::format(" F{:.6f}", feed) : "");
  }
  return text + "M5\nM2\n";
}

PathFollower::PathFollower(std::vector<MachineMove> path, double tolerance)
    : path_(std::move(path)), tolerance_(tolerance) {}

PathFollower::Place PathFollower::update(const Vector3& p_W) {
  if (!begun_) {
    path_.front().start_W = p_W;
    if (path_.front().lift) {
      path_.front().end_W = {p_W.x(), p_W.y(), path_.front().end_W.z()};
      path_[1].start_W = path_.front().end_W;
    }
    const auto on = std::find_if(path_.begin(), path_.end(), [&](const MachineMove& move) {
      return move.cut && distance(move, p_W) < tolerance_;
    });
    if (on != path_.end()) at_ = static_cast<std::size_t>(on - path_.begin());
    begun_ = true;
  }
  while (at_ + 1 < path_.size()) {
    const MachineMove& next = path_[at_ + 1];
    const bool reached = (p_W - path_[at_].end_W).norm() < kReached;
    const bool beyond =
        share_along(next, p_W) > 0.0 && distance(next, p_W) + kReached < distance(path_[at_], p_W);
    if (!reached && !beyond) break;
    ++at_;
  }
  const MachineMove& move = path_[at_];
  Place place;
  place.position = move.from + share_along(move, p_W) * (move.to - move.from);
  place.cut = move.cut;
  place.finished = at_ + 1 == path_.size() && (p_W - move.end_W).norm() < kAtTheEnd;
  place.off = distance(move, p_W);
  place.axis_W = workpiece::turned(move.axis_start_W, move.axis_end_W, share_along(move, p_W));
  return place;
}

}  // namespace osteomill::io
