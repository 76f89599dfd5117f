// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/air_moves.hpp"

#include <algorithm>
#include <vector>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

namespace {

/// The way from one arc length to another within a move.
Move piece(const ToolPath& path, std::size_t m, double from, double to) {
  Move part = path.moves()[m];
  std::vector<double> stops{from};
  for (double corner : path.corners_between(from, to)) stops.push_back(corner);
  stops.push_back(to);
  part.points_W.clear();
  const bool turning = !part.axes_W.empty();
  part.axes_W.clear();
  for (double stop : stops) {
    const PathPoint at = path.at(stop);
    part.points_W.push_back(at.position_W);
    if (turning) part.axes_W.push_back(at.axis_W);
  }
  return part;
}

}  // namespace

AirMoves rapid_through_air(const ToolPath& path, const ContactMap& contact,
                           const AirOptions& options) {
  require_non_negative("path.air_clearance_mm", options.clearance / units::mm, "mm");
  require_positive("path.rapid_mm_per_s", options.rapid_feed / units::mm_per_s, "mm/s");
  // What is near bone, in order, overlaps joined.
  std::vector<std::array<double, 2>> near;
  for (const ContactMap::Stretch& stretch : contact.stretches()) {
    const std::array<double, 2> wide{stretch.begin - options.clearance,
                                     stretch.end + options.clearance};
    if (!near.empty() && wide[0] <= near.back()[1])
      near.back()[1] = std::max(near.back()[1], wide[1]);
    else
      near.push_back(wide);
  }
  std::vector<Move> moves;
  double length = 0.0, saved = 0.0;
  for (std::size_t m = 0; m < path.moves().size(); ++m) {
    const Move& move = path.moves()[m];
    const double begin = path.start_of(m), end = path.end_of(m);
    if (end <= begin || move.kind == MoveKind::rapid || move.feed_rate >= options.rapid_feed) {
      moves.push_back(move);
      continue;
    }
    double at = begin;
    const auto go_to = [&](double to, bool cutting) {
      if (to <= at) return;
      Move part = piece(path, m, at, to);
      if (!cutting) {
        part.kind = MoveKind::rapid;
        length += to - at;
        saved += (to - at) * (1.0 / move.feed_rate - 1.0 / options.rapid_feed);
      }
      moves.push_back(std::move(part));
      at = to;
    };
    for (const auto& [from, to] : near) {
      if (to <= begin || from >= end) continue;
      go_to(std::max(from, begin), false);
      go_to(std::min(to, end), true);
    }
    go_to(end, false);
  }
  return {ToolPath(std::move(moves)), length, saved};
}

double duration(const ToolPath& path, double rapid_feed) {
  double time = 0.0;
  for (std::size_t m = 0; m < path.moves().size(); ++m) {
    const Move& move = path.moves()[m];
    time += (path.end_of(m) - path.start_of(m)) /
            (move.kind == MoveKind::rapid ? rapid_feed : move.feed_rate);
  }
  return time;
}

}  // namespace osteomill::workpiece
