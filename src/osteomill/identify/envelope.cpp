// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/envelope.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "osteomill/base/error.hpp"
#include "osteomill/identify/fourier.hpp"

namespace osteomill::identify {
namespace {

/// Extreme over a window about each sample; `before(a, b)`: a is more extreme than b. Samples that
/// can no more become the extreme are dropped, so each goes in and out once.
template <class Before>
Eigen::VectorXd moving_extreme(const Eigen::VectorXd& signal, Eigen::Index window, Before before) {
  const Eigen::Index n = signal.size(), half = window / 2;
  Eigen::VectorXd out(n);
  std::deque<Eigen::Index> candidates;
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (; next < std::min(n, i - half + window); ++next) {
      while (!candidates.empty() && !before(signal[candidates.back()], signal[next]))
        candidates.pop_back();
      candidates.push_back(next);
    }
    while (candidates.front() < i - half) candidates.pop_front();
    out[i] = signal[candidates.front()];
  }
  return out;
}

}  // namespace

Envelope analytic_envelope(const Eigen::VectorXd& signal) {
  if (signal.size() == 0) return {};
  const double mean = signal.mean();
  const std::size_t length = fast_length(static_cast<std::size_t>(signal.size()));
  Spectrum spectrum = forward((signal.array() - mean).matrix(), length);
  // Analytic signal: positive frequencies doubled, negative ones away.
  for (std::size_t k = 1; k < length; ++k) {
    if (2 * k < length) spectrum[k] *= 2.0;
    if (2 * k > length) spectrum[k] = 0.0;
  }
  const Spectrum analytic = backward(spectrum);
  Eigen::VectorXd size(signal.size());
  for (Eigen::Index i = 0; i < size.size(); ++i)
    size[i] = std::abs(analytic[static_cast<std::size_t>(i)]);
  return {(mean + size.array()).matrix(), (mean - size.array()).matrix()};
}

Envelope peak_envelope(const Eigen::VectorXd& signal, Eigen::Index window) {
  require_within("envelope.window", static_cast<double>(window), 1, 1e12, "samples");
  return {moving_extreme(signal, window, [](double a, double b) { return a > b; }),
          moving_extreme(signal, window, [](double a, double b) { return a < b; })};
}

Eigen::VectorXd moving_rms(const Eigen::MatrixX3d& force, Eigen::Index window) {
  require_within("envelope.window", static_cast<double>(window), 1, 1e12, "samples");
  const Eigen::Index n = force.rows(), half = window / 2;
  Eigen::VectorXd sum(n + 1);
  sum[0] = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    sum[i + 1] =
        sum[i] + force(i, 0) * force(i, 0) + force(i, 1) * force(i, 1) + force(i, 2) * force(i, 2);
  }
  Eigen::VectorXd out(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index begin = std::max<Eigen::Index>(0, i - half);
    const Eigen::Index end = std::min(n, i - half + window);
    // Rounding of the long sum may leave a tiny negative difference.
    out[i] = std::sqrt(std::max(0.0, sum[end] - sum[begin]) / static_cast<double>(end - begin));
  }
  return out;
}

Eigen::VectorXd cumulative_mean(const Eigen::VectorXd& signal) {
  Eigen::VectorXd out(signal.size());
  double sum = 0.0;
  for (Eigen::Index i = 0; i < signal.size(); ++i) {
    sum += signal[i];
    out[i] = sum / static_cast<double>(i + 1);
  }
  return out;
}

}  // namespace osteomill::identify
