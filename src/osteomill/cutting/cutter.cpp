// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/cutter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::cutting {

void check(const Cutter& cutter) {
  require_positive("cutter.diameter_mm", 2.0 * cutter.radius / units::mm, "mm");
  require_within("cutter.flutes", cutter.flutes, 1.0, 64.0, "");
  require_within("cutter.helix_deg", cutter.helix_angle / units::deg, -75.0, 75.0, "deg");
  require_within("cutter.rake_deg", cutter.rake_angle / units::deg, -60.0, 60.0, "deg");
  require_positive("cutter.cutting_length_mm", cutter.cutting_length / units::mm, "mm");
}

double radius_at(const Cutter& cutter, double z) {
  if (cutter.shape == CutterShape::cylindrical || z >= cutter.radius) return cutter.radius;
  return std::sqrt(std::max(0.0, z * (2.0 * cutter.radius - z)));
}

double axial_position_angle(const Cutter& cutter, double z) {
  if (cutter.shape == CutterShape::cylindrical || z >= cutter.radius) return std::numbers::pi / 2.0;
  return std::acos(std::clamp(1.0 - z / cutter.radius, -1.0, 1.0));
}

double lag_angle(const Cutter& cutter, double z) {
  return z * std::tan(cutter.helix_angle) / cutter.radius;
}

double meridian_length(const Cutter& cutter, double z) {
  if (cutter.shape == CutterShape::cylindrical) return z;
  const double round = cutter.radius * axial_position_angle(cutter, std::min(z, cutter.radius));
  return round + std::max(0.0, z - cutter.radius);
}

ProfilePoint profile_at(const Cutter& cutter, double meridian_length) {
  const double quarter = 0.5 * std::numbers::pi * cutter.radius;
  ProfilePoint point;
  point.kappa = std::numbers::pi / 2.0;
  point.radius = cutter.radius;
  if (cutter.shape == CutterShape::cylindrical) {
    point.z = meridian_length;
  } else if (meridian_length >= quarter) {
    point.z = cutter.radius + (meridian_length - quarter);
  } else {
    point.kappa = meridian_length / cutter.radius;
    point.z = cutter.radius * (1.0 - std::cos(point.kappa));
    point.radius = cutter.radius * std::sin(point.kappa);
  }
  point.lag = lag_angle(cutter, point.z);
  // Along the meridian dz = sin kappa ds, so the edge turns by r dlag = r sin kappa tan(helix)/R
  // ds.
  const double slope =
      point.radius / cutter.radius * std::sin(point.kappa) * std::tan(cutter.helix_angle);
  point.inclination = std::atan(slope);
  point.stretch = std::sqrt(1.0 + slope * slope);
  return point;
}

}  // namespace osteomill::cutting
