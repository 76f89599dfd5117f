// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/plateau_mean.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

/// Means over batches of a length in samples that need not be whole.
Eigen::VectorXd batch_means(const Eigen::Ref<const Eigen::VectorXd>& signal, double length,
                            Eigen::Index count) {
  Eigen::VectorXd means(count);
  Eigen::Index at = 0;
  double sum = 0.0, before = 0.0;  // of the samples before `at`; at the last border
  for (Eigen::Index batch = 0; batch < count; ++batch) {
    const double border = length * static_cast<double>(batch + 1);
    for (; at < signal.size() && static_cast<double>(at + 1) <= border; ++at) sum += signal[at];
    const double share = border - static_cast<double>(at);
    const double here = sum + (at < signal.size() ? share * signal[at] : 0.0);
    means[batch] = (here - before) / length;
    before = here;
  }
  return means;
}

/// Correlation of neighbours in a series with mean zero.
double neighbours(const Eigen::VectorXd& series) {
  const Eigen::Index n = series.size();
  const double power = series.squaredNorm();
  return power > 0.0 ? series.head(n - 1).dot(series.tail(n - 1)) / power : 0.0;
}

/// Variance of the sum of a series with mean zero whose neighbours are correlated: made white by a
/// first-order autoregression, Bartlett's weights over the rest, coloured again [andrews1992].
double variance_of_sum(const Eigen::VectorXd& series) {
  // Beyond 0.97 the record is too short for its own correlation.
  const double memory = std::clamp(neighbours(series), -0.97, 0.97);
  const Eigen::Index n = series.size() - 1;
  const Eigen::VectorXd rest = series.tail(n) - memory * series.head(n);
  // [andrews1991]: lags for Bartlett's weights and a first-order autoregression.
  const double rho = std::clamp(neighbours(rest), -0.97, 0.97);
  const double alpha = 4.0 * rho * rho / std::pow((1.0 - rho) * (1.0 + rho), 2);
  const auto lags = std::min(
      n / 3, static_cast<Eigen::Index>(1.1447 * std::cbrt(alpha * static_cast<double>(n))));
  double sum = rest.squaredNorm();
  for (Eigen::Index lag = 1; lag <= lags; ++lag) {
    const double weight = 1.0 - static_cast<double>(lag) / static_cast<double>(lags + 1);
    sum += 2.0 * weight * rest.head(n - lag).dot(rest.tail(n - lag));
  }
  // The first value of the series has no rest of its own.
  const double length = static_cast<double>(n + 1) / static_cast<double>(n);
  return std::max(0.0, sum) * length / ((1.0 - memory) * (1.0 - memory));
}

}  // namespace

PlateauMean plateau_mean(const Eigen::Ref<const Eigen::VectorXd>& signal, double rate,
                         double period) {
  require_positive("record.rate", rate, "Hz");
  const auto samples = static_cast<double>(signal.size());
  const double length = period > 0.0 ? period * rate : std::floor(std::sqrt(samples));
  // Half a millionth of a sample is rounding.
  const auto count =
      length > 0.0 ? static_cast<Eigen::Index>((samples + 1e-6) / length) : Eigen::Index{0};
  if (count < 3) {
    throw InvalidInput({"plateau", fmt::format("{:.4g} s", samples / rate),
                        period > 0.0
                            ? fmt::format("must hold three revolutions of {:.4g} s", period)
                            : "must hold nine samples",
                        "take a longer cut"});
  }
  const auto n = static_cast<double>(count);
  const Eigen::VectorXd means = batch_means(signal, length, count);
  const Eigen::VectorXd time =
      Eigen::VectorXd::LinSpaced(count, -0.5 * (n - 1.0), 0.5 * (n - 1.0)) * (length / rate);
  PlateauMean out{.mean = means.mean(), .batches = static_cast<int>(count)};
  out.slope = time.dot(means) / time.squaredNorm();
  const Eigen::VectorXd rest = (means.array() - out.mean).matrix() - out.slope * time;
  // What is left of rounding in a signal without noise.
  const double power = rest.squaredNorm();
  if (!(power > 1e-28 * means.squaredNorm())) return out;
  out.autocorrelation = neighbours(rest);
  const double freedom = n / std::max(1.0, n - 2.0);
  out.standard_error = std::sqrt(freedom * variance_of_sum(rest)) / n;
  out.slope_standard_error =
      std::sqrt(freedom * variance_of_sum(rest.cwiseProduct(time))) / time.squaredNorm();
  return out;
}

}  // namespace osteomill::identify
