// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/thermal/heat_partition.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/thermal/analytic_heat.hpp"

namespace osteomill::thermal {

double chip_share(double diffusivity, double shear_strain, double cutting_speed,
                  double chip_thickness) {
  require_positive("thermal.diffusivity", diffusivity, "m²/s");
  require_positive("thermal.shear_strain", shear_strain, "");
  require_non_negative("thermal.cutting_speed", cutting_speed, "m/s");
  require_non_negative("thermal.chip_thickness", chip_thickness, "m");
  const double sweep = cutting_speed * chip_thickness;
  if (sweep == 0.0) return 0.0;
  return 1.0 / (1.0 + 1.328 * std::sqrt(diffusivity * shear_strain / sweep));
}

HeatShares partition(double cutting, double rubbing, double chip_share,
                     const PartitionOptions& options) {
  require_within("thermal.chip_share", chip_share, 0.0, 1.0, "");
  require_within("thermal.rubbing_to_bone", options.rubbing_to_bone, 0.0, 1.0, "");
  require_within("thermal.friction_share", options.friction_share, 0.0, 1.0, "");
  require_within("thermal.friction_to_tool", options.friction_to_tool, 0.0, 1.0, "");
  const double friction = options.friction_share * cutting;
  const double shear = cutting - friction;
  HeatShares shares;
  shares.chip = chip_share * shear + (1.0 - options.friction_to_tool) * friction;
  shares.tool = options.friction_to_tool * friction + (1.0 - options.rubbing_to_bone) * rubbing;
  shares.bone = (1.0 - chip_share) * shear + options.rubbing_to_bone * rubbing;
  return shares;
}

HeatShares shares_of_cut(double work, double rubbing, double surface_speed, double mean_chip,
                         const PartitionOptions& options) {
  // A cut that drives its spindle for a moment heats nothing.
  const double all = std::max(0.0, work);
  const double rubs = std::clamp(rubbing, 0.0, all);
  const double chip =
      chip_share(kCorticalBone.diffusivity(), options.shear_strain, surface_speed, mean_chip);
  return partition(all - rubs, rubs, chip, options);
}

HeatShares shares_of_patch(const PatchCut& patch, const PartitionOptions& options) {
  const double thinnest = patch.chip - patch.spread;
  double ploughs = 0.0;
  if (patch.growing && thinnest < options.least_chip)
    ploughs = patch.spread > 0.0
                  ? std::min(1.0, (options.least_chip - thinnest) / (2.0 * patch.spread))
                  : 1.0;
  const double rubbing = patch.rubbing + ploughs * (patch.work - patch.rubbing);
  return shares_of_cut(patch.work, rubbing, patch.speed, patch.chip, options);
}

}  // namespace osteomill::thermal
