// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/model_predictive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::control {
namespace {

constexpr int kParts = 5;               // of a period: 2 ms, a fifth of the servo's rise
constexpr int kLongestBraking = 40;     // periods; a servo of 20 rad/s has come to rest
constexpr int kSpeeds = 16;             // of the spindle that are compared
constexpr int kLooks = 12;              // ahead, for each of them
constexpr double kShortestLook = 1e-3;  // m
constexpr double kAim = 0.9;            // of the rise of temperature that is allowed
constexpr double kFlat = 0.05;          // exponent below which the feed does not change the rise
constexpr double kLastReserve = 0.97;   // of the force where the temperature asks for feed
constexpr double kLeastRise = 5.0;      // K; below it the ratio of two rises says little
constexpr double kWarmedOn = 1e-3;      // m of way before a place on which it is warmed
constexpr double kTrace = 1e-3;         // K, a rise that is none
constexpr double kWarming = 0.01;       // of the rise over the map's a period: 1 s at 10 ms
constexpr double kWorth = 1.01;         // times the feed, to turn the spindle faster
constexpr int kHalvings = 12;           // of the range of commands: to 3 um/s of 12 mm/s
constexpr double kSure = 1.25;          // largest over least: one place as good as the other

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
  if (!(options.limits.temperature > options.limits.body_temperature)) {
    throw InvalidInput(Fault{"limits.temperature_c",
                             std::to_string(options.limits.temperature) + " K",
                             "must be above the temperature of the bone", ""});
  }
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
    require_positive("chatter.depth_mm", chatter.depth / units::mm, "mm");
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
  if (count == 0) throw InvalidInput(Fault{"map", "no places", "must have one at least", ""});
  const Forecast::Heat& heat = forecast.heat;
  const std::array<const std::vector<double>*, 6> all = {&forecast.edges,      &forecast.peak_gains,
                                                         &forecast.peak_edges, &heat.slow,
                                                         &heat.fast,           &heat.spun};
  for (const std::vector<double>* values : all) {
    const bool heat_of = values == &heat.slow || values == &heat.fast || values == &heat.spun;
    if (values->size() != forecast.gains.size() && !(heat_of && values->empty())) {
      throw InvalidInput(Fault{"map", fmt::format("{} values for {} places", values->size(), count),
                               "must have one for each place", ""});
    }
  }
  if (std::isfinite(options.limits.temperature) && heat.fast.empty()) {
    throw InvalidInput(Fault{"limits.temperature_c", "a map without temperatures",
                             "needs the rise of temperature along the path", ""});
  }
  heat_feed_ = heat.fast.empty() ? 0.0 : heat.fast_feed;
  // The offset is none: the sensor was zeroed in air. Strength is that of the map.
  tracking_.offset_wander = 0.0;
  tracking_.wander = 0.0;  // see learn()
  tracking_.noise = 1.0;
  tracking_.least_unit = 1.0;
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(options.map.position_error / spacing_));
  const auto on_the_way = static_cast<std::ptrdiff_t>(std::ceil(kWarmedOn / spacing_));
  std::vector<Place> places(static_cast<std::size_t>(count));
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, i - reach);
    const std::ptrdiff_t last = std::min(count - 1, i + reach) + 1;
    const auto largest = [&](const std::vector<double>& values) {
      return *std::max_element(values.begin() + first, values.begin() + last);
    };
    const auto least = [&](const std::vector<double>& values) {
      return *std::min_element(values.begin() + first, values.begin() + last);
    };
    Place& place = places[static_cast<std::size_t>(i)];
    place.largest_gain = largest(forecast.gains);
    place.largest_edge = largest(forecast.edges);
    place.least_gain = least(forecast.gains);
    place.least_edge = least(forecast.edges);
    place.peak_gain = largest(forecast.peak_gains);
    place.peak_edge = largest(forecast.peak_edges);
    const std::ptrdiff_t warmed = std::min(count, last + on_the_way);
    const auto hottest = [&](const std::vector<double>& rises) {
      return *std::max_element(rises.begin() + first, rises.begin() + warmed);
    };
    if (!heat.fast.empty()) place.rise = hottest(heat.fast);
    if (!(place.rise > 0.0)) continue;
    place.slowness = std::log(std::max(hottest(heat.slow), kTrace) / place.rise) /
                     std::log(heat.fast_feed / heat.slow_feed);
    if (heat.spun.empty()) continue;
    place.haste = std::log(std::max(hottest(heat.spun), kTrace) / place.rise) /
                  std::log(heat.spun_speed / options.spindle_speed);
  }
  places_ = std::make_shared<const std::vector<Place>>(std::move(places));
  const auto hardest = std::max_element(forecast.gains.begin(), forecast.gains.end());
  double stable = stable_gain(options.spindle_speed);
  if (options.spindle) {
    const SpindleHandle& handle = *options.spindle;
    for (int i = 0; i < kSpeeds; ++i) {
      stable = std::max(stable, stable_gain(handle.lowest +
                                            (handle.highest - handle.lowest) * i / (kSpeeds - 1)));
    }
  }
  if (*hardest > stable) {
    throw InvalidInput(Fault{
        "chatter.margin", fmt::format("{:g}", options.chatter.margin),
        fmt::format(
            "does not hold at {} {:.1f} mm along the path, where the map has {:.4g} N/(mm/s) and "
            "{:.4g} are stable; no feed changes that",
            options.spindle ? "any spindle speed" : "the programmed spindle speed",
            static_cast<double>(hardest - forecast.gains.begin()) * spacing_ / units::mm,
            *hardest / 1e3, stable / 1e3),
        options.spindle ? "take a smaller depth of cut"
                        : "choose another speed, or let the law choose it: machine.spindle"});
  }
}

