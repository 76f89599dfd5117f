// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/milling.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::simulate {
namespace {

/// Samples in the largest whole number of revolutions that a control period holds, or in one
/// revolution where it takes longer.
std::size_t window_samples(const Machine& machine) {
  const double revolution = 2.0 * std::numbers::pi / machine.spindle_speed;
  // A millionth, so that 10 ms at 6000 rpm hold one revolution in spite of rounding.
  const double revolutions = std::max(1.0, std::floor(machine.period / revolution + 1e-6));
  return static_cast<std::size_t>(
      std::max(1.0, std::round(revolutions * revolution * machine.sample_rate)));
}

std::size_t samples_per_period(const Machine& machine) {
  return static_cast<std::size_t>(std::round(machine.period * machine.sample_rate));
}

}  // namespace

void check(const Machine& machine) {
  require_positive("cut.spindle_speed_rpm", machine.spindle_speed / units::rpm, "rpm");
  require_positive("controller.period_ms", machine.period / units::ms, "ms");
  require_positive("machine.sample_rate_hz", machine.sample_rate, "Hz");
  require_non_negative("machine.start_feed_mm_per_s", machine.start_feed / units::mm_per_s, "mm/s");
  require_non_negative("machine.force_noise_n", machine.force_noise, "N");
  require_within("machine.delay_updates", machine.delay_updates, 1, 100, "");
  const double samples = machine.period * machine.sample_rate;
  // Rounding of a period such as 0.01 s times 8000 1/s is far below a millionth.
  if (samples < 1.0 || std::abs(samples - std::round(samples)) > 1e-6) {
    throw InvalidInput(Fault{"machine.sample_rate_hz", std::to_string(machine.sample_rate),
                             "must give a whole number of samples in controller.period_ms", ""});
  }
  if (machine.servo) numerics::check(*machine.servo, "machine.servo");
}

Milling::Milling(Workpiece& workpiece, const Machine& machine, double force_limit)
    : workpiece_(workpiece),
      machine_(machine),
      force_limit_(require_positive("limits.force_n", force_limit, "N")),
      length_(workpiece.length()),
      state_{0.0, machine.start_feed, 0.0},
      noise_(machine.seed) {
  check(machine_);
  if (machine_.servo) servo_.emplace(*machine_.servo, 1.0 / machine_.sample_rate);
  const std::size_t count = samples_per_period(machine_);
  positions_.resize(count);
  feeds_.resize(count);
  angles_.resize(count);
  cut_.forces_W.resize(count);
  cut_.torques.resize(count);
  cut_.contacts.resize(count);
  window_.assign(window_samples(machine_), 0.0);
  reported_.assign(machine_.delay_updates, Reading{});
}

double Milling::window_mean() const {
  return std::accumulate(window_.begin(), window_.end(), 0.0) / static_cast<double>(window_.size());
}

double Milling::window_line(int per_revolution) const {
  // The window holds whole revolutions, so a line is one term of its Fourier series.
  std::complex<double> sum = 0.0;
  const double turn = machine_.spindle_speed * per_revolution / machine_.sample_rate;
  for (std::size_t i = 0; i < window_.size(); ++i) {
    sum += window_[(window_at_ + i) % window_.size()] *
           std::polar(1.0, -turn * static_cast<double>(i));
  }
  return 2.0 * std::abs(sum) / static_cast<double>(window_.size());
}

Report Milling::report() const {
  Report seen;
  seen.time = steps_.empty() ? 0.0 : steps_.back().time;
  seen.position = state_.integral;
  seen.feed = state_.value;
  seen.programmed_feed = workpiece_.at(state_.integral).programmed_feed;
  seen.mean_force = reported_.back().mean;
  seen.peak_force = reported_.back().peak;
  if (!steps_.empty()) seen.mean_torque = steps_.back().mean_torque;
  seen.tooth_line = window_line(machine_.flutes);
  seen.revolution_line = machine_.flutes == 1 ? 0.0 : window_line(1);
  seen.to_contact = workpiece_.to_contact(state_.integral);
  seen.entering = workpiece_.entering(state_.integral);
  seen.finished = finished();
  return seen;
}

Report Milling::advance(const FeedRequest& request) {
  require_non_negative("feed command", request.feed / units::mm_per_s, "mm/s");
  const double sample_time = 1.0 / machine_.sample_rate;
  const double start_time = steps_.empty() ? 0.0 : steps_.back().time;
  const double from = state_.integral;
  const std::size_t count = positions_.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (servo_) {
      state_ = servo_->advance(state_, request.feed);
    } else {
      state_ = {state_.integral + request.feed * sample_time, request.feed, 0.0};
    }
    angle_ += machine_.spindle_speed * sample_time;
    positions_[i] = state_.integral;
    feeds_[i] = state_.value;
    angles_[i] = angle_;
  }
  angle_ = std::fmod(angle_, 2.0 * std::numbers::pi);
  cut_.removed_volume = 0.0;
  cut_.material = 0.0;
  workpiece_.mill({from, positions_, feeds_, angles_, sample_time, machine_.spindle_speed}, cut_);

  const Place place = workpiece_.at(from);
  Step step;
  step.time = static_cast<double>(steps_.size() + 1) * machine_.period;
  step.line = place.line;
  step.command = request.feed;
  step.mode = request.mode;
  step.saturated = request.saturated;
  step.feed = state_.value;
  step.removed_volume = cut_.removed_volume;
  step.material = cut_.material;
  for (std::size_t i = 0; i < count; ++i) {
    const double force = cut_.forces_W[i].norm();
    step.mean_force_W += cut_.forces_W[i] / static_cast<double>(count);
    step.mean_torque += cut_.torques[i] / static_cast<double>(count);
    step.peak_force = std::max(step.peak_force, force);
    step.feed_work -= cut_.forces_W[i].dot(cut_.direction_W) * feeds_[i] * sample_time;
    step.spindle_work += cut_.torques[i] * machine_.spindle_speed * sample_time;
    if (force > force_limit_) step.time_above_limit += sample_time;
    if (cut_.contacts[i] != 0) {
      const double time = start_time + static_cast<double>(i + 1) * sample_time;
      if (step.samples_in_contact == 0) step.first_contact = time;
      step.last_contact = time;
      ++step.samples_in_contact;
      step.sum_force += force;
    }
    window_[window_at_] = force;
    window_at_ = (window_at_ + 1) % window_.size();
  }
  step.mean_force = window_mean();
  if (!std::isfinite(step.sum_force) || !std::isfinite(step.mean_torque)) {
    throw NoSolution("the cutting force is not finite at " +
                     std::to_string(state_.integral / units::mm) + " mm along the path");
  }
  state_.integral = workpiece_.next_start(from, state_.integral);
  step.position = state_.integral;
  const Place end = workpiece_.at(state_.integral);
  step.tip_W = end.tip_W;
  step.rapid = end.rapid;
  steps_.push_back(step);

  std::rotate(reported_.rbegin(), reported_.rbegin() + 1, reported_.rend());
  const double noise = machine_.force_noise > 0.0 ? machine_.force_noise * noise_.normal() : 0.0;
  reported_.front() = {step.mean_force + noise, step.peak_force + noise};
  return report();
}

}  // namespace osteomill::simulate
