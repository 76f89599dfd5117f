// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/law_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <utility>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::cutting {
namespace {

ChipRange range_of(const std::vector<OrthogonalCut>& cuts) {
  const auto [low, high] =
      std::minmax_element(cuts.begin(), cuts.end(),
                          [](const OrthogonalCut& a, const OrthogonalCut& b) { return a.h < b.h; });
  return {low->h, high->h};
}

void check(const std::vector<OrthogonalCut>& cuts) {
  for (const OrthogonalCut& cut : cuts) {
    require_positive("chip_thickness_um", cut.h / units::um, "um");
    require_positive("force_n_per_mm", cut.force / units::n_per_mm, "N/mm");
  }
  std::vector<double> thicknesses;
  for (const OrthogonalCut& cut : cuts) thicknesses.push_back(cut.h);
  std::sort(thicknesses.begin(), thicknesses.end());
  const auto different = std::unique(thicknesses.begin(), thicknesses.end()) - thicknesses.begin();
  if (cuts.size() < 4 || different < 3) {
    throw InvalidInput(
        Fault{"cuts",
              std::to_string(cuts.size()) + " cuts, " + std::to_string(different) + " thicknesses",
              "must be four cuts or more at three chip thicknesses or more", "add cuts"});
  }
}

FitQuality quality(const std::vector<OrthogonalCut>& cuts, const EdgeForce& law) {
  const double n = static_cast<double>(cuts.size());
  double square = 0.0, sum = 0.0, sum_square = 0.0;
  for (const OrthogonalCut& cut : cuts) {
    const double residual = force_per_width(law, cut.h) - cut.force;
    square += residual * residual;
    sum += cut.force;
    sum_square += cut.force * cut.force;
  }
  const double spread = sum_square - sum * sum / n;
  constexpr double kParameters = 4.0;  // three of the law and the variance
  const double correction = n > kParameters + 1.0
                                ? 2.0 * kParameters * (kParameters + 1.0) / (n - kParameters - 1.0)
                                : std::numeric_limits<double>::infinity();
  // The least double instead of an exact fit's ln 0.
  const double ms = std::max(square / n, std::numeric_limits<double>::min());
  return {std::sqrt(square / n), spread > 0.0 ? 1.0 - square / spread : 0.0,
          n * std::log(ms) + 2.0 * kParameters + correction};
}

/// Best K and F_e >= 0 for one exponent.
PowerLaw best_for(const std::vector<OrthogonalCut>& cuts, double n) {
  double xx = 0.0, x = 0.0, xf = 0.0, f = 0.0;
  for (const OrthogonalCut& cut : cuts) {
    const double p = std::pow(cut.h / units::mm, n);
    xx += p * p;
    x += p;
    xf += p * cut.force;
    f += cut.force;
  }
  const double count = static_cast<double>(cuts.size());
  const double slope = (count * xf - x * f) / (count * xx - x * x);
  const double edge = (f - slope * x) / count;
  if (slope < 0.0) return {0.0, n, f / count};
  if (edge < 0.0) return {xf / xx, n, 0.0};
  return {slope, n, edge};
}

double misfit(const std::vector<OrthogonalCut>& cuts, const PowerLaw& law) {
  double square = 0.0;
  for (const OrthogonalCut& cut : cuts) {
    const double residual = force_per_width(law, cut.h) - cut.force;
    square += residual * residual;
  }
  return square;
}

}  // namespace

