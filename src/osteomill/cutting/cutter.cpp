// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/cutter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/envelope.hpp"

namespace osteomill::cutting {
namespace {

void check_profile(const Cutter& cutter) {
  const auto refuse = [](const std::string& held, const char* rule) {
    throw InvalidInput(Fault{"cutter.profile_mm", held, rule, ""});
  };
  if (cutter.profile.size() < 2) {
    refuse(fmt::format("{} points", cutter.profile.size()), "needs two points or more");
  }
  for (std::size_t i = 0; i < cutter.profile.size(); ++i) {
    const ProfileCorner& here = cutter.profile[i];
    const std::string held =
        fmt::format("[{:g}, {:g}] mm", here.radius / units::mm, here.z / units::mm);
    if (!(std::isfinite(here.radius) && std::isfinite(here.z))) refuse(held, "must be numbers");
    if (here.radius < 0.0 || here.radius > cutter.radius * (1.0 + 1e-9)) {
      refuse(held, "must have a radius between 0 and half the diameter");
    }
    if (i == 0 ? here.z != 0.0
               : here.z < cutter.profile[i - 1].z || here.radius < cutter.profile[i - 1].radius ||
                     (here.z == cutter.profile[i - 1].z &&
                      here.radius == cutter.profile[i - 1].radius)) {
      refuse(held, "must rise from z = 0 at the tip, with a radius that does not fall");
    }
  }
}

void check_corner(const Cutter& cutter) {
  const double corner =
      require_positive("cutter.corner_radius_mm", cutter.corner_radius / units::mm, "mm");
  require_within("cutter.corner_radius_mm", corner, 0.0, cutter.radius / units::mm * (1.0 + 1e-12),
                 "mm");
  if (cutter.shape == CutterShape::tapered) {
    require_within("cutter.taper_deg", cutter.taper_angle / units::deg, 0.0, 80.0, "deg");
  }
}

void check_flutes(const Cutter& cutter) {
  const auto flutes = static_cast<std::size_t>(cutter.flutes);
  if (!cutter.pitch.empty()) {
    const double turn = std::accumulate(cutter.pitch.begin(), cutter.pitch.end(), 0.0);
    const bool positive =
        std::all_of(cutter.pitch.begin(), cutter.pitch.end(), [](double p) { return p > 0.0; });
    // Degrees in a file are rounded: a thousandth of a degree.
    if (cutter.pitch.size() != flutes || !positive ||
        !(std::abs(turn - 2.0 * std::numbers::pi) < 1e-3 * units::deg)) {
      throw InvalidInput(
          Fault{"cutter.pitch_deg",
                fmt::format("{} angles, sum {:g} deg", cutter.pitch.size(), turn / units::deg),
                fmt::format("must be {} positive angles that sum to 360 deg", flutes), ""});
    }
  }
  if (!cutter.radius_error.empty() && cutter.radius_error.size() != flutes) {
    throw InvalidInput(Fault{"cutter.radius_error_um",
                             fmt::format("{} values", cutter.radius_error.size()),
                             fmt::format("must be one a flute: {}", flutes), ""});
  }
  for (const double error : cutter.radius_error) {
    require_within("cutter.radius_error_um", error / units::um, -200.0, 200.0, "um");
  }
  require_within("cutter.run_out.offset_um", cutter.run_out.offset / units::um, 0.0, 500.0, "um");
  require_within("cutter.run_out.tilt_um_per_mm", cutter.run_out.tilt / 1e-3, -20.0, 20.0, "um/mm");
}

}  // namespace

void check(const Cutter& cutter) {
  require_positive("cutter.diameter_mm", 2.0 * cutter.radius / units::mm, "mm");
  require_within("cutter.flutes", cutter.flutes, 1.0, 64.0, "");
  require_within("cutter.helix_deg", cutter.helix_angle / units::deg, -75.0, 75.0, "deg");
  require_within("cutter.rake_deg", cutter.rake_angle / units::deg, -60.0, 60.0, "deg");
  require_positive("cutter.cutting_length_mm", cutter.cutting_length / units::mm, "mm");
  if (cutter.shape == CutterShape::bull || cutter.shape == CutterShape::tapered) {
    check_corner(cutter);
  }
  if (cutter.shape == CutterShape::profile) check_profile(cutter);
  if (cutter.shape == CutterShape::apt) {
    const AptJoints joints = apt_joints(cutter.apt, cutter.corner_radius, cutter.cutting_length);
    // Rounding of millimetres in a file.
    if (!(std::abs(joints.top_radius - cutter.radius) < 1e-9 * units::mm + 1e-9 * cutter.radius)) {
      throw InvalidInput(Fault{"cutter.radius", fmt::format("{:g} mm", cutter.radius / units::mm),
                               "must be the radius at the top of the upper line", ""});
    }
  }
  check_flutes(cutter);
  if (cutter.shank) check(*cutter.shank, cutter);
}

double radius_at(const Cutter& cutter, double z) {
  switch (cutter.shape) {
    case CutterShape::cylindrical:
      return cutter.radius;
    case CutterShape::ball:
      return z >= cutter.radius ? cutter.radius
                                : std::sqrt(std::max(0.0, z * (2.0 * cutter.radius - z)));
    default:
      break;
  }
  const Envelope envelope(cutter);
  return envelope.at(envelope.length_to(z)).radius;
}

double axial_position_angle(const Cutter& cutter, double z) {
  switch (cutter.shape) {
    case CutterShape::cylindrical:
      return std::numbers::pi / 2.0;
    case CutterShape::ball:
      return z >= cutter.radius ? std::numbers::pi / 2.0
                                : std::acos(std::clamp(1.0 - z / cutter.radius, -1.0, 1.0));
    default:
      break;
  }
  const Envelope envelope(cutter);
  return envelope.at(envelope.length_to(z)).kappa;
}

double lag_angle(const Cutter& cutter, double z) {
  if (cutter.lead == Lead::constant_lead) return z * std::tan(cutter.helix_angle) / cutter.radius;
  const Envelope envelope(cutter);
  return envelope.at(envelope.length_to(z)).lag;
}

}  // namespace osteomill::cutting
