// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>

#include "osteomill/calibrate/error_budget.hpp"
#include "osteomill/io/robot_case.hpp"

namespace osteomill::io {

/// A case of `osteomill robot calibrate`.
struct RobotCalibrateCase {
  std::filesystem::path record;  ///< empty: the procedure is simulated
  calibrate::SimulatedRobot robot = calibrate::simulated_robot();
  calibrate::SimulatedFaults faults;
  std::uint64_t seed = 1;
  calibrate::CalibrationOptions options;
  std::vector<calibrate::Vector3> cones_G;  ///< of the planar probe; empty: the simulated guide
  ImplantCase implant;
  double distal_overhang = 0.010;
  calibrate::Pose X_FI = calibrate::Pose::Identity();
  calibrate::Vector3 knee_centre_F = calibrate::Vector3::Zero();
  std::optional<calibrate::BudgetOptions> budget;
};
void bind_robot_calibrate(Section& section, RobotCalibrateCase& c);
void bind_robot_calibrate_keys(Section& section);

/// Readings of the procedure, one row a reading: stop, phase (P | A1 | A2), h1_deg, h2_deg, visible
/// (1 | 0), x_mm, y_mm, z_mm, qw, qx, qy, qz: body G in body F. Three stops of phase P.
calibrate::GuideRecord read_guide_record(const std::filesystem::path& file);
void write_guide_record(const std::filesystem::path& file, const calibrate::GuideRecord& record);

}  // namespace osteomill::io