const ModelPredictive::Place& ModelPredictive::at(double position) const noexcept {
  const double last = static_cast<double>(places_->size() - 1);
  const double place = std::clamp(position / spacing_, 0.0, last);
  return (*places_)[static_cast<std::size_t>(std::lround(place))];
}

double ModelPredictive::rise_allowed() const noexcept {
  return kAim * (options_.limits.temperature - options_.limits.body_temperature);
}

double ModelPredictive::rise(const ModelPredictiveState& state, const Place& place,
                             double feed) const noexcept {
  if (!(place.rise > 0.0)) return 0.0;
  const double speed = state.spindle_speed > 0.0 && options_.spindle_speed > 0.0
                           ? state.spindle_speed / options_.spindle_speed
                           : 1.0;
  return state.warmth * place.rise * std::pow(speed, place.haste) *
         std::pow(std::max(feed, options_.floor_feed) / heat_feed_, -place.slowness);
}

double ModelPredictive::temperature(const ModelPredictiveState& state, double position,
                                    double feed) const noexcept {
  if (heat_feed_ == 0.0) return 0.0;
  return options_.limits.body_temperature + rise(state, at(position), feed);
}

/// The feed at which the rise is the allowed one: the least where slowness is positive, the largest
/// where it is negative.
double ModelPredictive::feed_of_rise(const ModelPredictiveState& state,
                                     const Place& place) const noexcept {
  return heat_feed_ *
         std::pow(rise(state, place, heat_feed_) / rise_allowed(), 1.0 / place.slowness);
}

double ModelPredictive::feed_of_force(const Place& place, double strength, double chip,
                                      double force) const noexcept {
  if (!(place.peak_gain > 0.0)) return std::numeric_limits<double>::infinity();
  // gain v (1 + rise v t) + edge = force / strength, for v.
  const double room = std::max(force / std::max(strength, 0.1) - place.peak_edge, 0.0);
  const double square = options_.unforeseen_rise * options_.reaction_time;
  const double linear = chip * room / place.peak_gain;
  return 2.0 * linear / (1.0 + std::sqrt(1.0 + 4.0 * square * linear));
}

ModelPredictive::Allowed ModelPredictive::allowed(const ModelPredictiveState& state,
                                                  double position, double ahead) const noexcept {
  const Place& place = at(position);
  const PlanLimits& limits = options_.limits;
  double chip = 1.0;  // of the map's over that of now, at one feed
  Allowed most;
  if (options_.spindle_speed > 0.0) {
    chip = state.spindle_speed / options_.spindle_speed;
    const double teeth =
        options_.flutes * state.spindle_speed / (2.0 * std::numbers::pi);  // a second
    most = {limits.feed_per_tooth * teeth, Bound::feed_per_tooth};
  }
  const double keep = std::exp(-ahead / options_.map.correlation);
  const double own = options_.map.gain_error;
  const double known = state.strength.last.standard_error;
  const double deviation = std::sqrt(keep * keep * known * known + (1.0 - keep * keep) * own * own);
  const double expected = 1.0 + keep * (state.strength.last.strength - 1.0);
  const double force = std::min(limits.force, limits.force_of_deflection);
  Allowed by_force{feed_of_force(place, expected + options_.confidence * deviation, chip,
                                 options_.margin * force),
                   limits.force_of_deflection < limits.force ? Bound::deflection : Bound::force};
  if (std::isfinite(limits.temperature) && rise(state, place, by_force.feed) > rise_allowed() &&
      std::abs(place.slowness) > kFlat) {
    double feed = feed_of_rise(state, place);
    if (place.slowness > 0.0) {
      const double most_of_force = feed_of_force(place, expected, chip, kLastReserve * force);
      feed = std::max(std::min(feed, most_of_force), by_force.feed);
    }
    by_force = {feed, Bound::temperature};
  }
  return by_force.feed < most.feed ? by_force : most;
}

