// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/condition.hpp"

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/flutes.hpp"

namespace osteomill::cutting {

geometry::Vector3 fibre_at_angle(double fibre_angle) {
  return {std::cos(fibre_angle), std::sin(fibre_angle), 0.0};
}

geometry::Vector3 feed_direction(const Condition& condition) {
  return {std::cos(condition.feed_elevation), 0.0, std::sin(condition.feed_elevation)};
}

double feed_per_tooth(double feed_rate, double spindle_speed, int flutes) {
  return feed_rate * 2.0 * std::numbers::pi / (spindle_speed * flutes);
}

double feed_rate(const Condition& condition, int flutes) {
  return condition.feed_per_tooth * condition.spindle_speed * flutes / (2.0 * std::numbers::pi);
}

void check(const Condition& condition, const Cutter& cutter) {
  const double speed_rpm =
      require_positive("cut.spindle_speed_rpm", condition.spindle_speed / units::rpm, "rpm");
  if (speed_rpm > 250000.0) {
    throw InvalidInput(Fault{"cut.spindle_speed_rpm", std::to_string(speed_rpm) + " rpm",
                             "must be <= 250000 rpm, faster than any surgical spindle",
                             "check the unit: revolutions per minute"});
  }
  const double feed_mm =
      require_non_negative("cut.feed_per_tooth_mm", condition.feed_per_tooth / units::mm, "mm");
  if (condition.feed_per_tooth > 0.25 * cutter.radius) {
    throw InvalidInput(
        Fault{"cut.feed_per_tooth_mm", std::to_string(feed_mm) + " mm",
              "must be <= a quarter of the cutter's radius",
              "check the unit: millimetres a tooth; bone is milled at 0.0005 ... 0.35"});
  }
  require_within("cut.feed_elevation_deg", condition.feed_elevation / units::deg, -90.0, 90.0,
                 "deg");
  if (condition.path == ToothPath::trochoidal &&
      (condition.feed_elevation != 0.0 || !Flutes(cutter).equal())) {
    throw InvalidInput(Fault{"cut.tooth_path", "trochoidal",
                             "needs a horizontal feed and equal flutes without run-out",
                             "take the circular path"});
  }
  if (!(std::abs(condition.fibre_T.norm() - 1.0) < 1e-9)) {
    throw InvalidInput(Fault{"cut.fibre_angle_deg", "", "fibres must have a direction", ""});
  }
}

void check(const Immersion& immersion, const Cutter& cutter) {
  const double depth =
      require_positive("cut.axial_depth_mm", immersion.axial_depth / units::mm, "mm");
  if (immersion.axial_depth > cutter.cutting_length * (1.0 + 1e-12)) {
    throw InvalidInput(Fault{"cut.axial_depth_mm", std::to_string(depth) + " mm",
                             "must be <= the cutter's cutting length of " +
                                 std::to_string(cutter.cutting_length / units::mm) + " mm",
                             "lower the depth or set cutter.cutting_length_mm"});
  }
  if (immersion.kind != ImmersionKind::slot) {
    require_positive("cut.radial_depth_mm", immersion.radial_depth / units::mm, "mm");
    require_within("cut.radial_depth_mm", immersion.radial_depth / units::mm, 0.0,
                   2.0 * cutter.radius / units::mm, "mm");
  }
}

LateralBand band(const Immersion& immersion, const Cutter& cutter) {
  const double radius = cutter.radius;
  switch (immersion.kind) {
    case ImmersionKind::up:
      return {radius - immersion.radial_depth, radius};
    case ImmersionKind::down:
      return {-radius, immersion.radial_depth - radius};
    case ImmersionKind::slot:
      break;
  }
  return {-radius, radius};
}

}  // namespace osteomill::cutting
