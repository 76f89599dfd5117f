// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "osteomill/robot/guide_positioner.hpp"

namespace osteomill::robot {

enum class AxisKind { revolute, prismatic };

/// An axis of a positioner that moves in the plane of the cuts, and the link behind it.
struct PlanarAxis {
  AxisKind kind = AxisKind::revolute;
  double length = 0.0;     ///< revolute: of the link that it turns, m
  double direction = 0.0;  ///< prismatic: from the link before it, anticlockwise, rad
  JointRange range = {};   ///< rad, or m
  double stiffness = 0.0;  ///< N m/rad or N/m; 0: rigid
};

/// 2 + n axes: two revolute ones, as A1 and A2 of [plaskos2006] 4.3, then any others in the plane:
/// a sliding guide, a telescope, further links. Angles as those of GuidePositioner.
struct PlanarChain {
  std::vector<PlanarAxis> axes;
};

/// A1, A2, what stands between A2's link and the slide, and the slide where the robot has one.
PlanarChain chain_of(const GuidePositioner& robot, const std::vector<PlanarAxis>& further = {});

/// Throws InvalidInput naming the axis.
void check(const PlanarChain& chain);

struct ChainPose {
  std::vector<Vector2> points;  ///< of each axis in order, and the tip of the guide
  double heading = 0.0;         ///< of the guide, from +y, rad

  const Vector2& tip() const { return points.back(); }
};
ChainPose forward(const PlanarChain& chain, const Vector2& axis_position,
                  const Eigen::VectorXd& joints);

/// Derivatives of heading (rad), tip x and tip y (m) by the joints.
Eigen::Matrix3Xd chain_jacobian(const PlanarChain& chain, const Eigen::VectorXd& joints);

/// What is done with the freedom that the cut leaves.
enum class Redundancy {
  joint_centre,           ///< least sum of squared shares of the half ranges off their middles
  smallest_displacement,  ///< the same, off the joints of the position before
  stiffest                ///< least deflection of the tip normal to the guide plane
};

struct ChainOptions {
  Redundancy redundancy = Redundancy::joint_centre;
  Eigen::VectorXd from = {};  ///< for smallest_displacement
};

struct ChainSolution {
  bool found = false;
  std::string reason;  ///< when not found
  Eigen::VectorXd joints;
  Branch branch = Branch::outermost;  ///< A2 before or behind the foot of the perpendicular from A1
  double gap = 0.0;                   ///< from the tip to the entry of the cut, m
  double criterion = 0.0;             ///< of the options
  double normal_compliance = 0.0;     ///< of the tip, normal to the guide plane, m/N
};

/// Joints within their ranges that lay the guide on the cut line, pointing in the direction of
/// cutting, with the tip before the entry. The gap is closed first, as far as the ranges allow;
/// what freedom is left serves the criterion. For given further joints A1 and A2 have the closed
/// form of [plaskos2006] eq. 2.2, 2.3; these are the starts of sequential quadratic programmes.
/// Without further axes it is `inverse`.
ChainSolution solve(const PlanarChain& chain, const Vector2& axis_position, const CutLine& line,
                    Branch branch, const ChainOptions& options = {});

/// The better of both branches: smaller gap, then smaller criterion.
ChainSolution solve(const PlanarChain& chain, const Vector2& axis_position, const CutLine& line,
                    const ChainOptions& options = {});

}  // namespace osteomill::robot
