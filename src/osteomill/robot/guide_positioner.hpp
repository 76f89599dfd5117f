// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <optional>

#include "osteomill/robot/implant.hpp"

namespace osteomill::robot {

struct JointRange {
  double low = -std::numbers::pi;
  double high = std::numbers::pi;
};

/// The bone-mounted guide positioner: two motorised parallel axes A1 and A2, normal to the plane of
/// the cuts, and a guide whose tip may slide out of it in the cutting plane.
/// [plaskos2006] 4.3, 4.4.
struct GuidePositioner {
  double link1 = 0.060;         ///< L1: from A1 to A2, m
  double link2 = 0.030;         ///< L2: from A2 to the guide's tip, slide retracted, m
  double slide_stroke = 0.0;    ///< travel of the guide tip in the cutting plane, m; 0: no slide
  double tool_thickness = 0.0;  ///< of blade or mill, m
  JointRange range1 = {};       ///< limits of theta1, rad
  JointRange range2 = {};       ///< limits of theta2, rad
};

/// Throws InvalidInput naming the field.
void check(const GuidePositioner& robot);

/// theta1: from the anterior direction (+y) to the line A1-A2; theta2: from the line A1-A2 to the
/// guide; both positive from y towards −x, that is anticlockwise about z = x × y.
/// [plaskos2006] eq. 4.1 and the sentence after it; the signs and zeros are not printed there.
struct JointAngles {
  double theta1 = 0.0;  ///< rad, in (−π, π]
  double theta2 = 0.0;  ///< rad, in (−π, π]
};

/// Where the guide is: axis A2 and the tip of the guide, in the frame of axis_position.
struct GuidePose {
  Vector2 X1;
  Vector2 X2;
};

/// Forward kinematics with the slide extended by `slide`.
GuidePose forward(const GuidePositioner& robot, const Vector2& axis_position,
                  const JointAngles& joints, double slide = 0.0);

/// The two solutions of [plaskos2006] eq. 2.2 and 2.3: A2 on the cut line before (outermost,
/// against the direction of cutting) or behind the foot of the perpendicular from A1.
enum class Branch { outermost, innermost };

/// Joint angles that lay A2 and the guide on the cut line, pointing in the direction of cutting.
/// Empty when the line does not meet the circle (A1, L1), that is outside the workspace.
std::optional<JointAngles> inverse(const GuidePositioner& robot, const Vector2& axis_position,
                                   const CutLine& line, Branch branch);

/// Whether both joints are within their ranges (full turns are tried).
bool within_limits(const GuidePositioner& robot, const JointAngles& joints);

/// Derivatives of the guide plane's direction phi = theta1 + theta2 (rad) and of its signed
/// distance rho (m) from the origin, along the normal 90° anticlockwise from the direction of the
/// guide, with respect to theta1 (first column) and theta2.
Eigen::Matrix2d plane_jacobian(const GuidePositioner& robot, const Vector2& axis_position,
                               const JointAngles& joints);

/// Determinant of plane_jacobian, −L1 cos(theta2); it vanishes, and only
/// then, when the link A1-A2 is normal to the guide: the cut line is tangent to the circle (A1,
/// L1).
double plane_determinant(const GuidePositioner& robot, const JointAngles& joints);

/// Derivative of the guide tip X2 with respect to theta1 (first column) and theta2, m/rad.
Eigen::Matrix2d tip_jacobian(const GuidePositioner& robot, const JointAngles& joints,
                             double slide = 0.0);

/// Play at the guide that the play of each axis makes, worst case.
struct GuidePlay {
  double angle = 0.0;   ///< of the guide plane, rad
  double normal = 0.0;  ///< of the tip, normal to the guide plane, m
};
GuidePlay guide_play(const GuidePositioner& robot, const JointAngles& joints, double play1,
                     double play2, double slide = 0.0);

/// The angle brought into (−π, π].
double wrapped(double angle);

}  // namespace osteomill::robot
