// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace osteomill::geometry {

using Vector3 = Eigen::Vector3d;

/// X_BC: pose of frame C in frame B; p_B = X_BC * p_C.
using Pose = Eigen::Isometry3d;

}  // namespace osteomill::geometry
