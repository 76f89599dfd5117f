// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "osteomill/base/progress.hpp"
#include "osteomill/calibrate/simulated_tracker.hpp"

namespace osteomill::calibrate {

/// Everything between a planned cut and the guide, end to end: probe, calibration, targets, motors,
/// load, verification. Standard deviations.
struct BudgetOptions {
  SimulatedRobot robot = simulated_robot();
  double cone_noise = 0.46 * units::mm;    ///< of a pointer reading; 30 are averaged a cone
  double cone_spacing = 50.0 * units::mm;  ///< of the planar probe's three cones
  double gear_error = 0.05 * units::deg;   ///< of each gear's transmission; assumed
  double skew = 0.1 * units::deg;          ///< between the axes, calibrated for; assumed
  double guide_torque = 0.15;              ///< of the guide's own weight about A1, N m; assumed
  double gear_stiffness = 910;             ///< N m/rad at that torque; assumed
  int trials = 400;
  std::uint64_t seed = 1;
};

/// What one source does alone, or all together.
struct BudgetLine {
  std::string source;
  robot::PerCut<double> flexion_sd{};  ///< of the guide's angle about the robot's axis, rad
  robot::PerCut<double> offset_sd{};   ///< of the guide's tip across the cut, m
  double flexion_rms = 0.0;            ///< over the cuts, rad
  double mean_absolute = 0.0;          ///< mean absolute error over cuts and trials, rad
  double offset_rms = 0.0;             ///< m
};

/// Lines by falling flexion_rms, then "all" (what the guide does) and "all, as verified" (what the
/// tracker shows of it, with its own noise: the number that [plaskos2006] Table 5.4 prints).
std::vector<BudgetLine> error_budget(const BudgetOptions& options, const Progress& progress = {});

}  // namespace osteomill::calibrate
