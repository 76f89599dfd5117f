// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

using geometry::Vector3;

/// Amplitude of the k-th harmonic of each component.
Vector3 harmonic(const Revolution& revolution, int k) {
  Eigen::Vector3cd sum = Eigen::Vector3cd::Zero();
  for (std::size_t i = 0; i < revolution.loads.size(); ++i) {
    sum += std::polar(1.0, -k * revolution.angle[i]) * revolution.loads[i].force;
  }
  return 2.0 / static_cast<double>(revolution.loads.size()) * sum.cwiseAbs();
}

}  // namespace

std::vector<std::string> range_warnings(const CuttingLaw& law, double largest_chip) {
  const ChipRange range = range_of(law);
  if (largest_chip > range.high * (1.0 + 1e-9) || largest_chip < range.low * (1.0 - 1e-9)) {
    return {fmt::format(
        "the largest chip is {:.3g} um; the law was measured on {:.3g} ... {:.3g} um and is "
        "extrapolated",
        largest_chip / units::um, range.low / units::um, range.high / units::um)};
  }
  return {};
}

Prediction summarise(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
                     const SolvedCut& solved, const PredictionOptions& options) {
  Prediction result;
  result.mean = solved.mean;
  result.revolution = solved.revolution;
  const double steps = static_cast<double>(result.revolution.loads.size());
  for (const Load& load : result.revolution.loads) {
    result.peak = result.peak.cwiseMax(load.force.cwiseAbs());
    result.peak_resultant = std::max(result.peak_resultant, load.force.norm());
    result.rms += load.force.cwiseAbs2() / steps;
    result.peak_torque = std::max(result.peak_torque, std::abs(load.torque()));
    result.peak_bending_moment =
        std::max(result.peak_bending_moment, load.bending_moment(cutter.cutting_length));
  }
  result.rms = result.rms.cwiseSqrt();
  result.mean_torque = result.mean.torque();
  result.spindle_power = spindle_power(result.mean, condition.spindle_speed);
  result.rubbing_power = spindle_power(solved.rubbing, condition.spindle_speed);
  const double feed = feed_rate(condition, cutter.flutes);
  result.feed_power = -feed * result.mean.force.dot(feed_direction(condition));
  result.removal_rate = solved.removal_rate;
  if (result.removal_rate > 0.0) {
    result.specific_energy = (result.spindle_power + result.feed_power) / result.removal_rate;
  }
  result.feed_per_tooth = condition.feed_per_tooth;
  result.largest_chip = solved.largest_chip;
  for (int k = 1; k <= options.harmonics; ++k) {
    result.harmonics.push_back(harmonic(result.revolution, k));
  }
  result.warnings = range_warnings(law, result.largest_chip);
  return result;
}

Prediction predict(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
                   const Immersion& immersion, const PredictionOptions& options) {
  Condition still = condition;
  still.feed_per_tooth = 0.0;
  return summarise(
      cutter, law, condition,
      {mean_load(cutter, law, condition, immersion), mean_load(cutter, law, still, immersion),
       revolution(cutter, law, condition, immersion, options.steps),
       removal_rate(cutter, condition, immersion), largest_chip(cutter, condition, immersion)},
      options);
}

}  // namespace osteomill::cutting
