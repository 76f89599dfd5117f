// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/implant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Turned by +90° about z: from the running direction of a profile to its outer side.
Vector2 outward(const Vector2& along) { return {-along.y(), along.x()}; }

[[noreturn]] void refuse(const std::string& value, const std::string& rule,
                         const std::string& remedy) {
  throw InvalidInput(Fault{"implant.profile", value, rule, remedy});
}

}  // namespace

const char* name(Cut cut) {
  switch (cut) {
    case Cut::distal:
      return "distal";
    case Cut::anterior_chamfer:
      return "anterior_chamfer";
    case Cut::anterior:
      return "anterior";
    case Cut::posterior_chamfer:
      return "posterior_chamfer";
    case Cut::posterior:
      return "posterior";
  }
  return "";
}

Profile make_profile(const std::vector<Vector2>& corners) {
  if (corners.size() != 6) {
    refuse(fmt::format("{} corners", corners.size()), "must have 6 corners (five cuts)",
           "list them from the proximal end of the anterior cut to that of the posterior cut");
  }
  for (const Vector2& corner : corners) {
    if (!corner.allFinite()) refuse("not a number", "every corner must be finite", "");
  }
  const Vector2 distal = corners[3] - corners[2];
  if (distal.norm() < 1e-3) {
    refuse(fmt::format("distal cut of {:g} mm", distal.norm() / units::mm), "must be >= 1 mm",
           "check the unit of the drawing");
  }
  // The distal cut runs along −y, the outer side of the running direction is +x.
  const Vector2 posterior = distal.normalized();
  Vector2 distally = outward(posterior);
  const Vector2 middle = 0.5 * (corners[2] + corners[3]);
  const double ends = (corners[0] - middle).dot(distally) + (corners[5] - middle).dot(distally);
  if (ends > 0.0) distally = -distally;  // a mirrored drawing
  Profile profile;
  for (std::size_t i = 0; i < 6; ++i) {
    const Vector2 p = corners[i] - middle;
    profile.corners[i] = {p.dot(distally), -p.dot(posterior)};
  }
  for (std::size_t i = 0; i < 5; ++i) {
    if ((profile.corners[i + 1] - profile.corners[i]).norm() < 1e-4) {
      refuse(fmt::format("cut {} of {:g} mm", i + 1,
                         (profile.corners[i + 1] - profile.corners[i]).norm() / units::mm),
             "every cut must be >= 0.1 mm", "remove the double point");
    }
  }
  for (std::size_t i = 1; i < 5; ++i) {
    const Vector2 before = profile.corners[i] - profile.corners[i - 1];
    const Vector2 after = profile.corners[i + 1] - profile.corners[i];
    if (!(cross(before, after) < 0.0)) {
      const Vector2 corner = profile.corners[i] / units::mm;
      refuse(fmt::format("corner {} at ({:.2f}, {:.2f}) mm", i + 1, corner.x(), corner.y()),
             "must turn towards the bone at every corner",
             "order the corners anterior to posterior and check that the profile is convex");
    }
  }
  return profile;
}

ImplantFamily generic_family() {
  ImplantFamily family;
  for (int size = 0; size < 7; ++size) {
    family.anteroposterior.push_back((45.0 + 20.0 * size / 6.0) * units::mm);
  }
  return family;
}

void check(const ImplantFamily& family) {
  if (family.anteroposterior.empty()) {
    throw InvalidInput(Fault{"implant.anteroposterior_mm", "", "must list at least one size", ""});
  }
  for (const double ap : family.anteroposterior) {
    require_within("implant.anteroposterior_mm", ap / units::mm, 5.0, 200.0, "mm");
  }
  if (!std::is_sorted(family.anteroposterior.begin(), family.anteroposterior.end())) {
    throw InvalidInput(
        Fault{"implant.anteroposterior_mm", "", "must grow from size to size", "sort the list"});
  }
  require_within("implant.distal_half_length", family.distal_half_length, 0.05, 0.45, "AP");
  require_within("implant.anterior", family.anterior, family.distal_half_length + 0.01, 1.0, "AP");
  require_within("implant.posterior", family.posterior, family.distal_half_length + 0.01, 1.0,
                 "AP");
  for (const auto& [field, angle] :
       {std::pair{"implant.anterior_chamfer_deg", family.anterior_chamfer_angle},
        std::pair{"implant.posterior_chamfer_deg", family.posterior_chamfer_angle}}) {
    require_within(field, angle / units::deg, 10.0, 80.0, "deg");
  }
  require_within("implant.anterior_tilt_deg", family.anterior_tilt / units::deg, -15.0, 30.0,
                 "deg");
  require_within("implant.posterior_tilt_deg", family.posterior_tilt / units::deg, -15.0, 30.0,
                 "deg");
  require_within("implant.anterior_length", family.anterior_length, 0.02, 2.0, "AP");
  require_within("implant.posterior_length", family.posterior_length, 0.02, 2.0, "AP");
}

Profile profile_of(const ImplantFamily& family, int size) {
  check(family);
  require_within("implant.size", size, 1.0, static_cast<double>(family.anteroposterior.size()), "");
  const double ap = family.anteroposterior[static_cast<std::size_t>(size - 1)];
  const double half = family.distal_half_length * ap;
  const double anterior_rise = family.anterior * ap - half;
  const double posterior_rise = family.posterior * ap - half;
  const Vector2 anterior_end{-std::tan(family.anterior_chamfer_angle) * anterior_rise,
                             family.anterior * ap};
  const Vector2 posterior_end{-std::tan(family.posterior_chamfer_angle) * posterior_rise,
                              -family.posterior * ap};
  const Vector2 anterior_cut{-std::cos(family.anterior_tilt), std::sin(family.anterior_tilt)};
  const Vector2 posterior_cut{-std::cos(family.posterior_tilt), -std::sin(family.posterior_tilt)};
  return make_profile({anterior_end + family.anterior_length * ap * anterior_cut, anterior_end,
                       Vector2(0.0, half), Vector2(0.0, -half), posterior_end,
                       posterior_end + family.posterior_length * ap * posterior_cut});
}

PerCut<CutLine> cut_lines(const Profile& profile, const CutOptions& options) {
  require_non_negative("options.distal_overhang_mm", options.distal_overhang / units::mm, "mm");
  require_within("robot.tool_thickness_mm", options.tool_thickness / units::mm, 0.0, 30.0, "mm");
  const auto& p = profile.corners;
  PerCut<CutLine> lines;
  const auto line = [&](Cut cut, const Vector2& from, const Vector2& to, const Vector2& outer,
                        double overhang) {
    const Vector2 direction = (to - from).normalized();
    lines[index(cut)] = {from - overhang * direction + 0.5 * options.tool_thickness * outer,
                         direction, (to - from).norm() + overhang};
  };
  const auto outer = [&](std::size_t i) { return outward((p[i + 1] - p[i]).normalized()); };
  line(Cut::distal, p[2], p[3], outer(2), options.distal_overhang);
  line(Cut::anterior_chamfer, p[2], p[1], outer(1), 0.0);
  line(Cut::anterior, p[1], p[0], outer(0), 0.0);
  line(Cut::posterior_chamfer, p[3], p[4], outer(3), 0.0);
  line(Cut::posterior, p[4], p[5], outer(4), 0.0);
  return lines;
}

}  // namespace osteomill::robot