bool ModelPredictive::keeps(const ModelPredictiveState& state, double command, double position,
                            double ceiling, Bound& bound) const noexcept {
  numerics::LagState servo{0.0, state.servo.value, state.servo.rate};
  double now = command;
  for (int period = 0; period < kLongestBraking; ++period) {
    for (int part = 0; part < kParts; ++part) {
      servo = part_.advance(servo, now);
      const Allowed limit = allowed(state, position + servo.integral, servo.integral);
      if (servo.value > std::max(std::min(limit.feed, ceiling), options_.floor_feed)) {
        bound = limit.feed < ceiling ? limit.bound : Bound::largest_feed;
        return false;
      }
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
  const double foreseen = rise(before, at(seen.position), feed);
  if (foreseen > kLeastRise && seen.temperature > 0.0) {
    // `foreseen` has the warmth of before in it.
    const double ratio =
        before.warmth * (seen.temperature - options_.limits.body_temperature) / foreseen;
    now.warmth += kWarming * (std::clamp(ratio, 1.0, 2.0) - before.warmth);
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

ModelPredictive::Speed ModelPredictive::speed(const ModelPredictiveState& state,
                                              const Observation& seen,
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
  Speed chosen{handle.lowest, Bound::none};
  double best = -1.0, most_stable = -1.0;
  double least_rise = std::numeric_limits<double>::infinity();
  Speed free = chosen;  // with the largest feed, whether it chatters or heats or not
  double free_feed = -1.0;
  for (int i = 0; i < kSpeeds; ++i) {
    trial.spindle_speed = handle.lowest + (handle.highest - handle.lowest) * i / (kSpeeds - 1);
    const double stable = stable_gain(trial.spindle_speed);
    double feed = ceiling, hottest = 0.0;
    for (int look = 0; look <= kLooks; ++look) {
      const double ahead = reach * look / kLooks;
      const double there = std::min(ceiling, allowed(trial, seen.position + ahead, ahead).feed);
      feed = std::min(feed, there);
      hottest = std::max(hottest, rise(trial, at(seen.position + ahead), there));
    }
    const bool chatters = hardest > stable;
    const bool heats = hottest > rise_allowed();
    if (feed > kWorth * free_feed) {
      free_feed = feed;
      free.bound = chatters ? Bound::chatter : heats ? Bound::temperature : Bound::none;
    }
    if (chatters) {
      // The most stable of them, as long as none is stable.
      if (best < 0.0 && !std::isfinite(least_rise) && stable > most_stable) {
        most_stable = stable;
        chosen.value = trial.spindle_speed;
      }
    } else if (heats) {
      // The coolest of them, as long as none is cool enough.
      if (best < 0.0 && hottest < least_rise) {
        least_rise = hottest;
        chosen.value = trial.spindle_speed;
      }
    } else if (feed > kWorth * best) {
      // A faster spindle has to be worth it: rubbing and heat go with the speed.
      best = feed;
      chosen.value = trial.spindle_speed;
    }
  }
  if (free_feed > kWorth * best) chosen.bound = free.bound;
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
  Step next;
  next.state = state;
  learn(next.state, state, seen);
  Bound of_speed = Bound::none;
  if (options_.spindle) {
    const Speed wanted = speed(next.state, seen, ceiling);
    next.spindle_speed = wanted.value;
    of_speed = wanted.bound;
    // A drive that slows down makes the chips thicker before the next look.
    next.state.spindle_speed = std::min(next.state.spindle_speed, next.spindle_speed);
  }
  next.state.servo.value = seen.feed;
  const Allowed here = allowed(next.state, seen.position, 0.0);
  next.wanted = std::min(here.feed, ceiling);
  const double floor = std::min(options_.floor_feed, ceiling);
  double low = floor;
  double high = ceiling;
  Bound ahead = Bound::none;
  if (keeps(next.state, high, seen.position, ceiling, ahead)) {
    low = high;
  } else {
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (keeps(next.state, middle, seen.position, ceiling, ahead) ? low : high) = middle;
    }
  }
  const double lead_feed = lead(next.state.servo, next.wanted);
  next.command = std::clamp(lead_feed, floor, low);
  if (lead_feed > low) {
    next.bound = low < ceiling ? ahead : Bound::largest_feed;
  } else {
    next.bound = here.feed < ceiling ? here.bound : Bound::largest_feed;
  }
  // At another speed of the spindle the same limits would have let it go faster.
  if (of_speed != Bound::none && next.bound != Bound::largest_feed) next.bound = of_speed;
  return next;
}

}  // namespace osteomill::control
