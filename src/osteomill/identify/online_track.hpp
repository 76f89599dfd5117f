// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/identify/feed_response.hpp"
#include "osteomill/identify/local_gain.hpp"
#include "osteomill/identify/online.hpp"

namespace osteomill::identify {

enum class OnlineMethod {
  kalman,         ///< extended Kalman filter, see KalmanState
  least_squares,  ///< recursive, with forgetting, see LeastSquaresState
  gain_slope,     ///< the filter of the model-adaptive controller, see GainEstimate; forces only
};
enum class OnlineMeasure { force, power };

/// One period of a recording.
struct OnlinePeriod {
  double time = 0.0;      ///< at its end, s
  double feed = 0.0;      ///< mean, m/s
  double measured = 0.0;  ///< mean force, N, or electric power, W
};

struct TrackOptions {
  OnlineMethod method = OnlineMethod::kalman;
  OnlineMeasure measure = OnlineMeasure::force;
  OnlineOptions online;
  PowerModel power;
  /// Less than this over the offset is taken for air, N or W.
  double contact = 2.0;
  double offset = 0.0;            ///< of the force sensor, N
  double offset_deviation = 0.0;  ///< N
};

struct OnlineTrack {
  std::vector<OnlineEstimate> estimates;  ///< one a period
  std::vector<double> unit;               ///< answer of strength 1, N or W
  std::vector<bool> in_bone;
  int jumps = 0;
  int periods_in_bone = 0;
  /// Of the strengths in bone; zero without any.
  double median = 0.0;
  double low = 0.0;   ///< 5 % of them are below
  double high = 0.0;  ///< 5 % are above
};

/// Runs an estimator over a recording as a controller would have, sample by sample.
/// Throws InvalidInput for options that make no estimator, and for times that do not grow.
OnlineTrack follow(const std::vector<OnlinePeriod>& periods, const FeedResponse& response,
                   const TrackOptions& options);

}  // namespace osteomill::identify
