// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/supervised_plant.hpp"

#include <algorithm>
#include <chrono>

#include "osteomill/io/real_time.hpp"

namespace osteomill::io {
namespace {

constexpr int kMachinePriority = 82;     // above the controller's
constexpr int kSupervisorPriority = 85;  // above both
constexpr double kRest = 0.05e-3;        // slower is rest, m/s
constexpr int kLongestStop = 100;        // periods until a stopped plant is taken to rest
constexpr double kGrace = 0.5;           // of a period that the machine waits for an answer

}  // namespace

SupervisedPlant::SupervisedPlant(control::Plant& plant, const SupervisedOptions& options)
    : plant_(plant), options_(options) {
  control::check(options_.limits);
}

SupervisedPlant::~SupervisedPlant() { end(); }

void SupervisedPlant::end() {
  {
    const std::lock_guard lock(mutex_);
    leave_ = true;
  }
  changed_.notify_all();
  if (machine_.joinable()) machine_.join();
  if (supervisor_.joinable()) supervisor_.join();
}

control::Observation SupervisedPlant::start() {
  seen_ = plant_.start();
  command_.feed = seen_.feed;
  asked_at_ = options_.clock();
  return seen_;
}

control::Observation SupervisedPlant::advance(const control::FeedCommand& command) {
  std::unique_lock lock(mutex_);
  command_ = command;
  answered_ = true;
  took_ = options_.clock() - asked_at_;
  if (!machine_.joinable()) {
    // The first answer begins the first period.
    machine_ = std::thread([this] { move(); });
    supervisor_ = std::thread([this] { watch(); });
  }
  const std::int64_t before = periods_;
  changed_.notify_all();
  changed_.wait(lock, [&] { return periods_ != before || done_; });
  if (failure_) std::rethrow_exception(failure_);
  if (done_) seen_.finished = true;
  return seen_;
}

/// What goes to the plant: with a stop feed zero, and the stop is noted as held.
control::FeedCommand SupervisedPlant::next_command() {
  if (!stop_) return command_;
  if (!stop_->held) stop_->held = seen_.time;
  return {};
}

void SupervisedPlant::move() {
  ask_for_real_time(kMachinePriority);
  const std::chrono::duration<double> grace(kGrace * options_.limits.period);
  int stopping = 0;
  std::unique_lock lock(mutex_);
  while (!leave_ && !done_) {
    const control::FeedCommand command = next_command();
    lock.unlock();
    control::Observation seen;
    std::exception_ptr failure;
    try {
      seen = plant_.advance(command);
    } catch (...) {
      // Given to the controller's thread, see advance().
      failure = std::current_exception();
    }
    lock.lock();
    failure_ = failure;
    if (!failure) {
      seen_ = seen;
      pending_[static_cast<std::size_t>(periods_) % kPending] = seen;
      ++periods_;
    }
    if (answered_) asked_at_ = options_.clock();
    answered_ = false;
    const std::int64_t unseen = periods_ - looked_;
    const int longest = options_.limits.watchdog_periods;
    if (!stop_ && unseen > longest) {
      trip({seen_.time, control::Cause::supervisor_starved, static_cast<double>(unseen),
            static_cast<double>(longest)});
    }
    if (stop_ && seen_.feed < kRest && !stop_->rest) stop_->rest = seen_.time;
    if (stop_) ++stopping;
    const bool rests = stop_ && stop_->rest && stop_->spindle;
    done_ = failure_ || seen_.finished || rests || stopping > kLongestStop;
    changed_.notify_all();
    if (!done_) changed_.wait_for(lock, grace, [&] { return answered_ || stop_ || leave_; });
  }
  done_ = true;
  changed_.notify_all();
}

void SupervisedPlant::watch() {
  const bool granted = ask_for_real_time(kSupervisorPriority);
  const std::chrono::duration<double> longest(options_.limits.watchdog_periods *
                                              options_.limits.period);
  std::unique_lock lock(mutex_);
  real_time_ = granted;
  while (!leave_ && !(done_ && looked_ == periods_)) {
    const bool answers =
        changed_.wait_for(lock, longest, [&] { return periods_ != looked_ || done_ || leave_; });
    if (leave_ || (done_ && looked_ == periods_)) break;
    if (options_.before_look) {
      lock.unlock();
      options_.before_look();
      lock.lock();
    }
    if (!answers) {
      look(seen_, false);
      done_ = true;  // nothing moves that could come to rest
      changed_.notify_all();
      break;
    }
    // Older ones are lost when it has been away for long; the watchdog has stopped by then.
    looked_ = std::max(looked_, periods_ - static_cast<std::int64_t>(kPending) + 1);
    while (looked_ != periods_) {
      look(pending_[static_cast<std::size_t>(looked_) % kPending], true);
      ++looked_;
    }
  }
}

void SupervisedPlant::look(const control::Observation& seen, bool answers) {
  control::SupervisorInput input = control::input_of(seen, command_);
  input.compute_time = answered_ ? took_ : std::max(took_, options_.clock() - asked_at_);
  input.machine_answers = answers;
  if (!answers) input.clock += options_.limits.period;
  if (options_.disturb) options_.disturb(input);
  const control::SupervisorStep verdict = control::supervise(options_.limits, state_, input);
  state_ = verdict.state;
  if (verdict.tripped && !stop_) {
    trip({input.clock, state_.cause, state_.value, state_.limit});
  }
  if (stop_ && verdict.spindle_inhibit && !stop_->spindle) stop_->spindle = input.clock;
}

void SupervisedPlant::trip(const control::LoopEvent& event) {
  stop_ = SupervisedStop{event, {}, {}, {}};
  if (event.cause == control::Cause::supervisor_starved) {
    // The one that would say when the spindle may stop is away: at once.
    stop_->spindle = event.time;
  }
  if (options_.on_event) options_.on_event(event);
  changed_.notify_all();
}

std::optional<SupervisedStop> SupervisedPlant::stop() const {
  const std::lock_guard lock(mutex_);
  return stop_;
}

void SupervisedPlant::finish(control::LoopSummary& loop) {
  end();
  if (!stop_) return;
  loop.events.push_back(stop_->event);
  loop.end = control::LoopEnd::supervisor;
}

}  // namespace osteomill::io
