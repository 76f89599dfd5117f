// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/local_gain.hpp"

#include <algorithm>
#include <cmath>

namespace osteomill::identify {
namespace {

constexpr double kLeastFeed = 1e-4;   // m/s; slower feeds say nothing of the gain
constexpr double kLeastGain = 300.0;  // N/(m/s); spreads are relative to the gain, but not to air
constexpr double kForgetting = 0.98;  // of the likelihoods a period: half a second of memory
constexpr double kNoiseLearning = 0.01;  // a period: one second
constexpr double kLeastNoise = 0.02;     // N²
constexpr double kMostNoise = 9.0;       // N²

double at_least_zero(double value) { return std::max(value, 0.0); }

}  // namespace

void update(GainEstimate& e, double feed, double force, double period,
            const LocalGainOptions& options) noexcept {
  const double v = std::max(feed, kLeastFeed);
  const double dx = v * period;
  // The slope decays over slope_length, the gain takes its integral.
  const double keep = std::exp(-dx / options.slope_length);
  const double reach = options.slope_length * (1.0 - keep);
  double gain = e.gain + e.slope * reach;
  double slope = e.slope * keep;
  double p00 = e.gain_gain + 2.0 * reach * e.gain_slope + reach * reach * e.slope_slope;
  double p01 = keep * (e.gain_slope + reach * e.slope_slope);
  double p11 = keep * keep * e.slope_slope;
  const double spread = options.slope_spread * std::max(e.gain, kLeastGain);
  const double fresh = spread * spread * (1.0 - keep * keep);
  p11 += fresh;
  p01 += fresh * dx / 2.0;
  p00 += fresh * dx * dx / 3.0;

  const double innovation = force - v * gain;
  double variance = v * v * p00 + e.noise;
  e.likelihood =
      kForgetting * e.likelihood - 0.5 * (innovation * innovation / variance + std::log(variance));
  if (innovation * innovation > options.jump_test * variance) {
    // The slope may have begun anywhere within the period: 0.7 of it, more than half to be safe.
    const double jump = options.jump_spread * std::max({e.gain, gain, kLeastGain});
    p11 += jump * jump;
    p01 += 0.7 * jump * jump * dx;
    p00 += 0.7 * jump * jump * dx * dx;
    variance = v * v * p00 + e.noise;
  } else if (feed > 1e-3 && force > 1.0) {
    const double seen = std::clamp(innovation * innovation - v * v * p00, 0.0, 4.0 * variance);
    e.noise = std::clamp(e.noise + kNoiseLearning * (seen - e.noise), kLeastNoise, kMostNoise);
  }
  const double k0 = v * p00 / variance;
  const double k1 = v * p01 / variance;
  e.gain = at_least_zero(gain + k0 * innovation);
  e.slope = slope + k1 * innovation;
  e.slope_slope = at_least_zero(p11 - k1 * v * p01);
  e.gain_slope = p01 - k0 * v * p01;
  e.gain_gain = at_least_zero(p00 - k0 * v * p00);
}

}  // namespace osteomill::identify
