// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/supervisor.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::control {
namespace {

struct Fault {
  Cause cause = Cause::none;
  double value = 0.0;
  double limit = 0.0;
};

/// Remembers what the next look compares with, and says how long it has been so.
void note(const SupervisorLimits& limits, SupervisorState& state, const SupervisorInput& in) {
  const bool same = state.begun && in.mean_force == state.mean_force;
  const bool repeats = same && in.feed > limits.stall_feed && in.mean_force != 0.0;
  // A sensor that has sent nothing has not repeated itself: it grows stale.
  if (in.fresh || !repeats) state.frozen = repeats ? state.frozen + 1 : 0;
  const bool broken = in.mean_force > limits.breakage_force && in.revolution_line > in.tooth_line &&
                      in.revolution_line > 0.5 * in.mean_force;
  state.broken = broken ? state.broken + 1 : 0;
  const bool still = in.command > limits.stall_feed && in.feed < limits.stall_feed;
  if (!still || !state.begun) state.still_since = in.clock;
}

/// The first fault in the order of what must be right for the next to mean anything: clock, machine
/// and sensor before forces. `before` is the state of the last look, `now` has been noted.
Fault find(const SupervisorLimits& limits, const SupervisorState& before,
           const SupervisorState& now, const SupervisorInput& in) noexcept {
  const double elapsed = in.clock - before.clock;
  const double longest = limits.clock_tolerance * limits.period;
  if (!std::isfinite(in.clock)) return {Cause::clock_jump, in.clock, 0.0};
  if (before.begun && (elapsed <= 0.0 || elapsed > longest)) {
    return {Cause::clock_jump, elapsed, longest};
  }
  if (!in.machine_answers || !std::isfinite(in.feed)) return {Cause::machine_lost, 0.0, 0.0};
  if (!std::isfinite(in.mean_force) || !std::isfinite(in.peak_force) || !std::isfinite(in.torque)) {
    return {Cause::sensor_not_a_number, 0.0, 0.0};
  }
  if (in.sensor_saturated) return {Cause::sensor_saturated, in.peak_force, 0.0};
  const double age = in.clock - in.sample_clock;
  if (!(age <= limits.sample_age)) return {Cause::sensor_stale, age, limits.sample_age};
  if (limits.frozen_periods > 0 && now.frozen >= limits.frozen_periods) {
    return {Cause::sensor_frozen, in.mean_force, static_cast<double>(limits.frozen_periods)};
  }
  if (in.peak_force > limits.force) return {Cause::force_overload, in.peak_force, limits.force};
  if (std::abs(in.torque) > limits.torque) {
    return {Cause::torque_overload, std::abs(in.torque), limits.torque};
  }
  if (before.begun) {
    const double rate = (in.mean_force - before.mean_force) / std::max(elapsed, in.sample_span);
    if (rate > limits.force_rate) return {Cause::force_rate, rate, limits.force_rate};
  }
  if (now.broken >= limits.breakage_periods) {
    return {Cause::tool_breakage, in.revolution_line, in.tooth_line};
  }
  if (in.clock - now.still_since > limits.stall_time) {
    return {Cause::stall, in.feed, limits.stall_feed};
  }
  if (in.temperature > limits.temperature) {
    return {Cause::temperature, in.temperature, limits.temperature};
  }
  if (!(in.no_go_distance >= limits.no_go_margin)) {
    return {Cause::no_go, in.no_go_distance, limits.no_go_margin};
  }
  // A thousandth, for what rounding adds to a clamped command.
  const double highest = in.rapid ? limits.highest_rapid : limits.highest_feed;
  if (!(in.command >= 0.0 && in.command <= 1.001 * highest)) {
    return {Cause::command_range, in.command, highest};
  }
  if (!(in.compute_time <= limits.period)) {
    return {Cause::controller_overrun, in.compute_time, limits.period};
  }
  if (in.periods_unseen > limits.watchdog_periods) {
    return {Cause::supervisor_starved, static_cast<double>(in.periods_unseen),
            static_cast<double>(limits.watchdog_periods)};
  }
  return {};
}

bool spindle_itself(Cause cause) {
  return cause == Cause::torque_overload || cause == Cause::tool_breakage || cause == Cause::stall;
}

}  // namespace

const char* name(Cause cause) {
  static constexpr std::array<const char*, kCauses> names = {"none",
                                                             "force-overload",
                                                             "torque-overload",
                                                             "force-rate",
                                                             "tool-breakage",
                                                             "stall",
                                                             "temperature",
                                                             "no-go",
                                                             "command-range",
                                                             "sensor-stale",
                                                             "sensor-saturated",
                                                             "sensor-not-a-number",
                                                             "sensor-frozen",
                                                             "clock-jump",
                                                             "machine-lost",
                                                             "controller-overrun",
                                                             "supervisor-starved"};
  return names[static_cast<std::size_t>(cause)];
}

void check(const SupervisorLimits& limits) {
  require_positive("supervisor.force_n", limits.force, "N");
  require_positive("supervisor.torque_nmm", limits.torque / units::n_mm, "N mm");
  require_positive("supervisor.force_rate_n_per_s", limits.force_rate, "N/s");
  require_positive("supervisor.max_feed_mm_per_s", limits.highest_feed / units::mm_per_s, "mm/s");
  require_positive("supervisor.stall_time_s", limits.stall_time, "s");
  require_positive("supervisor.sample_age_ms", limits.sample_age / units::ms, "ms");
  require_positive("supervisor.period_ms", limits.period / units::ms, "ms");
  require_within("supervisor.frozen_periods", limits.frozen_periods, 0, 1000, "");
  require_positive("supervisor.temperature_c", limits.temperature, "K");
  require_within("supervisor.watchdog_periods", limits.watchdog_periods, 1, 1000, "");
  require_non_negative("supervisor.no_go_margin_mm", limits.no_go_margin / units::mm, "mm");
}

SupervisorStep supervise(const SupervisorLimits& limits, const SupervisorState& state,
                         const SupervisorInput& input) noexcept {
  SupervisorStep next;
  next.state = state;
  SupervisorState& now = next.state;
  if (state.cause == Cause::none) {
    note(limits, now, input);
    const Fault fault = find(limits, state, now, input);
    if (fault.cause != Cause::none) {
      now.cause = fault.cause;
      now.value = fault.value;
      now.limit = fault.limit;
      now.stopped_at = input.clock;
      next.tripped = true;
    }
  }
  now.begun = true;
  now.clock = input.clock;
  now.mean_force = input.mean_force;
  if (now.cause == Cause::none) {
    next.feed = input.command;
    next.feed_hold = false;
    next.spindle_inhibit = false;
    return next;
  }
  // Negated, so that a clock or a feed that is not a number inhibits.
  const bool moving = !(input.feed < limits.stall_feed);
  const bool early =
      input.clock - now.stopped_at < limits.spindle_delay && input.clock >= now.stopped_at;
  next.spindle_inhibit = spindle_itself(now.cause) || !(moving && early);
  return next;
}

SupervisorState confirmed() noexcept { return {}; }

}  // namespace osteomill::control
