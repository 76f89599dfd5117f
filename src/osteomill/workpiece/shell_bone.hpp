// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "osteomill/workpiece/anatomy.hpp"
#include "osteomill/workpiece/epiphysis.hpp"

namespace osteomill::workpiece {

/// Where the bone of a surface without a CT has its joint, in the frame P of the surface.
struct JointPlace {
  Vector3 level_P = Vector3::Zero();  ///< a point at the level of the joint
  Vector3 axis_P = Vector3::UnitZ();  ///< unit vector from the shaft to the joint
  double shaft = 70e-3;               ///< below the joint the shell has its full thickness, m
  double plate_reach = 25e-3;         ///< the plate lies within this distance of the level, m
};

/// Signed distance to a closed surface, < 0 inside, m. Called from several threads.
using DistanceFunction = std::function<double(const Vector3& p_P)>;

/// A bone whose outside is known and whose inside is painted: a shell by depth below the surface, a
/// subchondral plate where the surface faces the joint within 60°, cancellous bone that thins out
/// away from the joint, marrow in the shaft. The painting is assumed; see EpiphysisBone.
Anatomy shell_bone(DistanceFunction distance, const Extent& box_P, const JointPlace& joint,
                   const EpiphysisBone& bone);

}  // namespace osteomill::workpiece