namespace {

/// Forces by chip thickness; thicknesses within 1e-9 of each other are one.
std::vector<std::pair<double, std::vector<double>>> by_thickness(std::vector<OrthogonalCut> cuts) {
  std::stable_sort(cuts.begin(), cuts.end(),
                   [](const OrthogonalCut& a, const OrthogonalCut& b) { return a.h < b.h; });
  std::vector<std::pair<double, std::vector<double>>> groups;
  for (const OrthogonalCut& cut : cuts) {
    if (groups.empty() || cut.h > groups.back().first * (1.0 + 1e-9)) groups.push_back({cut.h, {}});
    groups.back().second.push_back(cut.force);
  }
  return groups;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double squares_about(const std::vector<double>& values, double mean) {
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum;
}

}  // namespace

std::vector<OrthogonalCut> averaged(const std::vector<OrthogonalCut>& cuts) {
  std::vector<OrthogonalCut> means;
  for (const auto& [h, forces] : by_thickness(cuts)) means.push_back({h, mean_of(forces)});
  return means;
}

std::vector<SpeedEffect> speed_effects(const std::vector<OrthogonalCut>& slow,
                                       const std::vector<OrthogonalCut>& fast) {
  std::vector<SpeedEffect> effects;
  const auto fast_groups = by_thickness(fast);
  for (const auto& [h, slow_forces] : by_thickness(slow)) {
    const double thickness = h;
    const auto same = std::find_if(fast_groups.begin(), fast_groups.end(), [&](const auto& group) {
      return std::abs(group.first - thickness) <= 1e-9 * thickness;
    });
    if (same == fast_groups.end() || slow_forces.size() < 2 || same->second.size() < 2) continue;
    SpeedEffect effect;
    effect.h = h;
    effect.slow_cuts = static_cast<int>(slow_forces.size());
    effect.fast_cuts = static_cast<int>(same->second.size());
    effect.slow_mean = mean_of(slow_forces);
    effect.fast_mean = mean_of(same->second);
    effect.degrees_of_freedom = effect.slow_cuts + effect.fast_cuts - 2.0;
    const double variance = (squares_about(slow_forces, effect.slow_mean) +
                             squares_about(same->second, effect.fast_mean)) /
                            effect.degrees_of_freedom;
    if (!(variance > 0.0)) continue;
    effect.t = (effect.fast_mean - effect.slow_mean) /
               std::sqrt(variance * (1.0 / effect.slow_cuts + 1.0 / effect.fast_cuts));
    effect.p = numerics::student_t_two_sided_p(effect.t, effect.degrees_of_freedom);
    effects.push_back(effect);
  }
  return effects;
}

PowerFit fit_power_law(const std::vector<OrthogonalCut>& cuts) {
  check(cuts);
  const auto cost = [&](double n) { return misfit(cuts, best_for(cuts, n)); };
  // The bound on F_e can give two valleys: scan, then refine in the lowest.
  constexpr double kLow = 0.02, kHigh = 1.5;
  constexpr int kSteps = 74;
  const auto at = [&](int i) { return kLow + (kHigh - kLow) * i / kSteps; };
  int lowest = 0;
  for (int i = 1; i <= kSteps; ++i) {
    if (cost(at(i)) < cost(at(lowest))) lowest = i;
  }
  const double n = boost::math::tools::brent_find_minima(cost, at(std::max(0, lowest - 1)),
                                                         at(std::min(kSteps, lowest + 1)), 40)
                       .first;
  PowerFit fit;
  fit.law = best_for(cuts, n);
  fit.law.range = range_of(cuts);
  fit.constant = fit.law.at_1_mm == 0.0;
  fit.edge_at_bound = fit.law.edge == 0.0;
  if (fit.constant) {
    const double count = static_cast<double>(cuts.size());
    fit.standard_errors[2] = std::sqrt(misfit(cuts, fit.law) / (count - 1.0) / count);
    fit.quality = quality(cuts, fit.law);
    fit.status = "fitted";
    return fit;
  }
  const Eigen::Index parameters = fit.edge_at_bound ? 2 : 3;
  Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(cuts.size()), parameters);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double x = cuts[i].h / units::mm;
    jacobian(row, 0) = std::pow(x, n);
    jacobian(row, 1) = fit.law.at_1_mm * std::pow(x, n) * std::log(x);
    if (!fit.edge_at_bound) jacobian(row, 2) = 1.0;
  }
  const double degrees = static_cast<double>(cuts.size()) - static_cast<double>(parameters);
  const Eigen::MatrixXd covariance =
      misfit(cuts, fit.law) / degrees * (jacobian.transpose() * jacobian).inverse();
  for (Eigen::Index i = 0; i < parameters; ++i) {
    fit.standard_errors[static_cast<std::size_t>(i)] = std::sqrt(covariance(i, i));
  }
  fit.quality = quality(cuts, fit.law);
  fit.status = "fitted";
  return fit;
}

LogFit fit_log_law(const std::vector<OrthogonalCut>& cuts) {
  check(cuts);
  const auto count = static_cast<Eigen::Index>(cuts.size());
  Eigen::MatrixXd a(count, 3);
  Eigen::VectorXd b(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const OrthogonalCut& cut = cuts[static_cast<std::size_t>(i)];
    const double l = std::log10(cut.h / units::um);
    a.row(i) << 1.0, l, l * l;
    b(i) = std::log10(cut.force / units::n_per_mm);
  }
  const Eigen::Vector3d k = a.householderQr().solve(b);
  LogFit fit;
  fit.law = {k(0), k(1), k(2), range_of(cuts)};
  const double variance = (a * k - b).squaredNorm() / static_cast<double>(count - 3);
  const Eigen::Matrix3d covariance = variance * (a.transpose() * a).inverse();
  for (int i = 0; i < 3; ++i) {
    fit.standard_errors[static_cast<std::size_t>(i)] = std::sqrt(covariance(i, i));
  }
  fit.quality = quality(cuts, fit.law);
  fit.status = "fitted";
  return fit;
}

}  // namespace osteomill::cutting
