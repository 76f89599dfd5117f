// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/swept_tool.hpp"

#include <algorithm>
#include <cmath>

namespace osteomill::workpiece {

SweptTool::SweptTool(const Meridian& cutter, const geometry::Vector3& from,
                     const geometry::Vector3& to)
    : cutter_(&cutter), from_(from) {
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
  const auto at = [&](double t) {
    const double ahead = along - t * run_;
    return cutter_->distance(std::sqrt(ahead * ahead + lateral * lateral), height - t * rise_);
  };
  // It rises with the distance from the axis and falls with the height.
  if (run_ == 0.0) return std::min(at(0.0), at(1.0));
  if (rise_ == 0.0) return at(std::clamp(along / run_, 0.0, 1.0));
  if (cutter_->is_ball()) return ball_distance(along, lateral, height);
  // The distance to a convex body is convex along a line: golden section.
  constexpr double kGolden = 0.61803398874989485;
  double low = 0.0, high = 1.0;
  double left = 1.0 - kGolden, right = kGolden;
  double at_left = at(left), at_right = at(right);
  // 0.618^50 of a segment moves the distance by far less than a unit of occupancy.
  for (int step = 0; step < 50; ++step) {
    if (at_left < at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - kGolden * (high - low);
      at_left = at(left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + kGolden * (high - low);
      at_right = at(right);
    }
  }
  return std::min({at(0.0), at_left, at_right, at(1.0)});
}

double SweptTool::ball_distance(double along, double lateral, double height) const {
  // The axis above the centre sweeps the strip 0 <= along <= run, height >= line of the centre.
  const double h = height - cutter_->radius();
  double in_plane_sq = 0.0;
  if (along < 0.0 || along > run_ || h * run_ < rise_ * along) {
    const double length_sq = run_ * run_ + rise_ * rise_;
    const double t = std::clamp((along * run_ + h * rise_) / length_sq, 0.0, 1.0);
    const auto square = [](double a, double b) { return a * a + b * b; };
    in_plane_sq =
        std::min({square(along - t * run_, h - t * rise_), square(along, std::min(0.0, h)),
                  square(along - run_, std::min(0.0, h - rise_))});
  }
  return std::sqrt(in_plane_sq + lateral * lateral) - cutter_->radius();
}

}  // namespace osteomill::workpiece
