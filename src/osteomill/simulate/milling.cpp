// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/milling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::simulate {
namespace {

std::size_t samples_per_period(const Machine& machine) {
  return static_cast<std::size_t>(std::round(machine.period * machine.sample_rate));
}

const Machine& checked(const Machine& machine) {
  check(machine);
  return machine;
}

}  // namespace

void check(const Machine& machine) {
  require_positive("cut.spindle_speed_rpm", machine.spindle_speed / units::rpm, "rpm");
  require_positive("controller.period_ms", machine.period / units::ms, "ms");
  require_positive("machine.sample_rate_hz", machine.sample_rate, "Hz");
  require_non_negative("machine.start_feed_mm_per_s", machine.start_feed / units::mm_per_s, "mm/s");
  require_non_negative("machine.force_noise_n", machine.force_noise, "N");
  require_within("machine.delay_updates", machine.delay_updates, 1, 100, "");
  require_within("map.offset_mm", machine.map_offset / units::mm, -1000.0, 1000.0, "mm");
  const double samples = machine.period * machine.sample_rate;
  // Rounding of a period such as 0.01 s times 8000 1/s is far below a millionth.
  if (samples < 1.0 || std::abs(samples - std::round(samples)) > 1e-6) {
    throw InvalidInput(Fault{"machine.sample_rate_hz", std::to_string(machine.sample_rate),
                             "must give a whole number of samples in controller.period_ms", ""});
  }
  if (machine.servo) numerics::check(*machine.servo, "machine.servo");
  if (machine.spindle) {
    const SpindleDrive& drive = *machine.spindle;
    require_positive("machine.spindle.min_rpm", drive.lowest / units::rpm, "rpm");
    require_within("machine.spindle.max_rpm", drive.highest / units::rpm, drive.lowest / units::rpm,
                   1e6, "rpm");
    require_positive("machine.spindle.time_constant_s", drive.time_constant, "s");
    require_within("cut.spindle_speed_rpm", machine.spindle_speed / units::rpm,
                   drive.lowest / units::rpm, drive.highest / units::rpm, "rpm");
  }
}

Milling::Milling(Workpiece& workpiece, const Machine& machine, double force_limit)
    : workpiece_(workpiece),
      machine_(checked(machine)),
      force_limit_(require_positive("limits.force_n", force_limit, "N")),
      length_(workpiece.length()),
      state_{0.0, machine.start_feed, 0.0},
      spindle_speed_(machine.spindle_speed),
      noise_(machine.seed),
      window_(machine.spindle_speed, machine.sample_rate, machine.period) {
  if (machine_.servo) servo_.emplace(*machine_.servo, 1.0 / machine_.sample_rate);
  const std::size_t count = samples_per_period(machine_);
  positions_.resize(count);
  feeds_.resize(count);
  angles_.resize(count);
  cut_.forces_W.resize(count);
  cut_.torques.resize(count);
  cut_.contacts.resize(count);
  reported_.assign(machine_.delay_updates, Reading{});
}

Report Milling::plan_at(double position) const {
  Report seen;
  seen.position = position;
  const Place place = workpiece_.at(position);
  seen.programmed_feed = place.programmed_feed;
  seen.rapid = place.rapid;
  seen.to_contact = workpiece_.to_contact(position - machine_.map_offset);
  seen.to_engagement = workpiece_.to_engagement(position - machine_.map_offset);
  return seen;
}

Report Milling::report() const {
  Report seen = plan_at(state_.integral);
  seen.time = steps_.empty() ? 0.0 : steps_.back().time;
  seen.feed = state_.value;
  seen.spindle_speed = spindle_speed_;
  seen.mean_force = reported_.back().mean;
  seen.peak_force = reported_.back().peak;
  if (!steps_.empty()) seen.mean_torque = steps_.back().mean_torque;
  seen.tooth_line = window_.line(machine_.flutes);
  seen.revolution_line = machine_.flutes == 1 ? 0.0 : window_.line(1);
  seen.temperature = workpiece_.temperature();
  seen.no_go_distance = workpiece_.no_go_distance();
  seen.finished = finished();
  return seen;
}

