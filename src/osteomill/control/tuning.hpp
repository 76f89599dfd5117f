// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/control/margins.hpp"

namespace osteomill::control {

/// What a loop has to stand: bones and delays that it may meet on one machine.
struct TuningRange {
  double least_gain = 0.0;    ///< of the softest bone, N/(m/s)
  double largest_gain = 0.0;  ///< of the hardest, N/(m/s)
  int least_delay = 1;        ///< control periods from a force to its feed
  int largest_delay = 1;
  std::optional<numerics::SecondOrderLag> servo;  ///< none: the feed is the command at once
  double period = 10e-3;                          ///< s
};

struct TuningGoal {
  double gain_margin = 2.0;                 ///< at least: 6 dB
  double phase_margin = 0.785398163397448;  ///< at least, rad: 45 degrees
};

/// Throws InvalidInput that names the field.
void check(const TuningRange& range);
void check(const TuningGoal& goal);

/// The corners of the range: softest and hardest bone under the shortest and the longest delay.
/// Loop gain grows with the bone and phase falls with the delay, so these are the extremes.
std::vector<LinearPlant> corners(const TuningRange& range);

/// The largest gain on the sum of the taps that has both margins at every corner, m/s per N.
double largest_gain(const TuningRange& range, const TuningGoal& goal);

/// Mean force of each period after the reference has stepped from 0 to 1, one gain for both
/// directions, in the linear plant: what the margins look like in time.
std::vector<double> step_response(const LinearPlant& plant, double gain, int periods);

}  // namespace osteomill::control
