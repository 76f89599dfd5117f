// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/linearised_cut.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/envelope.hpp"
#include "osteomill/cutting/flutes.hpp"

namespace osteomill::vibration {

ContactAngles contact_angles(cutting::ImmersionKind kind, double share) {
  constexpr double pi = std::numbers::pi;
  if (kind == cutting::ImmersionKind::slot) return {0.0, pi};
  require_within("cut.radial_immersion", share, 1e-4, 1.0, "");
  const double arc = std::acos(1.0 - 2.0 * share);
  return kind == cutting::ImmersionKind::up ? ContactAngles{0.0, arc} : ContactAngles{pi - arc, pi};
}

Regeneration linearised_cut(const cutting::Cutter& cutter, const cutting::CuttingLaw& law,
                            const cutting::Condition& condition,
                            const cutting::Immersion& immersion, double thinnest_chip) {
  check(cutter);
  check(condition, cutter);
  check(immersion, cutter);
  check(law);
  require_positive("thinnest chip", thinnest_chip / units::um, "um");
  if (cutter.shape != cutting::CutterShape::cylindrical) {
    throw InvalidInput(Fault{"cutter.shape", "not cylindrical",
                             "stability is worked out for cylindrical cutters",
                             "use shape = \"cylindrical\" with the diameter at the cut"});
  }
  if (!cutting::Flutes(cutter).equal()) {
    throw InvalidInput(Fault{"cutter", "unequal flutes or run-out",
                             "stability is worked out for equal flutes, which have one delay",
                             "leave out pitch, radius errors and run-out"});
  }
  const ContactAngles contact =
      contact_angles(immersion.kind, 0.5 * immersion.radial_depth / cutter.radius);
  const cutting::ProfilePoint point = cutting::Envelope(cutter).at(0.0);
  const auto stiffness = [&](double theta) {
    const geometry::Vector3 t = cutting::motion(theta);
    const geometry::Vector3 n = cutting::outward_normal(theta, point.kappa);
    const double h =
        std::max(thinnest_chip, cutting::chip_thickness(condition, theta, point.kappa));
    const double step = 1e-3 * h;  // central difference: relative error 1e-6, rounding 1e-12
    const geometry::Vector3 slope =
        (cutting::edge_force(law, h + step, condition.fibre_T, t, n, point) -
         cutting::edge_force(law, h - step, condition.fibre_T, t, n, point)) /
        (2.0 * step);
    return EdgeStiffness{.tangential = -slope.dot(t), .radial = -slope.dot(n)};
  };
  return {cutter.flutes, contact.entry, contact.exit, cutting::lag_angle(cutter, 1e-3) / 1e-3,
          stiffness};
}

}  // namespace osteomill::vibration
