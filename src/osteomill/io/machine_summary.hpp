// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "osteomill/control/loop.hpp"
#include "osteomill/io/netft_client.hpp"

namespace osteomill::io {

/// A stop as the machine's own cycles tell it; numbers of cycles.
struct MachineStop {
  control::LoopEvent event;
  const char* detail = "";               ///< how the machine is lost; else empty
  std::uint32_t seen = 0;                ///< cycle in which the supervisor saw the fault
  std::optional<std::uint32_t> held;     ///< first cycle with the feed inhibited
  std::optional<std::uint32_t> rest;     ///< first cycle at rest
  std::optional<std::uint32_t> spindle;  ///< first cycle with the spindle inhibited
};

struct MachineSummary {
  std::uint32_t cycles = 0;  ///< that were seen
  std::uint32_t lost = 0;
  /// Servo cycles from a change of the feed, as it left here, to the end of the cycle that had it.
  std::vector<int> feed_delays;
  std::optional<MachineStop> stop;
  netft::Health sensor;
  double machine_time = 0.0;  ///< from the first to the last cycle, moves between lines included, s
  double off_path = 0.0;     ///< largest distance of the tip from the planned path while cutting, m
  double off_axis = 0.0;     ///< and angle between the tool's axis and the planned one, rad
  double longest_gap = 0.0;  ///< between two looks of the supervisor, s
  std::uint32_t bone_lag = 0;  ///< most cycles that the played bone was behind the machine
};

}  // namespace osteomill::io
