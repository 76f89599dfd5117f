// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

/// What the HAL component `osteomill_hal` and a controller say to each other on a Unix socket of
/// sequenced packets: one Hello when the controller has connected, then a Cycle for every servo
/// cycle of LinuxCNC, and Orders back. Both ends run on one machine: the structs travel as they
/// are.
namespace osteomill::io::linuxcnc {

inline constexpr std::uint32_t kMagic = 0x4f4d3032;  // "OM02"
inline constexpr int kJoints = 7;

struct Hello {
  std::uint32_t magic = kMagic;
  std::uint32_t cycle_bytes = 0;  ///< size of a Cycle: a component of another build is noticed
};

/// One servo cycle, as it was at its end.
struct Cycle {
  std::uint32_t number = 0;      ///< consecutive; a gap means that cycles were lost
  std::int32_t motion_type = 0;  ///< motion.motion-type: 0 idle, 1 traverse, 2 linear feed, 3 arc
  std::int32_t order = 0;        ///< number of the newest order that the pins stood for
  std::uint8_t feed_inhibited = 0;
  std::uint8_t spindle_inhibited = 0;
  std::uint8_t heart_beats = 0;     ///< ok-out of the watchdog
  std::uint8_t motion_enabled = 0;  ///< the machine is on
  double joint[kJoints] = {};       ///< positions, mm or degrees; of three axes x, y, z
  double feed = 0.0;                ///< motion.current-vel, mm/s
  double adaptive_feed = 0.0;       ///< share of the programmed feed that was asked for
};

/// What the pins show of the controller.
enum class State : std::int32_t {
  no_controller,  ///< nobody is connected
  running,
  stopped,  ///< the supervisor has stopped the machine
  finished  ///< the path has come to its end
};

/// What the pins are to be. An order is a heartbeat, too.
struct Order {
  std::int32_t number = 0;
  State state = State::running;
  double adaptive_feed = 0.0;  ///< 0...1
  double force = 0.0;          ///< to show, N
  std::uint8_t arm = 0;        ///< in the first order of a connection: this controller takes over
  std::uint8_t feed_hold = 1;  ///< stays, once set, until another controller arms
  std::uint8_t spindle_inhibit = 1;  ///< likewise
  std::uint8_t padding[5] = {};
};

}  // namespace osteomill::io::linuxcnc
