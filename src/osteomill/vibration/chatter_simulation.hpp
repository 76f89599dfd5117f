// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "osteomill/vibration/regeneration.hpp"

namespace osteomill::vibration {

/// Force per unit edge length, N/m.
struct EdgeForce {
  double tangential = 0.0;
  double radial = 0.0;
};

struct ChatterSimulationOptions {
  int steps = 240;          ///< of a tooth period
  int slices = 1;           ///< of the depth; more than one resolves a helix
  int most_periods = 1500;  ///< tooth periods
  bool keep_motion = false;
  /// False keeps every edge in its cut, with chips below zero where need be: the linear equation
  /// that the lobes solve. True is what happens.
  bool edges_may_leave = true;
  /// Force of an edge at chip thickness h (m) and angle. Empty: linear with the cut's coefficients.
  std::function<EdgeForce(double h, double theta)> law = {};
};

struct ChatterSimulation {
  bool unstable = false;
  double growth = 0.0;  ///< factor per tooth period of what does not repeat from tooth to tooth
  int periods = 0;      ///< simulated
  double largest_chip = 0.0;    ///< m, in the last period
  double peak_to_peak_x = 0.0;  ///< of the tip, m, in the last period
  double peak_to_peak_y = 0.0;
  double time_step = 0.0;    ///< s
  std::vector<double> x, y;  ///< motion of the tip, m, when kept
};

/// Regenerative milling in time, the judge of the lobes.
///
/// The modes are integrated by exponential steps with the force linear over a step (predicted,
/// then corrected); the chip is what lies between the edge and the surface that earlier passes
/// left, so that an edge that leaves the bone cuts nothing and the next one finds more:
/// basic non-linearity of chatter, [schmitz2009] ch. 4. Ends when the part of the motion that does
/// not repeat has grown or shrunk by a factor of 10⁴, or after `most_periods`.
ChatterSimulation simulate_chatter(const RegenerativeSystem& system, double spindle_speed,
                                   double depth, double feed_per_tooth,
                                   const ChatterSimulationOptions& options);

}  // namespace osteomill::vibration
