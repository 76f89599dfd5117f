// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/accuracy/tool_deflection.hpp"

namespace osteomill::accuracy {

enum class Rest {
  at_rest,     ///< forces and deflections meet, and a disturbance dies out
  unstable,    ///< they meet, but a disturbance grows from revolution to revolution
  unbalanced,  ///< no deflection was found that they meet at
};

/// The revolution that a cut repeats whose tool gives way.
struct FlexibleCut {
  Rest rest = Rest::unbalanced;
  double residual = 0.0;       ///< largest difference of a chip and what lies before its edge, m
  double growth = 0.0;         ///< of a disturbance in a revolution, at the worst angle
  double worst_angle = 0.0;    ///< of that growth, or of that residual, rad
  double cut_stiffness = 0.0;  ///< dF/dh of the cut over the tool's stiffness, at the largest force
  double revolutions = 0.0;    ///< until a disturbance is down to 1 %, at the largest force
  std::vector<double> angle;   ///< rotation of flute 1's tip, rad
  std::vector<double> force_x, force_y;  ///< N
  std::vector<double> tip_x, tip_y;      ///< m
  double peak_force = 0.0;               ///< resultant, N
  double total_tip = 0.0;                ///< largest minus smallest tip_y, m
  SurfaceError surface;
};

/// Balance of forces and deflections, [sutherland1986] as [plaskos2002] §4.5.5.3 describes it: at
/// each angle the chip is what lies between the deflected edge and the surface that the edges
/// before have left, and the deflection is that of the forces on these chips. The revolution that
/// repeats is sought at once, by Newton's method for all edges that meet the same surface; and the
/// spectral radius of the linearised way from one revolution to the next says whether a cut would
/// come to rest there. Without run-out all edges deflect alike and forces and surface are those of
/// the rigid cut; with run-out the tool's flexibility evens the chips out, and the edge that
/// reaches farthest makes the wall.
///
/// Quasi-static, cylindrical cutters. Chips lie on the rays of the undeflected edges, so that
/// deflections must be small against the cutter's radius. With unequal pitch the revolution is
/// solved at `kUnequalSteps` angles, and at most `kUnequalSlices` slices.
FlexibleCut flexible_cut(const ToolCompliance& tool, const cutting::Cutter& cutter,
                         const cutting::CuttingLaw& law, const cutting::Condition& condition,
                         const cutting::Immersion& immersion,
                         const DeflectionOptions& options = {});
inline constexpr int kUnequalSteps = 72;
inline constexpr int kUnequalSlices = 10;

}  // namespace osteomill::accuracy
