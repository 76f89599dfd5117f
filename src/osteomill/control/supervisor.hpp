// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>

namespace osteomill::control {

/// Why the supervisor stops the machine.
enum class Cause : std::uint8_t {
  none,
  force_overload,       ///< largest sample above its limit
  torque_overload,      ///< mean torque above its limit
  force_rate,           ///< mean force rises faster than bone can make it
  tool_breakage,        ///< the line at the spindle's frequency stands above that of the teeth
  stall,                ///< feed is commanded and the tool does not move
  temperature,          ///< above its limit
  no_go,                ///< nearer to the no-go region than its margin
  command_range,        ///< the controller asks for a feed that is no feed or above the largest
  sensor_stale,         ///< the newest sample is too old
  sensor_saturated,     ///< the sensor says so
  sensor_not_a_number,  ///< a force is NaN or infinite
  sensor_frozen,        ///< the same value again and again while the tool cuts
  clock_jump,           ///< the clock went back or skipped
  machine_lost,         ///< the machine does not answer
  controller_overrun,   ///< the controller took longer than its period
  supervisor_starved,   ///< the supervisor itself did not look for too long
};

inline constexpr int kCauses = static_cast<int>(Cause::supervisor_starved) + 1;
const char* name(Cause cause);

/// What the supervisor allows. Its limits are its own: they do not come from the controller.
struct SupervisorLimits {
  double force = 150.0;         ///< N
  double torque = 2.0;          ///< N m
  double force_rate = 1.5e4;    ///< N/s
  double breakage_force = 5.0;  ///< N; below it no line of the spectrum means anything
  int breakage_periods = 3;     ///< in a row
  double stall_feed = 0.05e-3;  ///< slower than this is no motion, m/s
  double stall_time = 0.5;      ///< s
  /// Of the hottest bone, K. The 47 °C of [eriksson1983] are for a minute and the surface of a cut
  /// is hotter for moments; by the dose of [sapareto1984] bone is damaged within a period of 10 ms
  /// from 60 °C on. Ours: what is hotter than 70 °C cannot be a moment's matter.
  double temperature = 343.15;
  double no_go_margin = 0.5e-3;  ///< m
  double highest_feed = 12e-3;   ///< m/s
  double highest_rapid = 12e-3;  ///< in moves through air at the machine's own speed, m/s
  double sample_age = 15e-3;     ///< s
  int frozen_periods =
      10;  ///< in a row; 0: not looked for, as a simulated sensor without noise needs
  double period = 10e-3;         ///< of control, s
  double clock_tolerance = 1.5;  ///< periods that the clock may skip
  int watchdog_periods = 5;      ///< without a look of the supervisor
  double spindle_delay = 0.1;    ///< from the feed hold to the spindle's inhibit at the latest, s
};

/// Throws InvalidInput that names the field.
void check(const SupervisorLimits& limits);

/// What is known in a period, from the machine, the sensor and the controller.
struct SupervisorInput {
  double clock = 0.0;            ///< s
  double sample_clock = 0.0;     ///< of the newest sample, s
  double mean_force = 0.0;       ///< N
  double peak_force = 0.0;       ///< N
  double torque = 0.0;           ///< N m
  double tooth_line = 0.0;       ///< amplitude of the force at the tooth frequency, N
  double revolution_line = 0.0;  ///< at the spindle's frequency, N
  double temperature = 0.0;      ///< K; 0: not measured
  double no_go_distance = std::numeric_limits<double>::infinity();  ///< m
  double feed = 0.0;                                                ///< of the tool, m/s
  double command = 0.0;       ///< what the controller asks for, m/s
  double compute_time = 0.0;  ///< of the controller's last step, s
  int periods_unseen = 0;     ///< since the supervisor looked last, this one not counted
  /// How long the samples took that came since the last look, s; 0: not known. After a late look
  /// more of them come at once than the clock tells.
  double sample_span = 0.0;
  bool rapid = false;  ///< what is commanded is the speed of a rapid
  bool fresh = true;   ///< a sample has come since the last look
  bool sensor_saturated = false;
  bool machine_answers = true;
};

struct SupervisorState {
  Cause cause = Cause::none;  ///< none: running
  double value = 0.0;         ///< what went beyond its limit,
  double limit = 0.0;         ///< and that limit, SI
  double stopped_at = 0.0;    ///< clock, s
  bool begun = false;
  double clock = 0.0;
  double mean_force = 0.0;
  double still_since = 0.0;  ///< since when no motion followed a command
  int frozen = 0;            ///< periods with the same force
  int broken = 0;            ///< periods with the signature of a broken tool
};

struct SupervisorStep {
  SupervisorState state;
  double feed = 0.0;  ///< what may go to the machine, m/s
  bool feed_hold = true;
  bool spindle_inhibit = true;
  bool tripped = false;  ///< in this period: the event to record
};

/// One look of the supervisor: a pure function, no heap, lock, log or throw. The first fault stops:
/// feed zero and feed hold at once. The spindle is inhibited at once when it is what overloads or
/// broke (torque, breakage, stall); otherwise when the tool has come to rest, at the latest after
/// `spindle_delay`, so that a cutter is not stopped in the bone while it moves. It never starts
/// again by itself; see confirmed().
SupervisorStep supervise(const SupervisorLimits& limits, const SupervisorState& state,
                         const SupervisorInput& input) noexcept;

/// The operator has looked and lets it go on: a running state that knows no past.
SupervisorState confirmed() noexcept;

}  // namespace osteomill::control
