// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/model_predictive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::control {
namespace {

constexpr double kRatioLearning = 0.02;  // of peak over mean a period
constexpr double kForceInBone = 3.0;     // N; below it the ratio of peak and mean is noise
constexpr int kParts = 5;                // of a period: 2 ms, a fifth of the servo's rise
constexpr int kLongestBraking = 40;      // periods; a servo of 20 rad/s has come to rest
constexpr int kSpeeds = 16;              // of the spindle that are compared
constexpr int kLooks = 12;               // ahead, for each of them
constexpr double kShortestLook = 1e-3;   // m
constexpr double kCooling = 1.0;         // s, time constant of the temperature's hold on the speed
constexpr double kAim = 0.9;             // of the rise of temperature that is allowed
constexpr int kHalvings = 12;            // of the range of commands: to 3 um/s of 12 mm/s
constexpr double kSure = 1.25;           // largest over least: one place as good as the other

}  // namespace

void check(const ModelPredictiveOptions& options) {
  require_positive("limits.force_n", options.limits.force, "N");
  if (!(options.limits.force_of_deflection > 0.0)) {
    throw InvalidInput(Fault{"limits.deflection_mm", "", "must be > 0", ""});
  }
  if (!(options.limits.feed_per_tooth > 0.0)) {
    throw InvalidInput(Fault{"limits.feed_per_tooth_mm", "", "must be > 0", ""});
  }
  require_non_negative("map.error_mm", options.map.position_error / units::mm, "mm");
  require_within("map.gain_error", options.map.gain_error, 0.0, 10.0, "");
  require_positive("map.correlation_mm", options.map.correlation / units::mm, "mm");
  require_within("controller.margin", options.margin, 0.05, 1.0, "");
  require_within("controller.confidence", options.confidence, 0.0, 10.0, "");
  require_positive("controller.floor_feed_mm_per_s", options.floor_feed / units::mm_per_s, "mm/s");
  numerics::check(options.servo, "controller.servo");
  require_positive("controller.period_ms", options.period / units::ms, "ms");
  require_positive("cutter.flutes", options.flutes, "");
  require_non_negative("cut.spindle_speed_rpm", options.spindle_speed / units::rpm, "rpm");
  require_non_negative("controller.unforeseen_rise_per_mm", options.unforeseen_rise * units::mm,
                       "1/mm");
  if (options.spindle) {
    const SpindleHandle& handle = *options.spindle;
    require_positive("machine.spindle.min_rpm", handle.lowest / units::rpm, "rpm");
    require_within("cut.spindle_speed_rpm", options.spindle_speed / units::rpm,
                   handle.lowest / units::rpm, handle.highest / units::rpm, "rpm");
    require_positive("machine.spindle.time_constant_s", handle.time_constant, "s");
    if (!(handle.temperature > handle.body_temperature)) {
      throw InvalidInput(Fault{"limits.temperature_c", std::to_string(handle.temperature) + " K",
                               "must be above the temperature of the bone", ""});
    }
  }
  const ChatterLimits& chatter = options.chatter;
  for (std::size_t i = 0; i < chatter.lobes.size(); ++i) {
    require_positive("chatter.stable_depths_mm", chatter.lobes[i].depth / units::mm, "mm");
    if (i > 0 && !(chatter.lobes[i].spindle_speed > chatter.lobes[i - 1].spindle_speed)) {
      throw InvalidInput(Fault{"chatter.spindle_speeds_rpm", "", "must rise", ""});
    }
  }
  if (!chatter.lobes.empty()) {
    require_positive("chatter.gain_n_per_mm_per_s", chatter.gain / 1e3, "N/(mm/s)");
    require_positive("path.axial_depth_mm", chatter.depth / units::mm, "mm");
    require_positive("chatter.margin", chatter.margin, "");
  }
  require_non_negative("controller.reaction_time_ms", options.reaction_time / units::ms, "ms");
}

ModelPredictive::ModelPredictive(const ModelPredictiveOptions& options, Forecast forecast)
    : options_((check(options), options)),
      spacing_(require_positive("map.spacing_mm", forecast.spacing / units::mm, "mm") * units::mm),
      lag_(options.servo, options.period),
      two_(options.servo, 2.0 * options.period),
      part_(options.servo, options.period / kParts) {
  const auto count = static_cast<std::ptrdiff_t>(forecast.gains.size());
  if (count == 0 || forecast.edges.size() != forecast.gains.size()) {
    throw InvalidInput(Fault{"map", std::to_string(count) + " places",
                             "must have as many gains as edge forces, one at least", ""});
  }
  // The offset is none: the sensor was zeroed in air. Strength is that of the map.
  tracking_.offset_wander = 0.0;
  tracking_.wander = 0.0;  // see learn()
  tracking_.noise = 1.0;
  tracking_.least_unit = 1.0;
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(options.map.position_error / spacing_));
  std::vector<Place> places(static_cast<std::size_t>(count));
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, i - reach);
    const std::ptrdiff_t last = std::min(count - 1, i + reach);
    const auto [least_gain, largest_gain] =
        std::minmax_element(forecast.gains.begin() + first, forecast.gains.begin() + last + 1);
    const auto [least_edge, largest_edge] =
        std::minmax_element(forecast.edges.begin() + first, forecast.edges.begin() + last + 1);
    places[static_cast<std::size_t>(i)] = {*largest_gain, *largest_edge, *least_gain, *least_edge};
  }
  places_ = std::make_shared<const std::vector<Place>>(std::move(places));
  const double hardest = *std::max_element(forecast.gains.begin(), forecast.gains.end());
  if (!options.spindle && hardest > stable_gain(options.spindle_speed)) {
    throw InvalidInput(Fault{"chatter.margin", std::to_string(options.chatter.margin),
                             "does not hold at the programmed spindle speed in the hardest bone, "
                             "and no feed changes that",
                             "choose another speed, or let the law choose it: machine.spindle"});
  }
}

