// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/meridian.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

using cutting::CutterShape;

cutting::Cutter scaled(cutting::Cutter cutter, double factor) {
  cutter.radius *= factor;
  cutter.cutting_length *= factor;
  cutter.corner_radius *= factor;
  cutter.apt.diameter *= factor;
  cutter.apt.corner_r *= factor;
  cutter.apt.corner_z *= factor;
  for (cutting::ProfileCorner& corner : cutter.profile) {
    corner.radius *= factor;
    corner.z *= factor;
  }
  return cutter;
}

Meridian::Meridian(const cutting::Cutter& cutter_m, double factor) {
  const cutting::Cutter cutter = scaled(cutter_m, factor);
  radius_ = cutter.radius;
  cutting_length_ = cutter.cutting_length;
  const double corner = cutter.corner_radius;
  const auto is_small = [&](double length) { return std::abs(length) <= 1e-9 * radius_; };
  switch (cutter.shape) {
    case CutterShape::cylindrical:
      return;
    case CutterShape::ball:
      kind_ = Kind::ball;
      top_ = radius_;
      return;
    case CutterShape::bull:
      kind_ = Kind::general;
      top_ = corner;
      if (!is_small(radius_ - corner)) add_line({0.0, 0.0}, {radius_ - corner, 0.0});
      arcs_.push_back({{radius_ - corner, corner}, corner, 0.0});
      break;
    case CutterShape::tapered: {
      kind_ = Kind::general;
      const double sine = std::sin(cutter.taper_angle), cosine = std::cos(cutter.taper_angle);
      arcs_.push_back({{0.0, corner}, corner, sine});
      const Corner joint{corner * cosine, corner * (1.0 - sine)};
      top_ = joint.z;
      if (!is_small(radius_ - joint.r) && sine > 0.0) {
        top_ += (radius_ - joint.r) * cosine / sine;
        add_line(joint, {radius_, top_});
      }
      break;
    }
    case CutterShape::apt: {
      kind_ = Kind::general;
      const cutting::AptJoints joints =
          cutting::apt_joints(cutter.apt, corner, cutter.cutting_length);
      const Corner lower{joints.lower.radius, joints.lower.z};
      const Corner upper{joints.upper.radius, joints.upper.z};
      const Corner top{joints.top_radius, cutter.cutting_length};
      if (!is_small(std::hypot(lower.r, lower.z))) add_line({0.0, 0.0}, lower);
      if (!is_small(std::hypot(upper.r - lower.r, upper.z - lower.z))) {
        arcs_.push_back({{cutter.apt.corner_r, cutter.apt.corner_z},
                         corner,
                         std::cos(joints.upper_kappa),
                         std::cos(joints.lower_kappa)});
      }
      top_ = upper.z;
      if (cutter.apt.side_angle > 0.0 && !is_small(top.z - upper.z)) {
        add_line(upper, top);
        top_ = top.z;
      }
      break;
    }
    case CutterShape::profile: {
      kind_ = Kind::general;
      Corner last{0.0, 0.0};
      for (const cutting::ProfileCorner& point : cutter.profile) {
        const Corner next{point.radius, point.z};
        if (!is_small(std::hypot(next.r - last.r, next.z - last.z))) add_line(last, next);
        last = next;
      }
      // The normal turns from downwards to outwards, never back, and the shank joins without a
      // step.
      bool convex = is_small(radius_ - last.r);
      for (std::size_t i = 1; i < lines_.size(); ++i)
        convex = convex && lines_[i].normal_z >= lines_[i - 1].normal_z - 1e-9;
      if (!convex)
        throw InvalidInput(Fault{"cutter.profile_mm", "a hollow or stepped outline",
                                 "must be convex up to the full radius to remove bone",
                                 "leave out the points that lie inwards"});
      top_ = last.z;
      break;
    }
  }
  if (cutter.shape == CutterShape::tapered && lines_.empty() &&
      !is_small(radius_ - arcs_[0].radius))
    throw InvalidInput(Fault{"cutter.taper_deg", "0 deg",
                             "must lead from the corner radius to the full radius",
                             "give a taper angle or a corner radius of half the diameter"});
  add_line({radius_, top_}, {radius_, std::numeric_limits<double>::infinity()});
}

void Meridian::add_line(const Corner& from, const Corner& to) {
  Line line{from, to, 1.0, 0.0};
  if (std::isfinite(to.z)) {
    const double length = std::hypot(to.r - from.r, to.z - from.z);
    line.normal_r = (to.z - from.z) / length;
    line.normal_z = -(to.r - from.r) / length;
  }
  lines_.push_back(line);
}

double Meridian::general_distance(double r, double z) const {
  double nearest = std::numeric_limits<double>::infinity();
  bool inside = true;
  for (const Line& line : lines_) {
    const double dr = r - line.from.r, dz = z - line.from.z;
    const double beyond = dr * line.normal_r + dz * line.normal_z;
    inside = inside && beyond <= 0.0;
    // Along the line, upwards or outwards.
    const double along = dz * line.normal_r - dr * line.normal_z;
    const double length =
        (line.to.z - line.from.z) * line.normal_r - (line.to.r - line.from.r) * line.normal_z;
    const double past = along < 0.0 ? along : std::max(0.0, along - length);
    nearest = std::min(nearest, std::sqrt(beyond * beyond + past * past));
  }
  for (const Arc& arc : arcs_) {
    const double dr = r - arc.centre.r, dz = z - arc.centre.z;
    const double from_centre = std::sqrt(dr * dr + dz * dz);
    // In the wedge between the normals at the arc's ends.
    if (dr < 0.0 || -dz < arc.last_cosine * from_centre || -dz > arc.first_cosine * from_centre) {
      continue;
    }
    inside = inside && from_centre <= arc.radius;
    nearest = std::min(nearest, std::abs(from_centre - arc.radius));
  }
  return inside ? -nearest : nearest;
}

double Meridian::upright_from(double band) const {
  if (kind_ == Kind::ball) return radius_;
  return top_ + band;
}

double Meridian::section_radius(double z, double offset) const {
  const double full = radius_ + offset;
  if (kind_ == Kind::cylinder) {
    if (z < -offset) return -1.0;
    return z < 0.0 ? radius_ + std::sqrt(offset * offset - z * z) : full;
  }
  if (kind_ == Kind::ball) {
    const double below = radius_ - z;
    if (below <= 0.0) return full;
    return below < full ? std::sqrt(full * full - below * below) : -1.0;
  }
  if (z >= upright_from(std::abs(offset))) return full;
  if (distance(0.0, z) > offset) return -1.0;
  double low = 0.0, high = full;
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = 0.5 * (low + high);
    (distance(middle, z) <= offset ? low : high) = middle;
  }
  // To the safe side: a rim voxel is worked out, whether it lies in or out.
  return offset > 0.0 ? high : low;
}

}  // namespace osteomill::workpiece
