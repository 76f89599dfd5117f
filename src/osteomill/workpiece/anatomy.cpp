// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/anatomy.hpp"

namespace osteomill::workpiece {

Extent extent_in(const Anatomy& anatomy, const geometry::Pose& X_PW) {
  const geometry::Pose X_WP = X_PW.inverse();
  Extent extent;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3 p_P = anatomy.lower_P;
    for (int axis = 0; axis < 3; ++axis)
      if (((corner >> axis) & 1) != 0) p_P[axis] = anatomy.upper_P[axis];
    const Vector3 p_W = X_WP * p_P;
    extent.lower = corner == 0 ? p_W : Vector3(extent.lower.cwiseMin(p_W));
    extent.upper = corner == 0 ? p_W : Vector3(extent.upper.cwiseMax(p_W));
  }
  return extent;
}

Stock stock_of(const Anatomy& anatomy, const geometry::Pose& X_PW, const Extent& box_W,
               double spacing) {
  return Stock(cubes_over(box_W.lower, box_W.upper, spacing),
               [&](const Vector3& p_W) { return anatomy.bone(X_PW * p_W); });
}

}  // namespace osteomill::workpiece
