// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "osteomill/geometry/pose.hpp"

namespace osteomill::workpiece {

/// Where a tool is: its tip, and the unit vector from there to the spindle. A cutter looks the same
/// from all sides of its axis.
struct ToolPose {
  geometry::Vector3 tip_W = geometry::Vector3::Zero();
  geometry::Vector3 axis_W = geometry::Vector3::UnitZ();

  /// See base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(tip_W, axis_W);
  }
};

/// Angle between two unit vectors, 0 to pi; exact for small ones too.
inline double angle_between(const geometry::Vector3& a, const geometry::Vector3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// The unit vector at a share of the way from one to the other, turning evenly in the plane of
/// both: a path in pieces turns as the whole path does. The two must not be opposite.
inline geometry::Vector3 turned(const geometry::Vector3& from, const geometry::Vector3& to,
                                double part) {
  const double angle = angle_between(from, to);
  if (angle < 1e-12) return from;
  return (std::sin((1.0 - part) * angle) * from + std::sin(part * angle) * to).normalized();
}

inline ToolPose between(const ToolPose& from, const ToolPose& to, double part) {
  return {from.tip_W + part * (to.tip_W - from.tip_W), turned(from.axis_W, to.axis_W, part)};
}

}  // namespace osteomill::workpiece
