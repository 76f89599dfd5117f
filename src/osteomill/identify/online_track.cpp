// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/online_track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

void check_periods(const std::vector<OnlinePeriod>& periods) {
  if (periods.empty()) {
    throw InvalidInput(Fault{"replay", "no periods", "must hold one sample at least", ""});
  }
  for (std::size_t i = 1; i < periods.size(); ++i) {
    if (!(periods[i].time > periods[i - 1].time)) {
      throw InvalidInput(
          Fault{"replay", fmt::format("{} s behind {} s", periods[i].time, periods[i - 1].time),
                "must have times that grow", ""});
    }
  }
}

/// The controller's filter, said as the others say it.
OnlineEstimate gain_estimate(GainEstimate& gain, const OnlinePeriod& period, double dt,
                             double unit) {
  update(gain, period.feed, period.measured, dt, {});
  const double strength = period.feed / unit;  // of a gain of 1
  return {.time = period.time,
          .strength = gain.gain * strength,
          .standard_error = std::sqrt(gain.gain_gain) * strength,
          .informed = true};
}

double quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1) + 0.5)];
}

}  // namespace

OnlineTrack follow(const std::vector<OnlinePeriod>& periods, const FeedResponse& response,
                   const TrackOptions& options) {
  check(options.online);
  check_periods(periods);
  const bool power = options.measure == OnlineMeasure::power;
  if (power) check(options.power);
  if (power && options.method == OnlineMethod::gain_slope) {
    throw InvalidInput(Fault{"online.method", "gain-slope", "needs forces", "choose kalman"});
  }
  KalmanState kalman = power ? first_state(options.power.idle, options.power.idle_deviation)
                             : first_state(options.offset, options.offset_deviation);
  LeastSquaresState squares;
  GainEstimate gain;
  OnlineTrack track;
  std::vector<double> strengths;
  OnlineEstimate last;
  for (std::size_t i = 0; i < periods.size(); ++i) {
    const OnlinePeriod& period = periods[i];
    const FeedResponse::Answer answer = response.at(period.feed);
    const double whole = power ? answer.power / options.power.efficiency : answer.force;
    // What is known without bone is learned by the Kalman filter alone.
    const double offset = options.method == OnlineMethod::kalman ? kalman.offset
                          : power                                ? options.power.idle
                                                                 : options.offset;
    const bool in_bone = whole > 0.0 && period.measured - offset > options.contact;
    const double unit = in_bone ? whole : 0.0;
    if (options.method == OnlineMethod::kalman) {
      kalman = update(kalman, {period.time, period.measured, unit}, options.online);
      last = kalman.last;
    } else if (options.method == OnlineMethod::least_squares) {
      squares = update(squares, {period.time, period.measured - offset, unit}, options.online);
      last = squares.last;
    } else if (in_bone) {
      const double dt = i > 0 ? period.time - periods[i - 1].time
                              : (periods.size() > 1 ? periods[1].time - periods[0].time : 0.01);
      last = gain_estimate(gain, period, dt, unit);
    }
    last.time = period.time;
    track.estimates.push_back(last);
    track.unit.push_back(whole);
    track.in_bone.push_back(in_bone);
    track.jumps += last.jumped && in_bone;
    if (in_bone) strengths.push_back(last.strength);
  }
  track.periods_in_bone = static_cast<int>(strengths.size());
  if (!strengths.empty()) {
    std::sort(strengths.begin(), strengths.end());
    track.median = quantile(strengths, 0.5);
    track.low = quantile(strengths, 0.05);
    track.high = quantile(strengths, 0.95);
  }
  return track;
}

}  // namespace osteomill::identify
