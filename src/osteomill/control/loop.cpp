// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/loop.hpp"

#include <algorithm>

namespace osteomill::control {
namespace {

// The loop takes nothing from the heap so long: three hours at 100 Hz.
constexpr std::size_t kManyPeriods = 1 << 20;
constexpr int kLongestStop = 100;  // control periods until a stopped plant is taken to rest

void come_to_rest(Plant& plant, double feed) {
  for (int i = 0; i < kLongestStop && feed > 0.05e-3; ++i) feed = plant.advance({}).feed;
}

}  // namespace

SupervisorInput input_of(const Observation& seen, const FeedCommand& command) noexcept {
  SupervisorInput input;
  input.clock = seen.time;
  input.sample_clock = seen.sample_time;
  input.mean_force = seen.mean_force;
  input.peak_force = seen.peak_force;
  input.torque = seen.mean_torque;
  input.tooth_line = seen.tooth_line;
  input.revolution_line = seen.revolution_line;
  input.temperature = seen.temperature;
  input.no_go_distance = seen.no_go_distance;
  input.feed = seen.feed;
  input.command = command.feed;
  input.rapid = seen.rapid;
  return input;
}

LoopSummary run(Plant& plant, const FeedController& controller, const LoopOptions& options,
                const Progress& progress) {
  check(controller);
  if (options.supervisor) check(*options.supervisor);
  LoopSummary done;
  ControllerState state;
  SupervisorState watch;
  state.feed = options.first_feed;
  double moved_at = 0.0;
  double compute_time = 0.0;
  if (options.real_time) done.compute_times.reserve(kManyPeriods);
  int periods = 0;
  for (Observation seen = plant.start(); !seen.finished; ++periods) {
    const double begin = options.clock ? options.clock() : 0.0;
    ControlStep next = step(controller, state, seen);
    if (options.supervisor) {
      SupervisorInput input = input_of(seen, next.command);
      if (options.real_time) input.compute_time = compute_time;
      if (options.disturb) options.disturb(input);
      const SupervisorStep verdict = supervise(*options.supervisor, watch, input);
      watch = verdict.state;
      if (verdict.tripped) {
        done.events.push_back({seen.time, watch.cause, watch.value, watch.limit});
        if (options.on_event) options.on_event(done.events.back());
        come_to_rest(plant, seen.feed);
        done.end = LoopEnd::supervisor;
        return done;
      }
    }
    if (options.clock) {
      compute_time = options.clock() - begin;
      done.compute_times.push_back(compute_time);
      if (compute_time > controller.period) ++done.overruns;
    }
    state = next.state;
    seen = plant.advance(next.command);
    if (next.command.feed > 0.0) moved_at = seen.time;
    if (seen.time - moved_at > options.patience) {
      done.end = LoopEnd::stalled;
      return done;
    }
    if (periods % (options.real_time ? 5 : 50) == 0 &&
        !go_on(progress, "milling", std::min(1.0, seen.position / options.path_length))) {
      done.end = LoopEnd::stopped;
      return done;
    }
  }
  done.end = LoopEnd::finished;
  return done;
}

}  // namespace osteomill::control
