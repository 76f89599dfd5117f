// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "osteomill/robot/compliance.hpp"

namespace osteomill::robot {

/// How the robot's base is pinned to the bone. [plaskos2006] 5.3.
enum class Fixation { augmented, bicortical };

/// Slopes of displacement (mm/N) and rotation (deg/N) against load, porcine femora decalcified for
/// some days. [plaskos2006] Table 5.2 (measured; the unit N/mm in the text beside it is a
/// misprint). Axes: x posterior, y away from the base, z distal.
struct FixationTest {
  Fixation fixation = Fixation::bicortical;
  int days = 0;
  double mineral_density = 0.0;          ///< BMD of the pair's scanned bone, g/cm²; Table 5.1
  std::array<double, 3> displacement{};  ///< mm/N
  double displacement_magnitude = 0.0;   ///< dP, mm/N
  std::array<double, 3> rotation{};      ///< deg/N
};
const std::vector<FixationTest>& fixation_tests();

/// The slopes at a mineral density between two tested ones, linearly; InvalidInput outside of them:
/// five specimens of porcine bone allow no extrapolation.
FixationTest fixation_at(Fixation fixation, double mineral_density);

/// The pins as a part of a chain at the point where the load was hung, N/m and N m/rad. Slopes of
/// the wrong sign or zero (within the noise of the tests) are taken as rigid. The test loaded one
/// direction, with an offset that was not recorded: the displacement slopes go into the force part,
/// the rotation slopes are divided by `lever`, the assumed offset of the load, m.
Compliance fixation_compliance(const FixationTest& test, const Vector3& point, double lever);

}  // namespace osteomill::robot
