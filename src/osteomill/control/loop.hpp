// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "osteomill/base/progress.hpp"
#include "osteomill/control/feed_controller.hpp"
#include "osteomill/control/plant.hpp"
#include "osteomill/control/supervisor.hpp"

namespace osteomill::control {

enum class LoopEnd : std::uint8_t {
  not_run,
  finished,   ///< the path has come to its end
  stopped,    ///< asked to stop
  stalled,    ///< no feed was commanded for `patience`
  supervisor  ///< the supervisor stopped the machine; see LoopSummary::events
};

/// A decision of the supervisor.
struct LoopEvent {
  double time = 0.0;  ///< of the plant, s
  Cause cause = Cause::none;
  double value = 0.0;  ///< SI
  double limit = 0.0;  ///< SI
};

struct LoopOptions {
  double first_feed = 3e-3;  ///< what the accumulator starts from, m/s
  double patience = 5.0;     ///< s
  double path_length = 0.0;  ///< for the share of progress, m
  std::optional<SupervisorLimits> supervisor;
  /// Seconds, for the compute time of each step; none: not measured.
  std::function<double()> clock;
  /// The plant runs in real time: a step that takes longer than the period stops the machine.
  bool real_time = false;
  /// Told of every decision of the supervisor at once, in the loop's thread: it must not wait.
  std::function<void(const LoopEvent&)> on_event = {};
  /// Changes what the supervisor sees: how tests bring in a fault that the plant cannot have.
  std::function<void(SupervisorInput&)> disturb = {};
};

struct LoopSummary {
  LoopEnd end = LoopEnd::not_run;
  std::vector<LoopEvent> events;
  std::vector<double> compute_times;  ///< of controller and supervisor, s; empty without a clock
  int overruns = 0;                   ///< steps that took longer than the period
};

/// What the supervisor sees of a period: no compute time, no faults of sensor and machine.
SupervisorInput input_of(const Observation& seen, const FeedCommand& command) noexcept;

/// Runs a controller on a plant as fast as the plant answers. With a supervisor every command goes
/// through it; when it stops, the plant gets feed zero until it rests, and the loop ends.
LoopSummary run(Plant& plant, const FeedController& controller, const LoopOptions& options,
                const Progress& progress = {});

}  // namespace osteomill::control