const ModelPredictive::Place& ModelPredictive::at(double position) const noexcept {
  const double last = static_cast<double>(places_->size() - 1);
  const double place = std::clamp(position / spacing_, 0.0, last);
  return (*places_)[static_cast<std::size_t>(std::lround(place))];
}

double ModelPredictive::allowed(const ModelPredictiveState& state, double position,
                                double ahead) const noexcept {
  const Place& place = at(position);
  const PlanLimits& limits = options_.limits;
  double most = std::numeric_limits<double>::infinity();
  double chip = 1.0;  // of the map's over that of now, at one feed
  if (options_.spindle_speed > 0.0) {
    const double teeth =
        options_.flutes * state.spindle_speed / (2.0 * std::numbers::pi);  // a second
    most = limits.feed_per_tooth * teeth;
    chip = state.spindle_speed / options_.spindle_speed;
  }
  const double keep = std::exp(-ahead / options_.map.correlation);
  const double own = options_.map.gain_error;
  const double known = state.strength.last.standard_error;
  const double deviation = std::sqrt(keep * keep * known * known + (1.0 - keep * keep) * own * own);
  const double strength =
      1.0 + keep * (state.strength.last.strength - 1.0) + options_.confidence * deviation;
  const double peak = options_.margin * std::min(limits.force, limits.force_of_deflection);
  const double mean = peak / std::max(state.peak_to_mean, 1.2) / std::max(strength, 0.1);
  // gain v (1 + rise v t) + edge = mean, for v.
  const double room = std::max(mean - place.largest_edge, 0.0);
  if (!(place.largest_gain > 0.0)) return most;
  const double square = options_.unforeseen_rise * options_.reaction_time;
  const double linear = chip * room / place.largest_gain;
  const double feed = 2.0 * linear / (1.0 + std::sqrt(1.0 + 4.0 * square * linear));
  return std::min(most, feed);
}

bool ModelPredictive::keeps(const ModelPredictiveState& state, double command, double position,
                            double ceiling) const noexcept {
  numerics::LagState servo{0.0, state.servo.value, state.servo.rate};
  double now = command;
  for (int period = 0; period < kLongestBraking; ++period) {
    for (int part = 0; part < kParts; ++part) {
      servo = part_.advance(servo, now);
      const double limit = allowed(state, position + servo.integral, servo.integral);
      if (servo.value > std::max(std::min(limit, ceiling), options_.floor_feed)) return false;
    }
    now = options_.floor_feed;
    if (period > 0 && servo.value <= 1.02 * options_.floor_feed && servo.rate <= 0.0) break;
  }
  return true;
}

void ModelPredictive::learn(ModelPredictiveState& now, const ModelPredictiveState& before,
                            const Observation& seen) const noexcept {
  // What the map has for the period that is over, anywhere on the stretch that was travelled.
  const double from = before.begun ? std::min(before.position, seen.position) : seen.position;
  const double feed = before.begun ? (seen.position - from) / options_.period : seen.feed;
  now.spindle_speed = seen.spindle_speed > 0.0 ? seen.spindle_speed : options_.spindle_speed;
  // At the programmed speed this feed would have cut the same chip.
  const double cut =
      now.spindle_speed > 0.0 ? feed * options_.spindle_speed / now.spindle_speed : feed;
  const Place& first = at(from);
  const Place& last = at(seen.position);
  const double least =
      std::min(first.least_edge + first.least_gain * cut, last.least_edge + last.least_gain * cut);
  const double largest = std::max(first.largest_edge + first.largest_gain * cut,
                                  last.largest_edge + last.largest_gain * cut);
  std::copy_backward(before.least.begin(), before.least.end() - 1, now.least.end());
  std::copy_backward(before.largest.begin(), before.largest.end() - 1, now.largest.end());
  now.least[0] = least;
  now.largest[0] = largest;
  now.position = seen.position;
  now.begun = true;
  if (seen.mean_force > kForceInBone) {
    const double ratio = std::clamp(seen.peak_force / seen.mean_force, 1.0, 2.2);
    now.peak_to_mean += kRatioLearning * (ratio - now.peak_to_mean);
  }
  // The map's error is a Gauss-Markov process along the path: so far the strength is forgotten.
  identify::KalmanState known = before.strength;
  const double own = options_.map.gain_error * options_.map.gain_error;
  const double keep = std::exp(-(seen.position - from) / options_.map.correlation);
  known.q *= keep;
  known.var_q = before.begun ? keep * keep * known.var_q + (1.0 - keep * keep) * own : own;
  known.last.strength = std::exp(known.q);
  known.last.standard_error = known.last.strength * std::sqrt(known.var_q);
  // What some place within the position error explains says nothing of the strength.
  const double low = *std::min_element(now.least.begin(), now.least.end());
  const double high = *std::max_element(now.largest.begin(), now.largest.end());
  const double alike = seen.mean_force / known.last.strength;
  double unit = alike < low ? low : alike > high ? high : 0.0;
  if (high <= kSure * low) unit = 0.5 * (low + high);
  now.strength = identify::update(known, {seen.time, seen.mean_force, unit}, tracking_);
}

