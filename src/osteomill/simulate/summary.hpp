// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "osteomill/simulate/milling.hpp"

namespace osteomill::simulate {

enum class Status : std::uint8_t {
  not_run,
  finished,    ///< the path has come to its end
  stopped,     ///< asked to stop; what was done is there
  supervisor,  ///< stopped by the supervisor
  stalled      ///< the controller asks for no feed any more
};

const char* name(Status status);

/// What a run comes to. Times count from the first contact.
struct Summary {
  Status status = Status::not_run;
  double cutting_time = 0.0;      ///< first contact to last exit, air between included, s
  double first_contact = 0.0;     ///< since the start, s
  double mean_force = 0.0;        ///< of the magnitude, over the time in contact, N
  double peak_force = 0.0;        ///< N
  double time_above_limit = 0.0;  ///< s
  double removed_volume = 0.0;    ///< m³
  double max_feed = 0.0;          ///< in contact, m/s
  double feed_work = 0.0;         ///< J
  double spindle_work = 0.0;      ///< J
  /// In contact with the command at the largest feed, s; see kShortestInterval.
  std::vector<std::array<double, 2>> saturated_intervals;
  std::vector<double> line_times;        ///< first contact to last exit on each line, s
  std::vector<double> line_mean_forces;  ///< over the time in contact on each line, N
  std::size_t steps = 0;
};

/// Saturation that is shorter is not reported as an interval, s.
inline constexpr double kShortestInterval = 0.1;

Summary summarise(const std::vector<Step>& steps, int lines, Status status);

}  // namespace osteomill::simulate
