// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/dynamometer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/identify/fourier.hpp"

namespace osteomill::identify {
namespace {

using Complex = std::complex<double>;

/// Straight line between the measured lines, from 1 at rest to the first.
Complex response_at(const DynamometerResponse& dynamometer, int axis, double f) {
  const auto& lines = dynamometer.frequency_hz;
  const auto above = std::lower_bound(lines.begin(), lines.end(), f) - lines.begin();
  const auto next = std::min<Eigen::Index>(above, static_cast<Eigen::Index>(lines.size()) - 1);
  const double low = next == 0 ? 0.0 : lines[static_cast<std::size_t>(next - 1)];
  const Complex from = next == 0 ? Complex(1.0) : dynamometer.response(next - 1, axis);
  const double share = (f - low) / (lines[static_cast<std::size_t>(next)] - low);
  return from + std::min(1.0, share) * (dynamometer.response(next, axis) - from);
}

double check(const DynamometerResponse& dynamometer, const CompensationOptions& options) {
  const auto& lines = dynamometer.frequency_hz;
  if (lines.empty() || dynamometer.response.rows() != static_cast<Eigen::Index>(lines.size())) {
    throw InvalidInput({"signals.dynamometer_frf", fmt::format("{} lines", lines.size()),
                        "must have a response for each frequency, one at least", ""});
  }
  double before = 0.0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!(lines[i] > before) || !dynamometer.response.row(static_cast<Eigen::Index>(i)).allFinite())
      throw InvalidInput({"signals.dynamometer_frf", fmt::format("{:g} Hz", lines[i]),
                          "must have growing frequencies above 0 and finite values", ""});
    before = lines[i];
  }
  require_within("signals.noise_floor", options.noise_floor, 1e-6, 1.0, "");
  if (options.highest_hz > lines.back()) {
    throw InvalidInput({"signals.highest_hz", fmt::format("{:g} Hz", options.highest_hz),
                        fmt::format("must not lie above the measured response, which ends at {:g} "
                                    "Hz",
                                    lines.back()),
                        "lower it or leave it out"});
  }
  return options.highest_hz > 0.0 ? options.highest_hz : lines.back();
}

}  // namespace

ForceRecord compensate(const ForceRecord& record, const DynamometerResponse& dynamometer,
                       const CompensationOptions& options) {
  const double highest = check(dynamometer, options);
  // The last tenth of the band fades out.
  const double fade = 0.9 * highest;
  const Eigen::Index n = record.force.rows();
  // As long as the slowest measured line rings: beyond, the response says nothing.
  const auto memory = static_cast<Eigen::Index>(2.0 * record.rate / dynamometer.frequency_hz[0]);
  const Eigen::Index extension =
      std::clamp<Eigen::Index>(memory, 0, std::max<Eigen::Index>(0, n - 1));
  const std::size_t length = fast_length(static_cast<std::size_t>(n + 2 * extension));
  ForceRecord out = record;
  Eigen::VectorXd extended(n + 2 * extension);
  for (int axis = 0; axis < 3; ++axis) {
    const auto x = record.force.col(axis);
    for (Eigen::Index i = 0; i < extension; ++i) {
      extended[i] = 2.0 * x[0] - x[extension - i];
      extended[extension + n + i] = 2.0 * x[n - 1] - x[n - 2 - i];
    }
    extended.segment(extension, n) = x;
    // A straight line from end to end away, so that the ends meet.
    const double from = extended[0],
                 slope = (extended[extended.size() - 1] - from) /
                         std::max<double>(1.0, static_cast<double>(extended.size() - 1));
    const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(
        extended.size(), from, from + slope * static_cast<double>(extended.size() - 1));
    Spectrum spectrum = forward(extended - line, length);
    for (std::size_t k = 0; 2 * k <= length; ++k) {
      const double f = record.rate * static_cast<double>(k) / static_cast<double>(length);
      Complex gain = 0.0;
      if (f < highest) {
        const Complex h = response_at(dynamometer, axis, f);
        gain = std::conj(h) / std::max(std::norm(h), options.noise_floor * options.noise_floor);
        if (f > fade)
          gain *= 0.5 + 0.5 * std::cos(std::numbers::pi * (f - fade) / (highest - fade));
      }
      spectrum[k] *= gain;
      if (k > 0 && 2 * k < length) spectrum[length - k] *= std::conj(gain);
    }
    // Half the rate has no phase of its own.
    if (length % 2 == 0) spectrum[length / 2] = spectrum[length / 2].real();
    const Spectrum applied = backward(spectrum);
    for (Eigen::Index i = 0; i < n; ++i) {
      out.force(i, axis) =
          applied[static_cast<std::size_t>(extension + i)].real() + line[extension + i];
    }
  }
  return out;
}

}  // namespace osteomill::identify
