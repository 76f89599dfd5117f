// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/geometry/pose.hpp"

namespace osteomill::robot {

using geometry::Pose;
using geometry::Vector3;

/// One joint of a serial robot as it stands when all joints are at zero: product of exponentials.
struct Joint {
  std::string name;
  bool prismatic = false;
  Vector3 point = Vector3::Zero();       ///< on the axis, in the base frame B; not used by slides
  Vector3 direction = Vector3::UnitZ();  ///< unit vector in B
  double low = -1e3;                     ///< m or rad
  double high = 1e3;
  double compliance = 0.0;  ///< m/N or rad/(N m); 0: rigid
};

/// Any serial robot: X_BT(q) = exp(S1 q1) ... exp(Sn qn) X_BT(0).
struct SerialChain {
  std::vector<Joint> joints;
  Pose X_BT0 = Pose::Identity();

  Eigen::Index size() const { return static_cast<Eigen::Index>(joints.size()); }
};

/// Throws InvalidInput naming the joint.
void check(const SerialChain& chain);

/// A robot from Denavit and Hartenberg's table (standard convention: turn theta about and move d
/// along z, then move a along and turn alpha about x).
struct DhRow {
  std::string name;
  bool prismatic = false;
  double a = 0.0;      ///< m
  double alpha = 0.0;  ///< rad
  double d = 0.0;      ///< m, at zero
  double theta = 0.0;  ///< rad, at zero
  double low = -1e3;
  double high = 1e3;
};
SerialChain chain_from_dh(const std::vector<DhRow>& rows);

Pose forward(const SerialChain& chain, const Eigen::VectorXd& q);

/// (velocity of the tool point; angular velocity) per joint rate, all in B.
Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian(const SerialChain& chain,
                                                  const Eigen::VectorXd& q);

/// How near to a singular position: smallest singular value of the Jacobian with lengths over
/// `length`, and the number of those above 1e-6 of the largest.
struct Dexterity {
  int rank = 0;
  double smallest = 0.0;
  double manipulability = 0.0;  ///< product of the singular values
};
Dexterity dexterity(const SerialChain& chain, const Eigen::VectorXd& q, double length = 0.1);

struct InverseOptions {
  /// A cutter turns about its own axis: that rotation may be left free.
  bool free_about_tool_axis = false;
  double position_tolerance = 1e-7;  ///< m
  double rotation_tolerance = 1e-6;  ///< rad
  int max_iterations = 200;
  int starts = 8;  ///< besides the given one, spread over the ranges
  std::uint64_t seed = 1;
};
struct InverseResult {
  bool converged = false;
  std::string reason;
  Eigen::VectorXd q;
  double position_error = 0.0;  ///< m
  double rotation_error = 0.0;  ///< rad
  int iterations = 0;
  double limit_distance =
      0.0;  ///< smallest distance to a limit over the half range; 1: all in the middle
};

/// Joint values for a pose, within the limits. Damped least squares; what the pose leaves free
/// (redundant joints, the tool's own axis) moves the joints towards the middle of their ranges.
InverseResult inverse(const SerialChain& chain, const Pose& X_BT, const Eigen::VectorXd& start,
                      const InverseOptions& options = {});

/// Compliance at the tool point, in B, that the joints' own compliance makes: J c J'.
Eigen::Matrix<double, 6, 6> tool_compliance(const SerialChain& chain, const Eigen::VectorXd& q);

/// Principal stiffnesses at the tool point against forces: stiffest direction last; a direction
/// without compliance has an infinite one and is left out.
struct StiffnessEllipsoid {
  std::vector<double> stiffness;    ///< N/m
  std::vector<Vector3> directions;  ///< in B
};
StiffnessEllipsoid stiffness_ellipsoid(const SerialChain& chain, const Eigen::VectorXd& q);

/// The seven-axis milling robot Z B C W V U A. [sugita2009] eq. 1 and 2:
///   E = R_y(B) R_z(C) R_x(A)
///   P = Z i + C2 j + R_y(B) [C3 i + C4 k + R_z(C) (C5 j + W k + V j + U i + R_x(A) G9)]
/// C2–C5, G9 and the limits are not printed: those here are placeholders, assumed so that a knee
/// is within reach. Joint values in the order of the axes. Compliances of U, V, W: 1/271, 1/72,
/// 1/65 mm/N, printed for the home position and taken as those of the three slides.
struct SevenAxisDimensions {
  double c2 = 0.30;
  double c3 = 0.0;
  double c4 = 0.0;
  double c5 = 0.10;
  Vector3 g9{0.0, 0.0, -0.15};
};
SerialChain seven_axis_robot(const SevenAxisDimensions& dimensions = {});

}  // namespace osteomill::robot
