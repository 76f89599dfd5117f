// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/epiphysis.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

void check(const EpiphysisBone& bone) {
  for (double density :
       {bone.cortical, bone.subchondral, bone.cancellous_joint, bone.cancellous_shaft, bone.marrow})
    require_positive("stock.density_kg_per_m3", density, "kg/m³");
  for (double thickness :
       {bone.gradient_depth, bone.plate, bone.shell_joint, bone.shell_shaft, bone.marrow_from})
    require_positive("stock.thickness_mm", thickness / units::mm, "mm");
}

BoneMaterial material_at(const EpiphysisBone& bone, const BoneDepth& depth) {
  const double t = std::clamp(depth.along, 0.0, 1.0);
  const double eased = t * t * (3.0 - 2.0 * t);  // level at both ends
  const double shell = bone.shell_joint + (bone.shell_shaft - bone.shell_joint) * eased;
  const double below = std::clamp((depth.below_joint - bone.plate) / bone.gradient_depth, 0.0, 1.0);
  double density = bone.cancellous_joint + (bone.cancellous_shaft - bone.cancellous_joint) * below;
  if (depth.below_plate < bone.plate)
    density = bone.subchondral;
  else if (depth.below_side < shell)
    density = bone.cortical;
  else if (depth.below_joint > bone.marrow_from)
    density = bone.marrow;
  density = std::round(density);
  return {density, bone::force_scale(density, bone.force)};
}

}  // namespace osteomill::workpiece
