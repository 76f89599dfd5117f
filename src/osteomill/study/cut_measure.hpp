// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "osteomill/geometry/pose.hpp"

/// From planes, poses and points to cutting errors. SI: lengths in m, angles in rad.
///
/// The guide's frame G has x toward the side where the blade enters (anterior for proximal tibial
/// and distal femoral cuts, distal for anterior and posterior femoral ones), z out of the remaining
/// bone, square to the guide plane, and y = z cross x. All poses and normals are in a reference
/// frame B that is fixed to the bone.
namespace osteomill::study {

using geometry::Pose;
using geometry::Vector3;

/// In which order the two rotations about the fixed axes of G are made.
enum class RotationOrder {
  kVarusThenFlexion,  ///< about x first, then about the fixed y: the reading taken here
  kFlexionThenVarus,  ///< about y first, then about the fixed x
};

/// Two fixed-frame rotations that take the guide plane to the cut plane, [plaskos2002] fig. 2.1.
struct CutError {
  /// About x. Positive = varus: more bone left on the lateral side, more removed on the medial.
  /// For secondary cuts the same about the long axis (internal/external rotation).
  double varus_valgus = 0.0;
  /// About y. Positive = bone left at the far edge (posterior on primary cuts): the cut surface
  /// rises from the guide plane away from the entry.
  double flexion_extension = 0.0;
};

/// Frame of a guide: R_BG from its outward normal and entry direction (need not be square).
/// Throws InvalidInput when they are parallel or zero.
Eigen::Matrix3d guide_frame(const Vector3& outward_B, const Vector3& entry_B);

/// `medial_is_y` says whether medial lies on the +y side of G: true for a right tibia and a left
/// femur, false for a left tibia and a right femur (primary cuts).
struct CutSide {
  bool medial_is_y = true;
};

enum class CutKind { kProximalTibia, kDistalFemur, kAnteriorFemur, kPosteriorFemur };

/// From x = entry (anterior for the first two, distal for the others), z = out of the remaining
/// bone and y = z cross x.
CutSide side_of(CutKind kind, bool right_knee);

/// The rotations alpha about x and beta about y with n = R n_z:
///   x then y: n = (cos a sin b, -sin a, cos a cos b);  y then x: n = (sin b, -sin a cos b, cos a
///   cos b).
/// The two differ by a b^2/2 and a^2 b/2: 0.004 deg at 3 deg and 3 deg.
/// `normal_B` is unsigned: of a plane's two normals the one within 90 deg of the guide's is taken.
CutError cut_error(const Eigen::Matrix3d& R_BG, const Vector3& normal_B, CutSide side,
                   RotationOrder order = RotationOrder::kVarusThenFlexion);

/// The cut plane's normal that has these errors; inverse of cut_error.
Vector3 cut_normal(const Eigen::Matrix3d& R_BG, const CutError& error, CutSide side,
                   RotationOrder order = RotationOrder::kVarusThenFlexion);

/// Rotation matrix of a measured pose. Throws InvalidInput when it is mirrored (determinant < 0)
/// or no rotation (farther than 1e-3 from one, as exports with three digits are).
Eigen::Matrix3d checked_rotation(const Eigen::Matrix3d& R, const char* name);

/// Least-squares plane of measured points: the direction of least spread.
struct PlaneFit {
  Vector3 centroid = Vector3::Zero();
  Vector3 normal = Vector3::UnitZ();  ///< sign: with the given outward direction
  Vector3 axis1 = Vector3::UnitX();   ///< in the plane, direction of largest spread
  Vector3 axis2 = Vector3::UnitY();
  double tilt_sd_about_axis1 = 0.0;  ///< predicted from the residuals and the layout, rad
  double tilt_sd_about_axis2 = 0.0;
  double residual_sd = 0.0;   ///< about the plane, n - 3 degrees of freedom
  double flatness = 0.0;      ///< peak to valley about the least-squares plane (ISO 12781 FLTt)
  double flatness_rms = 0.0;  ///< FLTq
  /// About the least-squares quadric surface, so without the form (warp, crown): rms Sq.
  double roughness_rms = 0.0;  ///< 0 with `roughness_known` false below 12 points
  bool roughness_known = false;
};
/// Throws InvalidInput for fewer than 4 points or points on a line.
PlaneFit fit_plane(std::span<const Vector3> points, const Vector3& outward);

/// Scatter of one quantity when a dummy implant is placed again and again on one cut,
/// [plaskos2002] 2.2.2 (30 placements): SD and the upper end of its interval.
struct PlacementPrecision {
  double sd = 0.0;
  double upper = 0.0;
  int placements = 0;
};
PlacementPrecision placement_precision(std::span<const double> repeated, double confidence = 0.95);

}  // namespace osteomill::study
