// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/next_experiment.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<Experiment> grid(const std::vector<Experiment>& experiments) {
  double least_depth = 1e300, most_depth = 0.0, least_feed = 1e300, most_feed = 0.0;
  for (const Experiment& one : experiments) {
    least_depth = std::min(least_depth, one.immersion.axial_depth);
    most_depth = std::max(most_depth, one.immersion.axial_depth);
    least_feed = std::min(least_feed, one.condition.feed_per_tooth);
    most_feed = std::max(most_feed, one.condition.feed_per_tooth);
  }
  std::vector<Experiment> cuts;
  const cutting::Cutter& cutter = experiments.front().cutter;
  for (const double depth :
       {least_depth, 0.5 * (least_depth + most_depth), most_depth, 1.5 * most_depth}) {
    for (const double feed :
         {0.5 * least_feed, least_feed, most_feed, 2.0 * most_feed, 4.0 * most_feed}) {
      for (const auto kind : {cutting::ImmersionKind::slot, cutting::ImmersionKind::up,
                              cutting::ImmersionKind::down}) {
        Experiment one = experiments.front();
        one.condition.feed_per_tooth = feed;
        one.immersion = {kind, kind == cutting::ImmersionKind::slot ? 0.0 : cutter.radius, depth};
        try {
          cutting::check(one.condition, cutter);
          cutting::check(one.immersion, cutter);
        } catch (const InvalidInput&) {
          continue;  // too deep or too fast for this cutter
        }
        cuts.push_back(one);
      }
    }
  }
  return cuts;
}

/// Covariance with the information of three more means of the present exactness.
MatrixXd with(const MatrixXd& covariance, const MatrixXd& rows, double variance) {
  const MatrixXd gain = rows * covariance;
  const MatrixXd inner =
      gain * rows.transpose() + variance * MatrixXd::Identity(rows.rows(), rows.rows());
  return covariance - gain.transpose() * inner.ldlt().solve(gain);
}

}  // namespace

std::string describe_cut(const Experiment& experiment) {
  const cutting::Immersion& cut = experiment.immersion;
  const char* kind = cut.kind == cutting::ImmersionKind::slot ? "a slot"
                     : cut.kind == cutting::ImmersionKind::up ? "up-milling at half immersion"
                                                              : "down-milling at half immersion";
  return fmt::format("{}, {:.3g} mm deep, at {:.3g} mm a tooth", kind, cut.axial_depth / units::mm,
                     experiment.condition.feed_per_tooth / units::mm);
}

std::vector<SuggestedExperiment> suggest_experiments(const std::vector<Experiment>& experiments,
                                                     const MeanForceFit& fit, int count) {
  std::vector<Index> weak;
  for (std::size_t i = 0; i < fit.coefficients.size(); ++i) {
    const Coefficient& one = fit.coefficients[i];
    if (!one.determined && !one.at_bound && one.standard_error > 0.0) {
      weak.push_back(static_cast<Index>(i));
    }
  }
  if (weak.empty()) return {};
  const std::vector<Experiment> cuts = grid(experiments);
  const MatrixXd sensitivity = sensitivities(fit.model, fit.values, cuts);
  // Of one mean, N²: with weights by standard errors that of a typical one.
  double variance = fit.residual_deviation * fit.residual_deviation;
  if (fit.weighted) {
    double square = 0.0;
    for (const Experiment& one : experiments) square += one.standard_error.squaredNorm();
    variance *= square / (3.0 * static_cast<double>(experiments.size()));
  }
  if (!(variance > 0.0)) return {};
  std::vector<SuggestedExperiment> suggested;
  MatrixXd covariance = fit.covariance;
  for (int round = 0; round < count; ++round) {
    double best_gain = 0.0;
    Index best = -1;
    MatrixXd best_covariance;
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      const auto row = 3 * static_cast<Index>(i);
      const MatrixXd after = with(covariance, sensitivity.middleRows(row, 3), variance);
      double gain = 0.0;
      for (const Index k : weak) gain += 0.5 * std::log(covariance(k, k) / after(k, k));
      if (gain <= best_gain) continue;
      best_gain = gain;
      best = static_cast<Index>(i);
      best_covariance = after;
    }
    if (best < 0) break;
    Index most = weak.front();
    const auto ratio = [&](Index k) { return best_covariance(k, k) / fit.covariance(k, k); };
    for (const Index k : weak) {
      if (ratio(k) < ratio(most)) most = k;
    }
    covariance = best_covariance;
    suggested.push_back({cuts[static_cast<std::size_t>(best)],
                         fit.coefficients[static_cast<std::size_t>(most)].name,
                         std::sqrt(fit.covariance(most, most)), std::sqrt(covariance(most, most))});
  }
  return suggested;
}

}  // namespace osteomill::identify
