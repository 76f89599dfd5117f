// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/linuxcnc_plant.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/real_time.hpp"

namespace osteomill::io {
namespace {

constexpr double kRest = 1e-6;      // slower than 1 um/s is rest, m/s
constexpr double kAfterRest = 0.5;  // s that a stop is followed beyond the spindle's delay
constexpr int kPriority = 85;       // above the controller's
constexpr auto kLongestApproach = std::chrono::seconds(60);  // from arming to the path
constexpr int kListening = 20;                               // cycles
constexpr std::size_t kFirstHeartbeats = 200;  // cycles until the watchdog must listen
constexpr std::size_t kMostWaiting = 4096;     // cycles; four seconds

int whole_ratio(double of, double by) { return static_cast<int>(std::lround(of / by)); }

}  // namespace

LinuxcncPlant::LinuxcncPlant(linuxcnc::Machine& machine, simulate::Milling& milling,
                             PathFollower follower, netft::Client& sensor, netft::FakeSensor* fake,
                             const LinuxcncOptions& options, double control_period)
    : machine_(machine),
      milling_(milling),
      follower_(std::move(follower)),
      sensor_(sensor),
      fake_(fake),
      options_(options),
      cycles_per_period_(whole_ratio(control_period, options.servo_period)),
      samples_per_cycle_(whole_ratio(options.servo_period, 1.0 / options.sample_rate)),
      force_(options.spindle_speed, options.sample_rate, control_period),
      torque_(options.spindle_speed, options.sample_rate, control_period) {
  control::check(options_.supervisor);
  const double samples = options.servo_period * options.sample_rate;
  if (cycles_per_period_ < 1 || samples_per_cycle_ < 1 ||
      // Rounding of numbers such as 1e-3 s times 8000 1/s is far below a millionth.
      std::abs(samples - samples_per_cycle_) > 1e-6 ||
      std::abs(control_period / options.servo_period - cycles_per_period_) > 1e-6) {
    throw InvalidInput(Fault{"machine.sample_rate_hz", std::to_string(options.sample_rate),
                             "must give whole numbers of samples in a servo period of 1 ms, and "
                             "of these in controller.period_ms",
                             ""});
  }
  // The limits count control periods in a row; here every servo cycle is looked at. A sensor that
  // repeats itself in ten cycles running is frozen all the same.
  options_.supervisor.breakage_periods *= cycles_per_period_;
  positions_.resize(static_cast<std::size_t>(samples_per_cycle_));
  feeds_.resize(positions_.size());
  load_.resize(positions_.size());
}

LinuxcncPlant::~LinuxcncPlant() {
  {
    const std::lock_guard lock(mutex_);
    leave_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

void LinuxcncPlant::order() {
  linuxcnc::Order order;
  // Between the lines the machine moves at its own feed.
  const double share = place_.cut ? command_.feed / options_.full_feed : 1.0;
  order.adaptive_feed = std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 0.0;
  order.force = force_.mean();
  order.feed_hold = stop_ || place_.finished ? 1 : 0;
  order.spindle_inhibit = (stop_ && verdict_.spindle_inhibit) || place_.finished ? 1 : 0;
  order.state = stop_             ? linuxcnc::State::stopped
                : place_.finished ? linuxcnc::State::finished
                                  : linuxcnc::State::running;
  machine_.send(order);
  if (order.adaptive_feed != sent_feed_ && !log_.empty()) {
    changes_.push_back({machine_.last_order(), log_.back().number});
  }
  sent_feed_ = order.adaptive_feed;
}

void LinuxcncPlant::measure(const PathFollower::Place& place, const linuxcnc::Cycle& cycle) {
  const double feed = cycle.feed * units::mm_per_s;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(positions_.size());
    positions_[i] = place_.position + share * (place.position - place_.position);
    feeds_[i] = feed_ + share * (feed - feed_);
    load_[i] = {};
  }
  if (place.cut) {
    const simulate::Cut& cut = milling_.follow(positions_, feeds_);
    for (std::size_t i = 0; i < load_.size(); ++i) {
      load_[i].force_S = cut.forces_W[i];
      load_[i].torque_S.z() = cut.torques[i];
    }
  }
  if (fake_ != nullptr) fake_->measure(load_);
  arrived_.clear();
  sensor_.receive(arrived_);
  peak_in_cycle_ = 0.0;
  for (const netft::Sample& sample : arrived_) {
    const double force = sample.force_S.norm();
    force_.add(force);
    torque_.add(sample.torque_S.z());
    peak_in_cycle_ = std::max(peak_in_cycle_, force);
    measured_.sum_force += force;
    if (force > options_.force_limit) measured_.time_above_limit += 1.0 / options_.sample_rate;
    ++measured_.samples_in_contact;
  }
  measured_.peak_force = std::max(measured_.peak_force, peak_in_cycle_);
  feed_ = feed;
}

/// What the machine fails to do; null when it answers. A watchdog that is armed anew may let go
/// once more before it listens, so it counts from when it has listened for a while.
const char* LinuxcncPlant::missing(const linuxcnc::Cycle& cycle, bool answers) {
  if (!answers) return "no servo cycle came";
  if (cycle.motion_enabled == 0) return "it is off";
  const bool listening = heard_ >= kListening;
  if (!listening) heard_ = cycle.heart_beats != 0 ? heard_ + 1 : 0;
  const bool silent = listening ? cycle.heart_beats == 0 : log_.size() > kFirstHeartbeats;
  return silent ? "its watchdog does not hear the heartbeat" : nullptr;
}

void LinuxcncPlant::look(const linuxcnc::Cycle& cycle, bool answers) {
  control::SupervisorInput input;
  const std::uint32_t first = log_.empty() ? cycle.number : log_.front().number;
  input.clock = (cycle.number - first) * options_.servo_period;
  input.sample_clock = input.clock - sensor_.age();
  input.mean_force = force_.mean();
  input.peak_force = peak_in_cycle_;
  input.torque = torque_.mean();
  input.tooth_line = force_.line(options_.flutes);
  input.revolution_line = options_.flutes == 1 ? 0.0 : force_.line(1);
  input.feed = cycle.feed * units::mm_per_s;
  input.command = place_.cut ? command_.feed : 0.0;
  input.compute_time = asked_ ? options_.clock() - *asked_ : 0.0;
  input.sensor_saturated = netft::faulty(sensor_.health().status);
  const char* lost = missing(cycle, answers);
  input.machine_answers = lost == nullptr;
  if (options_.disturb) options_.disturb(input);
  verdict_ = control::supervise(options_.supervisor, watch_, input);
  watch_ = verdict_.state;
  if (!verdict_.tripped) return;
  MachineStop stop;
  stop.event = {input.clock, watch_.cause, watch_.value, watch_.limit};
  if (watch_.cause == control::Cause::machine_lost && lost != nullptr) stop.detail = lost;
  stop.seen = cycle.number;
  stop_ = stop;
  stop_by_ = options_.clock() + kAfterRest + 2.0 * options_.supervisor.spindle_delay;
  order();
}

void LinuxcncPlant::note_stop(const linuxcnc::Cycle& cycle) {
  MachineStop& stop = *stop_;
  if (!stop.held && cycle.feed_inhibited != 0) stop.held = cycle.number;
  if (!stop.rest && cycle.feed * units::mm_per_s < kRest) stop.rest = cycle.number;
  if (!stop.spindle && cycle.spindle_inhibited != 0) stop.spindle = cycle.number;
}

void LinuxcncPlant::play(const linuxcnc::Cycle& cycle) {
  if (!log_.empty()) lost_ += cycle.number - log_.back().number - 1;
  log_.push_back(cycle);
  while (!changes_.empty() && changes_.front().number <= cycle.order) {
    feed_delays_.push_back(static_cast<int>(cycle.number - changes_.front().seen));
    changes_.erase(changes_.begin());
  }
  const PathFollower::Place place =
      follower_.update(geometry::Vector3(cycle.x, cycle.y, cycle.z) * units::mm);
  if (log_.size() == 1) {
    place_ = place;
    milling_.start_at(place.position);
  }
  measure(place, cycle);
  const bool begins = place.cut && !on_path_;
  place_ = place;
  if (begins) {
    on_path_ = true;  // the controller's first observation
    period_over_ = true;
  }
  if (place.cut && ++cycles_in_period_ == cycles_per_period_) close_period();
  if (stop_) note_stop(cycle);
  look(cycle, true);
}

void LinuxcncPlant::close_period() {
  milling_.end_period({command_.feed, static_cast<int>(command_.mode), command_.saturated});
  simulate::Step step = milling_.steps().back();
  // What the bone gave is replaced by what the sensor measured of it.
  const double samples = std::max(1, measured_.samples_in_contact);
  if (step.samples_in_contact > 0) {
    step.sum_force = measured_.sum_force / samples * step.samples_in_contact;
  }
  step.mean_force = force_.mean();
  step.peak_force = measured_.peak_force;
  step.time_above_limit = measured_.time_above_limit;
  step.mean_torque = torque_.mean();
  steps_.push_back(step);
  measured_ = {};
  cycles_in_period_ = 0;
  period_over_ = true;
}

control::Observation LinuxcncPlant::observe() const {
  const simulate::Report plan = milling_.report();
  control::Observation seen;
  seen.time = plan.time;
  seen.position = place_.position;
  seen.feed = feed_;
  seen.programmed_feed = plan.programmed_feed;
  seen.mean_force = force_.mean();
  seen.peak_force = steps_.empty() ? 0.0 : steps_.back().peak_force;
  seen.mean_torque = torque_.mean();
  seen.tooth_line = force_.line(options_.flutes);
  seen.revolution_line = options_.flutes == 1 ? 0.0 : force_.line(1);
  seen.sample_time = seen.time - sensor_.age();
  seen.to_contact = plan.to_contact;
  seen.entering = plan.entering;
  seen.finished = place_.finished || stop_.has_value();
  return seen;
}

/// Whether there is more to look at: until the path has come to its end, or a stop to rest.
bool LinuxcncPlant::watching() {
  if (leave_ || place_.finished) return false;
  return !stop_ || (!(stop_->rest && stop_->spindle) && options_.clock() < stop_by_);
}

void LinuxcncPlant::watch_machine() {
  ask_for_real_time(kPriority);
  std::vector<linuxcnc::Cycle> cycles;
  cycles.reserve(kMostWaiting);
  try {
    for (bool more = true; more;) {
      cycles.clear();
      const bool answers = machine_.receive(cycles, options_.silence);
      const std::lock_guard lock(mutex_);
      for (const linuxcnc::Cycle& cycle : cycles) play(cycle);
      if (!answers) look(log_.empty() ? linuxcnc::Cycle{} : log_.back(), false);
      // The heartbeat: after all that has come was looked at.
      order();
      more = watching() && answers;
      if (period_over_ || !more) changed_.notify_all();
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  done_ = true;
  changed_.notify_all();
}

control::Observation LinuxcncPlant::wait_for_period(std::unique_lock<std::mutex>& lock) {
  changed_.wait(lock, [this] { return done_ || (period_over_ && !stop_); });
  if (failure_) std::rethrow_exception(failure_);
  period_over_ = false;
  asked_ = options_.clock();
  return observe();
}

control::Observation LinuxcncPlant::start() {
  sensor_.start();
  order();
  std::unique_lock lock(mutex_);
  thread_ = std::thread([this] { watch_machine(); });
  // The approach: until the first cycle on the path.
  const auto begin = std::chrono::steady_clock::now();
  if (!changed_.wait_until(lock, begin + kLongestApproach,
                           [this] { return done_ || period_over_; })) {
    throw WorldError("the machine does not come to the start of the path; see LinuxCNC's log");
  }
  return wait_for_period(lock);
}

control::Observation LinuxcncPlant::advance(const control::FeedCommand& command) {
  std::unique_lock lock(mutex_);
  command_ = command;
  asked_.reset();
  if (!done_) order();
  return wait_for_period(lock);
}

bool LinuxcncPlant::stopped() const {
  const std::lock_guard lock(mutex_);
  return stop_.has_value();
}

std::vector<simulate::Step> LinuxcncPlant::steps() const {
  const std::lock_guard lock(mutex_);
  return steps_;
}

std::vector<linuxcnc::Cycle> LinuxcncPlant::cycles() const {
  const std::lock_guard lock(mutex_);
  return log_;
}

MachineSummary LinuxcncPlant::summary() const {
  const std::lock_guard lock(mutex_);
  MachineSummary done;
  done.cycles = static_cast<std::uint32_t>(log_.size());
  done.lost = lost_;
  done.feed_delays = feed_delays_;
  done.stop = stop_;
  done.sensor = sensor_.health();
  if (!log_.empty()) {
    done.machine_time = (log_.back().number - log_.front().number) * options_.servo_period;
  }
  return done;
}

}  // namespace osteomill::io
