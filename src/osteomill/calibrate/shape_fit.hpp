// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "osteomill/geometry/pose.hpp"

/// Least-squares fits of simple shapes to points, each with the covariance of what it found.
///
/// `sd` is the standard deviation of each point, per coordinate, m; the weights are 1/sd². Empty
/// vectors stand for equal weights: the noise is then taken from the residuals.
namespace osteomill::calibrate {

using geometry::Pose;
using geometry::Vector3;

struct FitQuality {
  double residual_rms = 0.0;  ///< unweighted, of the distances to the shape, m
  double chi_squared = 0.0;   ///< weighted sum of squares; equals the freedom when sd are right
  int freedom = 0;
};

/// n · p = offset. Covariance of (tilt about two tangents (rad), offset at the centroid (m)).
struct PlaneFit {
  Vector3 normal = Vector3::UnitZ();
  double offset = 0.0;
  Vector3 centroid = Vector3::Zero();
  Vector3 tangent1 = Vector3::UnitX();
  Vector3 tangent2 = Vector3::UnitY();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  FitQuality quality;
};
PlaneFit fit_plane(const std::vector<Vector3>& points, const std::vector<double>& sd = {});

struct SphereFit {
  Vector3 centre = Vector3::Zero();
  double radius = 0.0;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of (centre, radius)
  FitQuality quality;
};
SphereFit fit_sphere(const std::vector<Vector3>& points, const std::vector<double>& sd = {});

/// An axis of rotation from points that turn about it: first a plane is fitted, then a circle in
/// it. [plaskos2006] 5.6.
struct AxisFit {
  Vector3 point = Vector3::Zero();  ///< the circle's centre
  Vector3 direction = Vector3::UnitZ();
  double radius = 0.0;
  Vector3 tangent1 = Vector3::UnitX();
  Vector3 tangent2 = Vector3::UnitY();
  Eigen::Matrix2d direction_covariance =
      Eigen::Matrix2d::Zero();                                    ///< tilt along the tangents, rad²
  Eigen::Matrix2d position_covariance = Eigen::Matrix2d::Zero();  ///< along the tangents, m²
  double angle_range = 0.0;  ///< arc that the points cover, rad
  FitQuality plane;          ///< residuals along the axis
  FitQuality circle;         ///< residuals of the radius
};
AxisFit fit_axis(const std::vector<Vector3>& points, const std::vector<double>& sd = {});

/// The tip of a probe that turns about a fixed point: X_FP · tip_P = pivot_F for all poses.
struct PivotFit {
  Vector3 tip_P = Vector3::Zero();
  Vector3 pivot_F = Vector3::Zero();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double condition = 0.0;  ///< of the normal equations' square root; large: too little turning
  FitQuality quality;
};
PivotFit fit_pivot(const std::vector<Pose>& poses);

/// X_AB that best maps points known in B onto the same points in A (Umeyama without scale).
struct RegistrationFit {
  Pose X_AB = Pose::Identity();
  FitQuality quality;
};
RegistrationFit register_points(const std::vector<Vector3>& points_A,
                                const std::vector<Vector3>& points_B);

}  // namespace osteomill::calibrate
