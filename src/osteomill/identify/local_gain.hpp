// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace osteomill::identify {

/// How the gain of bone changes along the path.
struct LocalGainOptions {
  double slope_length = 1e-3;   ///< over which a slope of the gain persists, m
  double slope_spread = 450.0;  ///< of the relative slope of ordinary bone, 1/m
  double jump_spread = 2000.0;  ///< of the relative slope where a jump was seen, 1/m
  double jump_test = 5.0;       ///< squared innovation over its variance that is called a jump
};

/// Local force-feed gain K of F = K v and its slope along the path, with their covariance: a Kalman
/// filter whose slope is a Gauss-Markov process in distance. Innovations beyond `jump_test` open it
/// for a jump. What the model-adaptive controller looks ahead with.
struct GainEstimate {
  double gain = 0.0;       ///< N/(m/s)
  double slope = 0.0;      ///< N/(m/s)/m
  double gain_gain = 0.0;  ///< covariance
  double gain_slope = 0.0;
  double slope_slope = 0.0;
  double noise = 1.0;       ///< variance of a force, learned from the innovations, N²
  double likelihood = 0.0;  ///< forgetting sum of log likelihoods
};

/// One period, s, with its mean feed, m/s, and mean force, N.
void update(GainEstimate& estimate, double feed, double force, double period,
            const LocalGainOptions& options) noexcept;

}  // namespace osteomill::identify
