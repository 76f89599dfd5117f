// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>

#include "osteomill/identify/instantaneous.hpp"

namespace osteomill::identify {

std::vector<std::string> verdict_of(const InstantaneousFit& fit, double confidence) {
  std::vector<std::string> verdict;
  std::string open;
  std::string held;
  for (const Estimate& one : fit.estimates) {
    std::string& names = one.at_limit ? held : open;
    if (!one.determined) names += (names.empty() ? "" : ", ") + one.name;
  }
  if (!held.empty()) {
    verdict.push_back(
        fmt::format("{} stands at the end of what the law may be: the data would go beyond", held));
  }
  if (!open.empty()) {
    verdict.push_back(
        fmt::format("these data do not determine {}: other values of them fit as well", open));
  }
  for (std::size_t i = 0; i < fit.estimates.size(); ++i) {
    const Estimate& one = fit.estimates[i];
    if (!one.determined) continue;
    // Pressures and edge forces; the numbers of a log law may be of either sign.
    const bool force = one.name[2] == 'c' || one.name[2] == 'e';
    if (force && one.low < 0.0 && one.high > 0.0) {
      verdict.push_back(fmt::format(
          "{} cannot be told from zero at {:g} %: its standard error is "
          "{:.0f} % of it",
          one.name, 100.0 * confidence, 100.0 * one.standard_error / std::abs(one.value)));
    }
    for (std::size_t k = i + 1; k < fit.estimates.size(); ++k) {
      const auto a = static_cast<Eigen::Index>(i);
      const auto b = static_cast<Eigen::Index>(k);
      const double both = std::sqrt(fit.covariance(a, a) * fit.covariance(b, b));
      if (!fit.estimates[k].determined || both <= 0.0) continue;
      const double correlation = fit.covariance(a, b) / both;
      if (std::abs(correlation) > 0.95) {
        verdict.push_back(
            fmt::format("{} and {} go together (correlation {:.2f}): the data say more about their "
                        "{} than about either",
                        one.name, fit.estimates[k].name, correlation,
                        correlation > 0.0 ? "difference" : "sum"));
      }
    }
  }
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    // Twice the scatter: neither chance nor a few unknowns too many make that.
    if (fit.noise_rms[axis] > 0.0 && fit.residual_rms[axis] > 2.0 * fit.noise_rms[axis]) {
      verdict.push_back(fmt::format(
          "F{} is missed by {:.3g} N rms where the scatter of the revolutions explains {:.3g} N: "
          "the model lacks something, and the intervals were widened for it",
          "xyz"[axis], fit.residual_rms[axis], fit.noise_rms[axis]));
    }
  }
  if (fit.status == FitStatus::iteration_limit) {
    verdict.emplace_back("the search ended at its limit of iterations and may not be at the best");
  }
  return verdict;
}

}  // namespace osteomill::identify
