// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/accuracy/tool_deflection.hpp"

namespace osteomill::accuracy {

struct FlexibleOptions {
  int slices = 12;
  int steps = 120;            ///< of a revolution, rounded up to a multiple of the flutes
  int most_revolutions = 40;  ///< until one repeats the one before
  double tolerance = 1e-4;    ///< of the tip's deflection from one revolution to the next
};

/// The last revolution of a cut whose tool gives way.
struct FlexibleCut {
  bool repeats = false;  ///< the last revolution equals the one before
  int revolutions = 0;
  int unsolved_steps = 0;     ///< of the last revolution, where forces and deflections do not meet
  std::vector<double> angle;  ///< rad
  std::vector<double> force_x, force_y;  ///< N
  std::vector<double> tip_x, tip_y;      ///< m
  double peak_force = 0.0;               ///< resultant, N
  double total_tip = 0.0;                ///< largest minus smallest tip_y, m
  SurfaceError surface;
};

/// Balance of forces and deflections: at each angle the chip is what lies between the deflected
/// edge and the surface that the passes before have left, and the deflection is that of the force
/// on this chip; [sutherland1986], as [plaskos2002] §4.5.5.3 describes it. Without run-out (of the
/// cutter: see cutting::Cutter) all teeth deflect alike and the forces are those of the rigid
/// model; with run-out the tool's flexibility evens the chips out. Quasi-static, cylindrical
/// cutters.
///
/// Where the cut is stiffer than the tool (∂F/∂h × depth against the tip's stiffness, beyond about
/// one half) the balance may jump from tooth to tooth: it then does not repeat, and only the
/// dynamics (vibration: stability) can say what happens.
FlexibleCut flexible_cut(const ToolCompliance& tool, const cutting::Cutter& cutter,
                         const cutting::CuttingLaw& law, const cutting::Condition& condition,
                         const cutting::Immersion& immersion, const FlexibleOptions& options = {});

}  // namespace osteomill::accuracy
