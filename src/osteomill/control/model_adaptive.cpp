// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/model_adaptive.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::control {
namespace {

constexpr double kLeastFeed = 1e-4;   // m/s; slower feeds say nothing of the gain
constexpr double kLeastGain = 300.0;  // N/(m/s); spreads are relative to the gain, but not to air
constexpr double kForgetting = 0.98;  // of the likelihoods a period: half a second of memory
constexpr double kNoiseLearning = 0.01;  // a period: one second
constexpr double kRatioLearning = 0.02;  // of peak over mean a period
constexpr double kForceInBone = 3.0;     // N; below it the ratio of peak and mean is noise
constexpr double kLeastNoise = 0.02;     // N²
constexpr double kMostNoise = 9.0;       // N²

double at_least_zero(double value) { return std::max(value, 0.0); }

}  // namespace

void check(const ModelAdaptiveOptions& options) {
  require_positive("limits.force_n", options.force_limit, "N");
  require_within("controller.margin", options.margin, 0.05, 1.0, "");
  require_within("controller.confidence", options.confidence, 0.0, 10.0, "");
  require_positive("controller.floor_feed_mm_per_s", options.floor_feed / units::mm_per_s, "mm/s");
  numerics::check(options.servo, "controller.servo");
  require_positive("controller.period_ms", options.period / units::ms, "ms");
  require_non_negative("controller.hardest_rise_per_mm", options.hardest_rise * units::mm, "1/mm");
  require_non_negative("controller.reaction_time_ms", options.reaction_time / units::ms, "ms");
  require_positive("controller.slope_length_mm", options.slope_length / units::mm, "mm");
  require_positive("controller.slope_spread_per_mm", options.slope_spread * units::mm, "1/mm");
  require_positive("controller.jump_spread_per_mm", options.jump_spread * units::mm, "1/mm");
  require_positive("controller.jump_test", options.jump_test, "");
  require_non_negative("controller.settle_mm", options.settle / units::mm, "mm");
}

ModelAdaptive::ModelAdaptive(const ModelAdaptiveOptions& options)
    : options_((check(options), options)), lag_(options.servo, options.period) {}

void ModelAdaptive::update(GainEstimate& e, double feed, double force) const noexcept {
  const double v = std::max(feed, kLeastFeed);
  const double dx = v * options_.period;
  // The slope decays over slope_length, the gain takes its integral.
  const double keep = std::exp(-dx / options_.slope_length);
  const double reach = options_.slope_length * (1.0 - keep);
  double gain = e.gain + e.slope * reach;
  double slope = e.slope * keep;
  double p00 = e.gain_gain + 2.0 * reach * e.gain_slope + reach * reach * e.slope_slope;
  double p01 = keep * (e.gain_slope + reach * e.slope_slope);
  double p11 = keep * keep * e.slope_slope;
  const double spread = options_.slope_spread * std::max(e.gain, kLeastGain);
  const double fresh = spread * spread * (1.0 - keep * keep);
  p11 += fresh;
  p01 += fresh * dx / 2.0;
  p00 += fresh * dx * dx / 3.0;

  const double innovation = force - v * gain;
  double variance = v * v * p00 + e.noise;
  e.likelihood =
      kForgetting * e.likelihood - 0.5 * (innovation * innovation / variance + std::log(variance));
  if (innovation * innovation > options_.jump_test * variance) {
    // The slope may have begun anywhere within the period: 0.7 of it, more than half to be safe.
    const double jump = options_.jump_spread * std::max({e.gain, gain, kLeastGain});
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

double ModelAdaptive::allowed_feed(const GainEstimate& e, int delay,
                                   const ModelAdaptiveState& state, double ceiling) const noexcept {
  // From the middle of the period that the force is of, to now.
  double behind = 0.5 * options_.period * state.feeds[delay];
  for (int i = 0; i < delay; ++i) behind += options_.period * state.feeds[i];
  const double limit = options_.margin * options_.force_limit / std::max(state.peak_to_mean, 1.2);
  const double lag = 2.0 * options_.servo.damping_ratio / options_.servo.natural_frequency;
  const double reaction = options_.reaction_time + delay * options_.period;
  const auto holds = [&](double v) {
    const double ahead = behind + v * (lag + 0.5 * options_.period);
    const double reach = options_.slope_length * (1.0 - std::exp(-ahead / options_.slope_length));
    // A fall of the gain is believed by half only, and never below a third.
    const double change = e.slope > 0.0 ? e.slope * reach : 0.5 * e.slope * reach;
    const double variance =
        e.gain_gain + 2.0 * reach * e.gain_slope + reach * reach * e.slope_slope;
    const double gain = std::max(e.gain + change, 0.3 * e.gain) +
                        options_.confidence * std::sqrt(at_least_zero(variance));
    return gain * v * (1.0 + options_.hardest_rise * v * reaction) <= limit;
  };
  double low = std::min(options_.floor_feed, ceiling);
  if (holds(ceiling)) return ceiling;
  double high = ceiling;
  for (int i = 0; i < 30; ++i) {  // to a billionth of the ceiling
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

ModelAdaptive::Step ModelAdaptive::step(const ModelAdaptiveState& state, const Observation& seen,
                                        double ceiling) const noexcept {
  Step next{state, 0.0, 0.0};
  ModelAdaptiveState& now = next.state;
  std::copy_backward(state.feeds.begin(), state.feeds.end() - 1, now.feeds.end());
  now.feeds[0] =
      state.begun ? at_least_zero(seen.position - state.position) / options_.period : seen.feed;
  now.position = seen.position;
  now.begun = true;
  if (seen.mean_force > kForceInBone) {
    const double ratio = std::clamp(seen.peak_force / seen.mean_force, 1.0, 2.2);
    now.peak_to_mean += kRatioLearning * (ratio - now.peak_to_mean);
  }
  int likeliest = 0;
  for (int delay = 0; delay < kDelays; ++delay) {
    update(now.estimates[delay], now.feeds[delay], seen.mean_force);
    if (now.estimates[delay].likelihood > now.estimates[likeliest].likelihood) likeliest = delay;
  }
  next.wanted = allowed_feed(now.estimates[likeliest], likeliest, now, ceiling);

  // Lead: the command that brings the servo there by the end of the period.
  now.servo.value = seen.feed;
  const double free =
      lag_.transition()(1, 1) * now.servo.value + lag_.transition()(1, 2) * now.servo.rate;
  next.command = (next.wanted - free) / lag_.input()[1];
  next.command = std::clamp(next.command, std::min(options_.floor_feed, ceiling), ceiling);
  return next;
}

}  // namespace osteomill::control
