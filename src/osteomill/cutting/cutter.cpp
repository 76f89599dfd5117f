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

}  // namespace osteomill::cutting
