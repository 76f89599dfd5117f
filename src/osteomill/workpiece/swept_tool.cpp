// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/swept_tool.hpp"

#include <algorithm>
#include <cmath>

namespace osteomill::workpiece {

double tool_distance(const cutting::Cutter& cutter, double r, double z) {
  if (cutter.shape == cutting::CutterShape::ball)
    return std::hypot(r, std::min(0.0, z - cutter.radius)) - cutter.radius;
  const double wall = r - cutter.radius;
  if (wall > 0.0 && z < 0.0) return std::hypot(wall, z);
  return std::max(wall, -z);
}

SweptTool::SweptTool(const cutting::Cutter& cutter, const geometry::Vector3& from,
                     const geometry::Vector3& to)
    : cutter_(cutter), from_(from) {
  const geometry::Vector3 step = to - from;
  run_ = std::hypot(step.x(), step.y());
  rise_ = step.z();
  if (run_ > 0.0) {
    along_x_ = step.x() / run_;
    along_y_ = step.y() / run_;
  }
}

double SweptTool::distance(const geometry::Vector3& p) const {
  const double x = p.x() - from_.x(), y = p.y() - from_.y();
  const double along = along_x_ * x + along_y_ * y;
  const double lateral = along_x_ * y - along_y_ * x;
  const double height = p.z() - from_.z();
  return cutter_.shape == cutting::CutterShape::ball ? ball_distance(along, lateral, height)
                                                     : cylinder_distance(along, lateral, height);
}

double SweptTool::ball_distance(double along, double lateral, double height) const {
  // The axis above the centre sweeps the strip 0 <= along <= run, height >= line of the centre.
  const double h = height - cutter_.radius;
  if (run_ == 0.0)
    return std::hypot(along, lateral, std::min(0.0, h - std::min(0.0, rise_))) - cutter_.radius;
  double in_plane_sq = 0.0;
  if (along < 0.0 || along > run_ || h * run_ < rise_ * along) {
    const double length_sq = run_ * run_ + rise_ * rise_;
    const double t = std::clamp((along * run_ + h * rise_) / length_sq, 0.0, 1.0);
    const auto square = [](double a, double b) { return a * a + b * b; };
    in_plane_sq =
        std::min({square(along - t * run_, h - t * rise_), square(along, std::min(0.0, h)),
                  square(along - run_, std::min(0.0, h - rise_))});
  }
  return std::sqrt(in_plane_sq + lateral * lateral) - cutter_.radius;
}

double SweptTool::cylinder_distance(double along, double lateral, double height) const {
  const auto at = [&](double t) {
    return tool_distance(cutter_, std::hypot(along - t * run_, lateral), height - t * rise_);
  };
  if (run_ == 0.0) return std::min(at(0.0), at(1.0));
  if (rise_ == 0.0) return at(std::clamp(along / run_, 0.0, 1.0));
  // The distance to a convex body is convex along a line: bisect the sign of its slope.
  const auto falls = [&](double t) {
    const double ahead = along - t * run_;
    const double r = std::hypot(ahead, lateral);
    const double z = height - t * rise_;
    const double wall = r - cutter_.radius;
    const double wall_slope = r > 0.0 ? -ahead * run_ / r : 0.0;
    if (wall > 0.0 && z < 0.0) return wall * wall_slope - z * rise_ < 0.0;
    return (wall > -z ? wall_slope : rise_) < 0.0;
  };
  double low = 0.0, high = 1.0;
  // 2^-48 of a segment moves the distance by less than a unit of occupancy.
  for (int halving = 0; halving < 48 && high - low > 0.0; ++halving) {
    const double middle = 0.5 * (low + high);
    (falls(middle) ? low : high) = middle;
  }
  return std::min({at(0.0), at(0.5 * (low + high)), at(1.0)});
}

}  // namespace osteomill::workpiece
