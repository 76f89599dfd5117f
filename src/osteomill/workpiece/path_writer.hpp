// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::workpiece {

/// Strings passes together: between them the tool goes up to a height, over, and down at cutting
/// feed, since there may be bone below.
class PathWriter {
 public:
  PathWriter(const CutSettings& cut, double clearance_z) : cut_(cut), clearance_z_(clearance_z) {}

  /// Lifted over to the point, and down to it.
  void travel(const Vector3& to, int line) {
    const Vector3 above(to.x(), to.y(), clearance_z_);
    if (!moves_.empty()) {
      const Vector3 last = moves_.back().points_W.back();
      const Vector3 lifted(last.x(), last.y(), clearance_z_);
      moves_.push_back({MoveKind::rapid, {last, lifted, above}, 0.0, cut_.spindle_speed, line, {}});
    }
    moves_.push_back({MoveKind::cut, {above, to}, cut_.feed_rate, cut_.spindle_speed, line, {}});
  }
  /// Straight on through the points, after a travel.
  void pass(std::vector<Vector3> points, int line) {
    points.insert(points.begin(), moves_.back().points_W.back());
    moves_.push_back(
        {MoveKind::cut, std::move(points), cut_.feed_rate, cut_.spindle_speed, line, {}});
  }
  bool empty() const { return moves_.empty(); }
  Vector3 last() const { return moves_.back().points_W.back(); }
  std::vector<Move> take() { return std::move(moves_); }

 private:
  CutSettings cut_;
  double clearance_z_;
  std::vector<Move> moves_;
};

}  // namespace osteomill::workpiece
