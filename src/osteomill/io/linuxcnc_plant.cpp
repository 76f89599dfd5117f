// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/linuxcnc_plant.hpp"

#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/real_time.hpp"

namespace osteomill::io {
namespace {

constexpr double kRest = 1e-6;               // slower than 1 um/s is rest, m/s
constexpr double kAfterRest = 0.5;           // s that a stop is followed beyond the spindle's delay
constexpr int kPriority = 85;                // above the controller's
constexpr int kLongestApproach = 60;         // from arming to the path, s
constexpr int kListening = 20;               // cycles
constexpr int kFirstForce = 200;             // cycles until the sensor must have sent something
constexpr int kFirstHeartbeats = 200;        // cycles until the watchdog must listen
constexpr std::size_t kAtOnce = 256;         // cycles that are taken before an order leaves
constexpr std::size_t kMostArrived = 65536;  // samples; eight seconds

int whole_ratio(double of, double by) { return static_cast<int>(std::lround(of / by)); }

}  // namespace

LinuxcncPlant::LinuxcncPlant(linuxcnc::Machine& machine, simulate::Milling& milling,
                             PathFollower follower, netft::Client& sensor, netft::FakeSensor* fake,
                             const LinuxcncOptions& options, double control_period)
    : plan_(milling),
      machine_(machine),
      follower_(std::move(follower)),
      sensor_(sensor),
      options_(options),
      control_period_(control_period),
      cycles_per_period_(whole_ratio(control_period, options.servo_period)),
      force_(options.spindle_speed, options.sample_rate, control_period),
      torque_(options.spindle_speed, options.sample_rate, control_period),
      bone_(milling, fake, whole_ratio(options.servo_period, 1.0 / options.sample_rate)) {
  control::check(options_.supervisor);
  const double samples = options.servo_period * options.sample_rate;
  if (cycles_per_period_ < 1 || samples < 0.5 ||
      // Rounding of numbers such as 1e-3 s times 8000 1/s is far below a millionth.
      std::abs(samples - std::round(samples)) > 1e-6 ||
      std::abs(control_period / options.servo_period - cycles_per_period_) > 1e-6) {
    throw InvalidInput(Fault{"machine.sample_rate_hz", std::to_string(options.sample_rate),
                             "must give whole numbers of samples in a servo period of 1 ms, and "
                             "of these in controller.period_ms",
                             ""});
  }
  // The limits count control periods in a row; here every servo cycle is looked at. A sensor that
  // repeats itself in ten cycles running is frozen all the same.
  options_.supervisor.breakage_periods *= cycles_per_period_;
  if (options_.robot) joints_ = Eigen::VectorXd::Zero(options_.robot->chain.size());
  arrived_.reserve(kMostArrived);
  sem_init(&news_, 0, 0);
}

LinuxcncPlant::~LinuxcncPlant() {
  leave_ = true;
  if (thread_.joinable()) thread_.join();
  sem_destroy(&news_);
}

void LinuxcncPlant::order() noexcept {
  linuxcnc::Order order;
  // Between the lines the machine moves at its own feed.
  const double share = place_.cut ? command_.feed / options_.full_feed : 1.0;
  order.adaptive_feed = std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 0.0;
  order.force = force_.mean();
  const bool over = place_.finished || bone_.failed() || leave_;
  order.feed_hold = stop_ || over ? 1 : 0;
  order.spindle_inhibit = (stop_ && verdict_.spindle_inhibit) || over ? 1 : 0;
  order.state = stop_  ? linuxcnc::State::stopped
                : over ? linuxcnc::State::finished
                       : linuxcnc::State::running;
  machine_.send(order);
  if (order.adaptive_feed != sent_feed_ && cycles_ > 0) {
    bone_.give(FeedChange{machine_.last_order(), newest_});
  }
  sent_feed_ = order.adaptive_feed;
}

void LinuxcncPlant::take_forces() {
  arrived_.clear();
  sensor_.receive(arrived_);
  if (options_.on_samples) options_.on_samples(arrived_);
  peak_in_cycle_ = 0.0;
  for (const netft::Sample& sample : arrived_) {
    const double force = sample.force_S.norm();
    force_.add(force);
    torque_.add(sample.torque_S.z());
    peak_in_cycle_ = std::max(peak_in_cycle_, force);
    measured_.sum_force += force;
    if (force > options_.force_limit) measured_.time_above_limit += 1.0 / options_.sample_rate;
    ++measured_.samples;
  }
  measured_.peak_force = std::max(measured_.peak_force, peak_in_cycle_);
}

/// What the machine fails to do; null when it answers. A watchdog that is armed anew may let go
/// once more before it listens, so it counts from when it has listened for a while.
const char* LinuxcncPlant::missing(const linuxcnc::Cycle& cycle, bool answers) noexcept {
  if (!answers) return "no servo cycle came";
  if (cycle.motion_enabled == 0) return "it is off";
  const bool listening = heard_ >= kListening;
  if (!listening) heard_ = cycle.heart_beats != 0 ? heard_ + 1 : 0;
  const bool silent = listening ? cycle.heart_beats == 0 : cycles_ > kFirstHeartbeats;
  return silent ? "its watchdog does not hear the heartbeat" : nullptr;
}

/// A sensor that has just been started has a while for its first record.
bool LinuxcncPlant::waits_for_force() const noexcept {
  return sensor_.health().received == 0 && cycles_ < kFirstForce;
}

void LinuxcncPlant::look(const linuxcnc::Cycle& cycle, bool answers) {
  control::SupervisorInput input;
  // A machine that is silent has not stopped the clock.
  input.clock = (cycle.number - first_ + (answers ? 0 : 1)) * options_.servo_period;
  input.sample_clock = input.clock - (waits_for_force() ? 0.0 : sensor_.age());
  input.mean_force = force_.mean();
  input.peak_force = peak_in_cycle_;
  input.torque = torque_.mean();
  input.tooth_line = force_.line(options_.flutes);
  input.revolution_line = options_.flutes == 1 ? 0.0 : force_.line(1);
  input.feed = cycle.feed * units::mm_per_s;
  input.command = place_.cut ? command_.feed : 0.0;
  input.compute_time = std::max(worked_, asked_ ? options_.clock() - *asked_ : 0.0);
  worked_ = 0.0;
  input.sample_span = static_cast<double>(arrived_.size()) / options_.sample_rate;
  input.fresh = !arrived_.empty();
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
  stopped_ = true;
  if (options_.on_event) options_.on_event(stop.event);
}

void LinuxcncPlant::note_stop(const linuxcnc::Cycle& cycle) noexcept {
  MachineStop& stop = *stop_;
  if (!stop.held && cycle.feed_inhibited != 0) stop.held = cycle.number;
  if (!stop.rest && cycle.feed * units::mm_per_s < kRest) stop.rest = cycle.number;
  if (!stop.spindle && cycle.spindle_inhibited != 0) stop.spindle = cycle.number;
}

geometry::Pose LinuxcncPlant::tool_of(const linuxcnc::Cycle& cycle) {
  if (!options_.robot) {
    geometry::Pose X_WT = geometry::Pose::Identity();
    X_WT.translation() = Eigen::Map<const geometry::Vector3>(cycle.joint) * units::mm;
    return X_WT;
  }
  for (Eigen::Index i = 0; i < joints_.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    joints_[i] =
        cycle.joint[at] * (options_.robot->chain.joints[at].prismatic ? units::mm : units::deg);
  }
  return options_.robot->tool_in_work(joints_);
}

void LinuxcncPlant::play(const linuxcnc::Cycle& cycle) {
  const geometry::Pose X_WT = tool_of(cycle);
  const PathFollower::Place place = follower_.update(X_WT.translation());
  if (cycles_++ == 0) {
    first_ = cycle.number;
    newest_ = cycle.number - 1;
    place_ = place;
  }
  if (place.cut) {
    off_path_ = std::max(off_path_, place.off);
    off_axis_ = std::max(off_axis_, workpiece::angle_between(X_WT.linear().col(2), place.axis_W));
  }
  // What LinuxCNC calls its velocity is that of a robot's slides, not of the tip.
  const double elapsed = std::max(cycle.number - newest_, 1U) * options_.servo_period;
  const double feed = options_.robot && place.cut ? (place.position - place_.position) / elapsed
                                                  : cycle.feed * units::mm_per_s;
  newest_ = cycle.number;
  take_forces();
  PlayedCycle piece;
  piece.cycle = cycle;
  piece.from = place_.position;
  piece.to = place.position;
  piece.feed_from = feed_;
  feed_ = feed;
  piece.feed_to = feed_;
  // The controller's first observation, without which nothing moves along the path: when there is a
  // force.
  const bool begins = place.cut && !on_path_ && sensor_.health().received > 0;
  on_path_ = on_path_ || begins;
  place_ = place;
  piece.cut = place.cut && on_path_;
  const bool ends = piece.cut && ++cycles_in_period_ == cycles_per_period_;
  if (ends) close_period(piece);
  if (stop_) note_stop(cycle);
  piece.stop = stop_;
  bone_.give(piece);
  look(cycle, true);
  if ((begins || ends) && !stop_) tell_controller();
}

void LinuxcncPlant::close_period(PlayedCycle& piece) noexcept {
  piece.ends_period = true;
  piece.request = {command_.feed, static_cast<int>(command_.mode), command_.saturated};
  piece.sum_force = measured_.sum_force;
  piece.samples = measured_.samples;
  piece.mean_force = force_.mean();
  piece.peak_force = measured_.peak_force;
  piece.mean_torque = torque_.mean();
  piece.time_above_limit = measured_.time_above_limit;
  peak_in_period_ = measured_.peak_force;
  measured_ = {};
  cycles_in_period_ = 0;
  ++periods_;
}

/// The observation without what the plan knows of the place.
void LinuxcncPlant::tell_controller() noexcept {
  control::Observation seen;
  seen.time = periods_ * control_period_;
  seen.position = place_.position;
  seen.feed = feed_;
  seen.mean_force = force_.mean();
  seen.peak_force = peak_in_period_;
  seen.mean_torque = torque_.mean();
  seen.tooth_line = force_.line(options_.flutes);
  seen.revolution_line = options_.flutes == 1 ? 0.0 : force_.line(1);
  seen.sample_time = seen.time - sensor_.age();
  seen.finished = place_.finished;
  // From the oldest observation that it has not answered.
  if (!asked_) asked_ = options_.clock();
  observations_.push(seen);
  sem_post(&news_);
}

/// A controller that was late stays so, even if this thread was asleep until it had answered.
void LinuxcncPlant::take_answers() noexcept {
  Answer answer;
  while (answers_.pop(answer)) {
    command_ = answer.command;
    if (asked_) worked_ = std::max(worked_, answer.clock - *asked_);
    asked_.reset();
  }
}

/// Whether there is more to look at: until the path has come to its end, or a stop to rest.
bool LinuxcncPlant::watching() const noexcept {
  if (leave_ || place_.finished || bone_.failed()) return false;
  return !stop_ || (!(stop_->rest && stop_->spindle) && options_.clock() < stop_by_);
}

void LinuxcncPlant::watch_machine() noexcept {
  ask_for_real_time(kPriority);
  std::vector<linuxcnc::Cycle> cycles;
  cycles.reserve(kAtOnce);
  linuxcnc::Cycle newest;
  looked_ = options_.clock();
  order();
  for (bool more = true; more;) {
    cycles.clear();
    const linuxcnc::Came came = machine_.receive(cycles, options_.silence);
    take_answers();
    for (const linuxcnc::Cycle& cycle : cycles) play(newest = cycle);
    if (came == linuxcnc::Came::cycles) {
      const double now = options_.clock();
      longest_gap_ = std::max(longest_gap_, now - looked_);
      looked_ = now;
    } else if (came == linuxcnc::Came::nothing) {
      look(newest, false);
      PlayedCycle piece;
      piece.stop = stop_;
      bone_.give(piece);
    }
    // The heartbeat: after all that has come was looked at.
    order();
    more = watching() && came != linuxcnc::Came::nothing;
  }
  if (leave_) order();  // nobody commands any more: hold
  done_ = true;
  sem_post(&news_);
}

/// Until a period is over, or the thread that watches has ended. After a stop the latter.
control::Observation LinuxcncPlant::wait_for_period() {
  bool any = false;
  while (!any && !done_) {
    while (sem_wait(&news_) != 0 && errno == EINTR) {
    }
    while (observations_.pop(seen_)) any = !stopped_;
  }
  if (done_) {
    while (observations_.pop(seen_)) {
    }
    bone_.finish();
    seen_.finished = true;
  }
  const simulate::Report plan = plan_.plan_at(seen_.position);
  seen_.programmed_feed = plan.programmed_feed;
  seen_.to_contact = plan.to_contact;
  seen_.to_engagement = plan.to_engagement;
  return seen_;
}

control::Observation LinuxcncPlant::start() {
  sensor_.start();
  thread_ = std::thread([this] { watch_machine(); });
  // The approach: until the first cycle on the path.
  timespec end{};
  clock_gettime(CLOCK_REALTIME, &end);
  end.tv_sec += kLongestApproach;
  while (sem_timedwait(&news_, &end) != 0) {
    if (errno == ETIMEDOUT) {
      throw WorldError("the machine does not come to the start of the path; see LinuxCNC's log");
    }
  }
  sem_post(&news_);
  return wait_for_period();
}

control::Observation LinuxcncPlant::advance(const control::FeedCommand& command) {
  answers_.push({command, options_.clock()});
  machine_.call();
  return wait_for_period();
}

bool LinuxcncPlant::stopped() const { return stopped_; }

std::vector<simulate::Step> LinuxcncPlant::steps() const { return bone_.steps(); }

std::vector<linuxcnc::Cycle> LinuxcncPlant::cycles() const { return bone_.cycles(); }

MachineSummary LinuxcncPlant::summary() const {
  MachineSummary done = bone_.summary();
  const std::vector<linuxcnc::Cycle> log = bone_.cycles();
  if (!log.empty()) {
    done.machine_time = (log.back().number - log.front().number) * options_.servo_period;
  }
  // The rest is the other thread's until it has ended.
  if (done_) {
    done.stop = stop_;
    done.sensor = sensor_.health();
    done.longest_gap = longest_gap_;
    done.off_path = off_path_;
    done.off_axis = off_axis_;
  }
  return done;
}

}  // namespace osteomill::io