Report Milling::advance(const FeedRequest& request) {
  require_non_negative("feed command", request.feed / units::mm_per_s, "mm/s");
  const double sample_time = 1.0 / machine_.sample_rate;
  if (machine_.spindle && request.spindle_speed > 0.0) {
    const SpindleDrive& drive = *machine_.spindle;
    const double wanted = std::clamp(request.spindle_speed, drive.lowest, drive.highest);
    // The mean of the period, held over it.
    spindle_speed_ +=
        (wanted - spindle_speed_) * -std::expm1(-machine_.period / drive.time_constant);
    window_.set_speed(spindle_speed_);
  }
  const double from = state_.integral;
  numerics::LagState state = state_;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (servo_) {
      state = servo_->advance(state, request.feed);
    } else {
      state = {state.integral + request.feed * sample_time, request.feed, 0.0};
    }
    positions_[i] = state.integral;
    feeds_[i] = state.value;
  }
  follow(positions_, feeds_);
  state_ = state;
  state_.integral = workpiece_.next_start(from, state_.integral);
  return end_period(request);
}

const Cut& Milling::follow(std::span<const double> positions, std::span<const double> feeds) {
  const double sample_time = 1.0 / machine_.sample_rate;
  const double start_time = static_cast<double>(steps_.size()) * machine_.period;
  const auto in_period = static_cast<double>(positions_.size());
  const std::size_t count = positions.size();
  if (followed_ == 0) opened_at_ = state_.integral;
  for (std::size_t i = 0; i < count; ++i) {
    angle_ += spindle_speed_ * sample_time;
    angles_[i] = angle_;
  }
  angle_ = std::fmod(angle_, 2.0 * std::numbers::pi);
  cut_.forces_W.resize(count);
  cut_.torques.resize(count);
  cut_.contacts.resize(count);
  cut_.removed_volume = 0.0;
  cut_.contact_length = 0.0;
  cut_.material = 0.0;
  const std::span<const double> angles(angles_.data(), count);
  workpiece_.mill({state_.integral, positions, feeds, angles, sample_time, spindle_speed_}, cut_);
  open_.removed_volume += cut_.removed_volume;
  open_.contact_length = cut_.contact_length;
  if (cut_.material > 0.0) {
    open_.material += cut_.material;
    ++pieces_in_bone_;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double force = cut_.forces_W[i].norm();
    open_.mean_force_W += cut_.forces_W[i] / in_period;
    open_.mean_torque += cut_.torques[i] / in_period;
    open_.peak_force = std::max(open_.peak_force, force);
    open_.feed_work -= cut_.forces_W[i].dot(cut_.direction_W) * feeds[i] * sample_time;
    open_.spindle_work += cut_.torques[i] * spindle_speed_ * sample_time;
    if (force > force_limit_) open_.time_above_limit += sample_time;
    ++followed_;
    if (cut_.contacts[i] != 0) {
      const double time = start_time + followed_ * sample_time;
      if (open_.samples_in_contact == 0) open_.first_contact = time;
      open_.last_contact = time;
      ++open_.samples_in_contact;
      open_.sum_force += force;
    }
    window_.add(force);
  }
  if (!std::isfinite(open_.sum_force) || !std::isfinite(open_.mean_torque)) {
    throw NoSolution("the cutting force is not finite at " +
                     std::to_string(positions.back() / units::mm) + " mm along the path");
  }
  state_ = {positions.back(), feeds.back(), 0.0};
  return cut_;
}

Report Milling::end_period(const FeedRequest& request) {
  Step step = open_;
  step.time = static_cast<double>(steps_.size() + 1) * machine_.period;
  step.line = workpiece_.at(opened_at_).line;
  step.command = request.feed;
  step.mode = request.mode;
  step.saturated = request.saturated;
  step.bound = request.bound;
  step.temperature = workpiece_.temperature();
  step.feed = state_.value;
  step.spindle_speed = spindle_speed_;
  if (pieces_in_bone_ > 0) step.material /= pieces_in_bone_;
  step.mean_force = window_.mean();
  step.position = state_.integral;
  const Place end = workpiece_.at(state_.integral);
  step.tip_W = end.tip_W;
  step.axis_W = end.axis_W;
  step.rapid = end.rapid;
  steps_.push_back(step);

  std::rotate(reported_.rbegin(), reported_.rbegin() + 1, reported_.rend());
  const double noise = machine_.force_noise > 0.0 ? machine_.force_noise * noise_.normal() : 0.0;
  reported_.front() = {step.mean_force + noise, step.peak_force + noise};
  open_ = {};
  followed_ = 0;
  pieces_in_bone_ = 0;
  return report();
}

}  // namespace osteomill::simulate
