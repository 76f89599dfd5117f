// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/law_interpolation.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/law_fit.hpp"

namespace osteomill::cutting {
namespace {

/// Blend of two log laws over their common range, as a log law; keeps the largest deviation.
LogLaw blend(const EdgeForce& low, const EdgeForce& high, double share, double& deviation) {
  if (!std::holds_alternative<LogLaw>(low) || !std::holds_alternative<LogLaw>(high)) {
    throw InvalidInput(Fault{"bone.law",
                             std::string(name_of(low)) + ", " + std::string(name_of(high)),
                             "must be log laws to be interpolated", "fit log laws to the cuts"});
  }
  const double from = std::max({range_of(low).low, range_of(high).low, 0.1 * units::um});
  const double to = std::min({range_of(low).high, range_of(high).high, 500.0 * units::um});
  if (!(to > from)) {
    throw InvalidInput(Fault{"bone.range_um", "", "must overlap to be interpolated", ""});
  }
  constexpr int kPoints = 60;
  std::vector<OrthogonalCut> cuts;
  for (int i = 0; i < kPoints; ++i) {
    const double h = from * std::pow(to / from, i / (kPoints - 1.0));
    cuts.push_back({h, (1.0 - share) * force_per_width(low, h) + share * force_per_width(high, h)});
  }
  LogLaw law = fit_log_law(cuts).law;
  law.range = {from, to};
  for (const OrthogonalCut& cut : cuts) {
    deviation = std::max(deviation, std::abs(force_per_width(law, cut.h) / cut.force - 1.0));
  }
  return law;
}

DirectionalLaw blend(const DirectionalLaw& low, const DirectionalLaw& high, double share,
                     double& deviation) {
  DirectionalLaw law{blend(low.at_0, high.at_0, share, deviation), {}};
  if (low.at_90 || high.at_90) {
    law.at_90 =
        blend(low.at_90.value_or(low.at_0), high.at_90.value_or(high.at_0), share, deviation);
  }
  return law;
}

}  // namespace

InterpolatedLaw interpolate(const TestedLaw& low, const TestedLaw& high, double angle) {
  if (low.angle > high.angle) return interpolate(high, low, angle);
  require_within("angle_deg", angle / units::deg, low.angle / units::deg, high.angle / units::deg,
                 "deg");
  const double share =
      high.angle > low.angle ? (angle - low.angle) / (high.angle - low.angle) : 0.0;
  InterpolatedLaw result;
  // The criterion of the law that tells directions apart.
  result.law = high.law.tangential.at_90 ? high.law : low.law;
  double& deviation = result.largest_deviation;
  result.law.tangential = blend(low.law.tangential, high.law.tangential, share, deviation);
  result.law.radial = blend(low.law.radial, high.law.radial, share, deviation);
  result.law.lateral.reset();
  if (low.law.lateral && high.law.lateral) {
    result.law.lateral = blend(*low.law.lateral, *high.law.lateral, share, deviation);
  }
  return result;
}

const CuttingLaw& law_at_speed(const CuttingLaw& low_speed, const CuttingLaw& high_speed,
                               double spindle_speed) {
  return spindle_speed <= 100.0 * units::rpm * (1.0 + 1e-12) ? low_speed : high_speed;
}

}  // namespace osteomill::cutting
