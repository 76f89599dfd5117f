// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/cutter.hpp"

namespace osteomill::cutting {
namespace {

constexpr double kQuarter = std::numbers::pi / 2.0;

/// Half the chord that a circle cuts from the line through `from` at an angle against the plane
/// normal to the axis, and where on the line its middle is; < 0 squared when it passes by.
struct Chord {
  double middle = 0.0;   ///< along the line, m
  double half_sq = 0.0;  ///< m²
};

Chord chord(const ProfileCorner& from, double slope, const ProfileCorner& centre, double radius) {
  const double dr = centre.radius - from.radius;
  const double dz = centre.z - from.z;
  const double along = dr * std::cos(slope) + dz * std::sin(slope);
  const double off = dr * std::sin(slope) - dz * std::cos(slope);
  return {along, radius * radius - off * off};
}

ProfileCorner on_line(const ProfileCorner& from, double slope, double along) {
  return {from.radius + along * std::cos(slope), from.z + along * std::sin(slope)};
}

double kappa_at(const ProfileCorner& centre, const ProfileCorner& at) {
  return std::atan2(at.radius - centre.radius, centre.z - at.z);
}

[[noreturn]] void refuse(const char* field, double value, const char* rule) {
  throw InvalidInput(Fault{field, fmt::format("{:g} mm", value / units::mm), rule,
                           "see the drawing of the general cutter in the theory of cutting"});
}

}  // namespace

AptJoints apt_joints(const AptShape& apt, double corner_radius, double height) {
  require_positive("cutter.diameter_mm", apt.diameter / units::mm, "mm");
  require_non_negative("cutter.corner_radius_mm", corner_radius / units::mm, "mm");
  require_non_negative("cutter.corner_centre_radius_mm", apt.corner_r / units::mm, "mm");
  require_non_negative("cutter.corner_centre_height_mm", apt.corner_z / units::mm, "mm");
  require_within("cutter.bottom_deg", apt.bottom_angle / units::deg, 0.0, 85.0, "deg");
  require_within("cutter.taper_deg", apt.side_angle / units::deg, 0.0, 80.0, "deg");
  require_positive("cutter.cutting_length_mm", height / units::mm, "mm");
  const ProfileCorner centre{apt.corner_r, apt.corner_z};
  const double side = kQuarter - apt.side_angle;
  // Where the two lines meet.
  const ProfileCorner vertex{0.5 * apt.diameter, 0.5 * apt.diameter * std::tan(apt.bottom_angle)};
  AptJoints joints;
  if (corner_radius == 0.0) {
    joints.lower = joints.upper = vertex;
    joints.lower_kappa = apt.bottom_angle;
    joints.upper_kappa = side;
  } else {
    const Chord below = chord({}, apt.bottom_angle, centre, corner_radius);
    const Chord above = chord(vertex, side, centre, corner_radius);
    // A tangent line has a chord of nothing; numbers in a file are rounded to 1e-4 of the radius.
    const double least = -2e-4 * corner_radius * corner_radius;
    if (below.half_sq < least) {
      refuse("cutter.corner_radius_mm", corner_radius, "must reach the lower line");
    }
    if (above.half_sq < least) {
      refuse("cutter.corner_radius_mm", corner_radius, "must reach the upper line");
    }
    joints.lower =
        on_line({}, apt.bottom_angle, below.middle + std::sqrt(std::max(0.0, below.half_sq)));
    joints.upper = on_line(vertex, side, above.middle - std::sqrt(std::max(0.0, above.half_sq)));
    joints.lower_kappa = kappa_at(centre, joints.lower);
    joints.upper_kappa = kappa_at(centre, joints.upper);
  }
  // 1e-3 rad: what the rounding above can turn a tangent by.
  if (joints.lower.radius < -1e-12 || joints.upper_kappa < joints.lower_kappa - 1e-3 ||
      joints.upper_kappa > kQuarter + 1e-3 || joints.lower_kappa < -1e-3) {
    refuse("cutter.corner_centre_radius_mm", apt.corner_r,
           "must make a profile that rises outwards from the lower line to the upper one");
  }
  joints.upper_kappa = std::min(joints.upper_kappa, kQuarter);
  joints.lower_kappa = std::max(0.0, std::min(joints.lower_kappa, joints.upper_kappa));
  if (height < joints.upper.z) {
    refuse("cutter.cutting_length_mm", height, "must reach above the corner");
  }
  joints.top_radius = joints.upper.radius + (height - joints.upper.z) * std::tan(apt.side_angle);
  return joints;
}

}  // namespace osteomill::cutting