double ModelPredictive::stable_gain(double spindle_speed) const noexcept {
  const ChatterLimits& chatter = options_.chatter;
  if (chatter.lobes.empty()) return std::numeric_limits<double>::infinity();
  double depth = chatter.lobes.front().depth;
  for (std::size_t i = 1; i < chatter.lobes.size(); ++i) {
    const StableDepth& low = chatter.lobes[i - 1];
    const StableDepth& high = chatter.lobes[i];
    if (spindle_speed < low.spindle_speed) break;
    const double part = std::min(
        (spindle_speed - low.spindle_speed) / (high.spindle_speed - low.spindle_speed), 1.0);
    depth = low.depth + part * (high.depth - low.depth);
  }
  return chatter.gain * depth / (chatter.margin * chatter.depth);
}

double ModelPredictive::speed(const ModelPredictiveState& state, const Observation& seen,
                              double ceiling) const noexcept {
  const SpindleHandle& handle = *options_.spindle;
  // As far as the tool may come while the drive answers; its limits there at each speed.
  const double reach = std::max(kShortestLook, 3.0 * handle.time_constant * seen.feed);
  double hardest = 0.0;
  for (int look = 0; look <= kLooks; ++look) {
    hardest = std::max(hardest, at(seen.position + reach * look / kLooks).largest_gain);
  }
  hardest *= std::max(state.strength.last.strength, 1.0);
  ModelPredictiveState trial = state;
  double chosen = handle.lowest;
  double best = -1.0;
  for (int i = 0; i < kSpeeds; ++i) {
    trial.spindle_speed = handle.lowest + (handle.highest - handle.lowest) * i / (kSpeeds - 1);
    if (i > 0 && trial.spindle_speed > state.spindle_cap) break;
    if (hardest > stable_gain(trial.spindle_speed)) continue;
    double feed = ceiling;
    for (int look = 0; look <= kLooks; ++look) {
      const double ahead = reach * look / kLooks;
      feed = std::min(feed, allowed(trial, seen.position + ahead, ahead));
    }
    // A faster spindle has to be worth it: rubbing and heat go with the speed.
    if (feed <= 1.01 * best) continue;
    best = feed;
    chosen = trial.spindle_speed;
  }
  return chosen;
}

/// The command that, held for two periods, brings the servo there at their end. One period is too
/// short a time to ask for: what it takes to arrive leaves the servo with a rate that the next
/// command has to take back, and the feed rings.
double ModelPredictive::lead(const numerics::LagState& servo, double wanted) const noexcept {
  const double free = two_.transition()(1, 1) * servo.value + two_.transition()(1, 2) * servo.rate;
  return (wanted - free) / two_.input()[1];
}

ModelPredictive::Step ModelPredictive::step(const ModelPredictiveState& state,
                                            const Observation& seen,
                                            double ceiling) const noexcept {
  Step next{state, 0.0, 0.0, 0.0};
  learn(next.state, state, seen);
  if (options_.spindle) {
    const SpindleHandle& handle = *options_.spindle;
    double& cap = next.state.spindle_cap;
    if (!state.begun) cap = handle.highest;
    if (seen.temperature > 0.0 && std::isfinite(handle.temperature)) {
      const double rise = kAim * (handle.temperature - handle.body_temperature);
      const double left = (handle.body_temperature + rise - seen.temperature) / rise;
      cap *= std::exp(std::clamp(left, -1.0, 1.0) * options_.period / kCooling);
    }
    cap = std::clamp(cap, handle.lowest, handle.highest);
    next.spindle_speed = speed(next.state, seen, ceiling);
    // A drive that slows down makes the chips thicker before the next look.
    next.state.spindle_speed = std::min(next.state.spindle_speed, next.spindle_speed);
  }
  next.state.servo.value = seen.feed;
  next.wanted = std::min(allowed(next.state, seen.position, 0.0), ceiling);
  const double floor = std::min(options_.floor_feed, ceiling);
  double low = floor;
  double high = ceiling;
  if (keeps(next.state, high, seen.position, ceiling)) {
    low = high;
  } else {
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (keeps(next.state, middle, seen.position, ceiling) ? low : high) = middle;
    }
  }
  next.command = std::clamp(lead(next.state.servo, next.wanted), floor, low);
  return next;
}

}  // namespace osteomill::control
