// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/online.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::identify {
namespace {

/// A strength beyond this either way is no bone: logarithms are held there.
constexpr double kMostLog = 6.9;  // a factor of 1000
constexpr int kMostIterations = 20;

double square(double value) { return value * value; }

/// Time since the last sample; none before the first.
double elapsed(const OnlineEstimate& last, const OnlineSample& sample) {
  return last.informed || last.time > 0.0 ? std::max(0.0, sample.time - last.time) : 0.0;
}

bool finite(const OnlineSample& sample) {
  return std::isfinite(sample.time) && std::isfinite(sample.measured) && std::isfinite(sample.unit);
}

}  // namespace

void check(const OnlineOptions& options) {
  require_non_negative("online.noise", options.noise, "");
  require_within("online.relative_noise", options.relative_noise, 0.0, 1.0, "");
  if (options.noise == 0.0 && options.relative_noise == 0.0) {
    throw InvalidInput(Fault{"online.noise", "0", "must not be 0 together with relative_noise",
                             "measure the noise of the sensor at rest"});
  }
  require_non_negative("online.wander", options.wander, "");
  require_non_negative("online.offset_wander", options.offset_wander, "");
  require_positive("online.jump_test", options.jump_test, "");
  require_within("online.jump", options.jump, 0.01, kMostLog, "");
  require_positive("online.memory_ms", options.memory / units::ms, "ms");
  require_non_negative("online.least_unit", options.least_unit, "");
}

void check(const PowerModel& model) {
  require_non_negative("power.idle_w", model.idle, "W");
  require_non_negative("power.idle_deviation_w", model.idle_deviation, "W");
  require_within("power.efficiency", model.efficiency, 0.01, 1.0, "");
}

LeastSquaresState update(const LeastSquaresState& state, const OnlineSample& sample,
                         const OnlineOptions& options) noexcept {
  LeastSquaresState next = state;
  if (!finite(sample)) return next;
  OnlineEstimate& now = next.last;
  const double keep = std::exp(-elapsed(state.last, sample) / options.memory);
  now.time = sample.time;
  now.jumped = false;
  next.information *= keep;
  next.moment *= keep;
  next.squares *= keep * keep;
  if (sample.unit <= options.least_unit || sample.unit <= 0.0) return next;

  const double before = now.informed ? now.strength : sample.measured / sample.unit;
  const double variance =
      square(options.noise) + square(options.relative_noise * std::max(before, 0.0) * sample.unit);
  const double innovation = sample.measured - before * sample.unit;
  const double expected = variance + square(sample.unit * now.standard_error);
  if (now.informed && square(innovation) > options.jump_test * expected) {
    now.jumped = true;
    next.information = next.moment = next.squares = 0.0;
  }
  const double noise =
      now.jumped ? square(options.noise) + square(options.relative_noise * sample.measured)
                 : variance;
  const double weight = sample.unit / noise;
  next.information += weight * sample.unit;
  next.moment += weight * sample.measured;
  next.squares += weight * sample.unit;
  now.strength = next.moment / next.information;
  // Of weights that fall, the estimate's variance is the sum of their squares over that of them.
  now.standard_error = std::sqrt(next.squares) / next.information;
  now.informed = true;
  return next;
}

KalmanState first_state(double offset, double offset_deviation) noexcept {
  KalmanState state;
  state.offset = offset;
  state.var_offset = square(offset_deviation);
  state.last.offset = offset;
  return state;
}

KalmanState update(const KalmanState& state, const OnlineSample& sample,
                   const OnlineOptions& options) noexcept {
  KalmanState next = state;
  if (!finite(sample)) return next;
  OnlineEstimate& now = next.last;
  const double dt = elapsed(state.last, sample);
  now.time = sample.time;
  now.jumped = false;
  double p_q = state.var_q + square(options.wander) * dt;
  double p_c = state.cov;
  double p_o = state.var_offset + square(options.offset_wander) * dt;
  const double unit = sample.unit > options.least_unit ? std::max(sample.unit, 0.0) : 0.0;

  const double predicted = std::exp(state.q) * unit;
  const auto noise_at = [&](double force) {
    return square(options.noise) + square(options.relative_noise * force);
  };
  const double innovation = sample.measured - state.offset - predicted;
  const double expected =
      square(predicted) * p_q + 2.0 * predicted * p_c + p_o + noise_at(predicted);
  // Beyond what the walk explains, the bone has changed. The variance at first is no jump's.
  if (now.informed && unit > 0.0 && square(innovation) > options.jump_test * expected) {
    now.jumped = true;
    p_q += square(options.jump);
  }
  // Iterated: the most probable state by Gauss and Newton from the prediction.
  double q = state.q;
  double offset = state.offset;
  double h = 0.0;
  double variance = 1.0;
  for (int i = 0; i < kMostIterations; ++i) {
    h = std::exp(q) * unit;
    variance = h * h * p_q + 2.0 * h * p_c + p_o + noise_at(h);
    if (variance <= 0.0) break;
    const double miss = sample.measured - offset - h - h * (state.q - q) - (state.offset - offset);
    const double to_q = state.q + (h * p_q + p_c) / variance * miss;
    const double to_offset = state.offset + (h * p_c + p_o) / variance * miss;
    // No more than a factor of e at once, where the exponential is far from straight.
    const double step = std::clamp(to_q - q, -1.0, 1.0);
    q = std::clamp(q + step, -kMostLog, kMostLog);
    const double moved = std::abs(to_offset - offset);
    offset = to_offset;
    if (std::abs(step) < 1e-6 && moved < 1e-6 * (1.0 + std::abs(offset))) break;
  }
  h = std::exp(q) * unit;
  variance = h * h * p_q + 2.0 * h * p_c + p_o + noise_at(h);
  if (variance > 0.0) {
    const double k_q = (h * p_q + p_c) / variance;
    const double k_o = (h * p_c + p_o) / variance;
    next.var_q = std::max(p_q - k_q * (h * p_q + p_c), 1e-12);
    next.var_offset = std::max(p_o - k_o * (h * p_c + p_o), 0.0);
    next.cov = p_c - k_q * (h * p_c + p_o);
    next.q = q;
    next.offset = offset;
  }
  // In air nothing is known of the bone to come but its usual range.
  next.var_q = std::min(next.var_q, square(options.jump) + 1.0);
  if (unit > 0.0) now.informed = true;
  now.strength = std::exp(next.q);
  now.standard_error = now.strength * std::sqrt(next.var_q);
  now.offset = next.offset;
  return next;
}

}  // namespace osteomill::identify
