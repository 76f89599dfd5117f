// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/model_adaptive.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::control {
namespace {

constexpr double kRatioLearning = 0.02;  // of peak over mean a period
constexpr double kForceInBone = 3.0;     // N; below it the ratio of peak and mean is noise

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
    : options_((check(options), options)),
      gain_options_{options.slope_length, options.slope_spread, options.jump_spread,
                    options.jump_test},
      lag_(options.servo, options.period) {}

double ModelAdaptive::allowed_feed(const identify::GainEstimate& e, int delay,
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
    identify::update(now.estimates[delay], now.feeds[delay], seen.mean_force, options_.period,
                     gain_options_);
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
