// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/engaged_force.hpp"
#include "osteomill/cutting/flutes.hpp"

namespace osteomill::cutting {
namespace {

using geometry::Vector3;
constexpr double kTurn = 2.0 * std::numbers::pi;

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
  const double held = cutter.shank ? cutter.shank->free_length : cutter.cutting_length;
  for (const Load& load : result.revolution.loads) {
    result.peak = result.peak.cwiseMax(load.force.cwiseAbs());
    result.peak_resultant = std::max(result.peak_resultant, load.force.norm());
    result.rms += load.force.cwiseAbs2() / steps;
    result.peak_torque = std::max(result.peak_torque, std::abs(load.torque()));
    result.bending_moments.push_back(load.bending_moment(held));
    result.peak_bending_moment =
        std::max(result.peak_bending_moment, result.bending_moments.back());
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
  SolvedCut solved;
  std::vector<Vector3> flutes;
  for (const Load& one : flute_means(cutter, law, condition, immersion)) {
    solved.mean += one;
    flutes.push_back(one.force);
  }
  if (has_edge_force(law)) {
    solved.rubbing = mean_load(cutter, edge_part(law), condition, immersion);
  }
  solved.revolution = revolution(cutter, law, condition, immersion, options.steps);
  solved.removal_rate = removal_rate(cutter, condition, immersion);
  solved.largest_chip = largest_chip(cutter, condition, immersion);
  Prediction result = summarise(cutter, law, condition, solved, options);
  result.flute_means = flutes;
  return result;
}

Prediction predict(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
                   const Engagement& map, const PredictionOptions& options) {
  if (condition.path == ToothPath::trochoidal) {
    throw InvalidInput(Fault{"cut.tooth_path", "trochoidal",
                             "needs a nominal immersion without lead and tilt",
                             "take the circular path"});
  }
  const Flutes flutes(cutter);
  const EngagedForce model(cutter, law, map.angles, map.slices, map.slice_height);
  SolvedCut solved;
  solved.mean = model.mean(map, condition);
  if (has_edge_force(law)) {
    solved.rubbing = EngagedForce(cutter, edge_part(law), map.angles, map.slices, map.slice_height)
                         .mean(map, condition);
  }
  solved.revolution = model.revolution(map, condition, options.steps);
  const Envelope envelope(cutter);
  double area = 0.0;
  for (int slice = 0; slice < map.slices; ++slice) {
    const double from = envelope.length_to(slice * map.slice_height);
    const double to = envelope.length_to((slice + 1) * map.slice_height);
    const ProfilePoint point = envelope.at(0.5 * (from + to));
    for (int angle = 0; angle < map.angles; ++angle) {
      const double weight = map.at(slice, angle);
      if (weight == 0.0) continue;
      const double theta = kTurn * (angle + 0.5) / map.angles;
      const double into =
          std::max(0.0, outward_normal(theta, point.kappa).dot(feed_direction(condition)));
      for (int flute = 0; flute < flutes.count(); ++flute) {
        solved.largest_chip = std::max(solved.largest_chip,
                                       flutes.chip(flute, point, condition.feed_per_tooth, into));
      }
      area += weight * (to - from) * point.radius * kTurn / map.angles * into;
    }
  }
  solved.removal_rate = area * feed_rate(condition, cutter.flutes);
  Prediction result = summarise(cutter, law, condition, solved, options);
  if (flutes.equal()) {
    result.flute_means.assign(static_cast<std::size_t>(cutter.flutes),
                              Vector3(solved.mean.force / cutter.flutes));
  }
  return result;
}

}  // namespace osteomill::cutting
