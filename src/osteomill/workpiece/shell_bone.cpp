// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/shell_bone.hpp"

#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

Anatomy shell_bone(DistanceFunction distance, const Extent& box_P, const JointPlace& joint,
                   const EpiphysisBone& bone) {
  check(bone);
  require_positive("stock.shaft_mm", joint.shaft / units::mm, "mm");
  require_positive("stock.joint_axis", joint.axis_P.norm(), "");
  const Vector3 axis = joint.axis_P.normalized();
  const auto at = [distance = std::move(distance), joint, axis, bone](const Vector3& p_P) {
    BoneSample sample;
    sample.signed_distance = distance(p_P);
    BoneDepth depth;
    depth.below_side = std::max(0.0, -sample.signed_distance);
    depth.below_joint = std::max(0.0, axis.dot(joint.level_P - p_P));
    depth.along = depth.below_joint / joint.shaft;
    depth.below_plate = std::numeric_limits<double>::infinity();
    if (depth.below_side < bone.plate && depth.below_joint < joint.plate_reach) {
      constexpr double step = 0.2e-3;  // m: below the thickness of any layer
      Vector3 outwards;
      for (int k = 0; k < 3; ++k) {
        const Vector3 offset = step * Vector3::Unit(k);
        outwards[k] = distance(p_P + offset) - distance(p_P - offset);
      }
      if (outwards.dot(axis) > 0.5 * outwards.norm()) depth.below_plate = depth.below_side;
    }
    sample.material = material_at(bone, depth);
    return sample;
  };
  return {at, box_P.lower, box_P.upper};
}

}  // namespace osteomill::workpiece
