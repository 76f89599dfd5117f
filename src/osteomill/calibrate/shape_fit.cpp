// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/calibrate/shape_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/numerics/decompositions.hpp"

namespace osteomill::calibrate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<double> weights_of(const char* what, const std::vector<Vector3>& points,
                               const std::vector<double>& sd, std::size_t least) {
  if (points.size() < least) {
    throw InvalidInput(Fault{what, fmt::format("{} points", points.size()),
                             fmt::format("must be at least {}", least), "record more points"});
  }
  if (!sd.empty() && sd.size() != points.size()) {
    throw InvalidInput(Fault{what,
                             fmt::format("{} deviations for {} points", sd.size(), points.size()),
                             "must be one deviation a point, or none", ""});
  }
  for (const Vector3& point : points) {
    if (!point.allFinite()) throw InvalidInput(Fault{what, "not a number", "must be finite", ""});
  }
  std::vector<double> weights(points.size(), 1.0);
  for (std::size_t i = 0; i < sd.size(); ++i) {
    weights[i] = 1.0 / (require_positive(what, sd[i], "m") * sd[i]);
  }
  return weights;
}

/// (J' W J)^-1, scaled by the residuals when the noise is not given; fills the quality.
MatrixXd covariance_of(const MatrixXd& jacobian, const VectorXd& residuals,
                       const std::vector<double>& weights, bool known_noise, FitQuality& quality) {
  const VectorXd w = VectorXd::Map(weights.data(), residuals.size());
  quality.residual_rms = std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.size()));
  quality.chi_squared = residuals.cwiseAbs2().dot(w);
  const Eigen::Index unknowns = jacobian.cols();
  quality.freedom = static_cast<int>(residuals.size() - unknowns);
  const MatrixXd weighted = w.asDiagonal() * jacobian;
  const MatrixXd normal = jacobian.transpose() * weighted;
  MatrixXd covariance = normal.ldlt().solve(MatrixXd::Identity(unknowns, unknowns));
  if (!known_noise) covariance *= quality.chi_squared / std::max(1, quality.freedom);
  return covariance;
}

/// One step of Gauss-Newton.
VectorXd step_of(const MatrixXd& jacobian, const VectorXd& residuals,
                 const std::vector<double>& weights) {
  const VectorXd w = VectorXd::Map(weights.data(), residuals.size());
  const MatrixXd weighted = w.asDiagonal() * jacobian;
  const MatrixXd normal = jacobian.transpose() * weighted;
  const VectorXd gradient = weighted.transpose() * residuals;
  return -normal.ldlt().solve(gradient);
}

}  // namespace

PlaneFit fit_plane(const std::vector<Vector3>& points, const std::vector<double>& sd) {
  const std::vector<double> weights = weights_of("plane", points, sd, 3);
  PlaneFit fit;
  double sum = 0.0;
  fit.centroid.setZero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    fit.centroid += weights[i] * points[i];
    sum += weights[i];
  }
  fit.centroid /= sum;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 r = points[i] - fit.centroid;
    scatter += weights[i] * r * r.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  if (!(eigen.eigenvalues()[1] > 1e-12 * eigen.eigenvalues()[2]) ||
      !(eigen.eigenvalues()[2] > 0.0)) {
    throw InvalidInput(Fault{"plane", fmt::format("{} points", points.size()),
                             "must not lie on a line", "spread the points over the plane"});
  }
  fit.normal = eigen.eigenvectors().col(0);
  fit.tangent1 = eigen.eigenvectors().col(2);
  fit.tangent2 = fit.normal.cross(fit.tangent1);
  fit.offset = fit.normal.dot(fit.centroid);
  const auto count = static_cast<Eigen::Index>(points.size());
  MatrixXd jacobian(count, 3);
  VectorXd residuals(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3 r = points[static_cast<std::size_t>(i)] - fit.centroid;
    jacobian.row(i) << r.dot(fit.tangent1), r.dot(fit.tangent2), -1.0;
    residuals[i] = r.dot(fit.normal);
  }
  fit.covariance = covariance_of(jacobian, residuals, weights, !sd.empty(), fit.quality);
  return fit;
}

SphereFit fit_sphere(const std::vector<Vector3>& points, const std::vector<double>& sd) {
  const std::vector<double> weights = weights_of("sphere", points, sd, 4);
  const auto count = static_cast<Eigen::Index>(points.size());
  Vector3 middle = Vector3::Zero();
  for (const Vector3& point : points) middle += point / static_cast<double>(count);
  // Algebraic start |p|² = 2 c·p + (r² − c²), about the middle; then geometric Gauss-Newton.
  MatrixXd rows(count, 4);
  VectorXd right(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3 p = points[static_cast<std::size_t>(i)] - middle;
    const double w = std::sqrt(weights[static_cast<std::size_t>(i)]);
    rows.row(i) << w * 2.0 * p.transpose(), w;
    right[i] = w * p.squaredNorm();
  }
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows);
  if (qr.rank() < 4) {
    throw InvalidInput(Fault{"sphere", fmt::format("{} points", points.size()),
                             "must not lie in a plane", "spread the points over the sphere"});
  }
  const VectorXd start = qr.solve(right);
  SphereFit fit;
  fit.centre = middle + start.head<3>();
  fit.radius = std::sqrt(std::max(0.0, start[3] + start.head<3>().squaredNorm()));
  MatrixXd jacobian(count, 4);
  VectorXd residuals(count);
  for (int round = 0; round < 50; ++round) {
    for (Eigen::Index i = 0; i < count; ++i) {
      const Vector3 r = points[static_cast<std::size_t>(i)] - fit.centre;
      jacobian.row(i) << -r.normalized().transpose(), -1.0;
      residuals[i] = r.norm() - fit.radius;
    }
    const VectorXd step = step_of(jacobian, residuals, weights);
    fit.centre += step.head<3>();
    fit.radius += step[3];
    if (step.norm() < 1e-13) break;
  }
  fit.covariance = covariance_of(jacobian, residuals, weights, !sd.empty(), fit.quality);
  return fit;
}

AxisFit fit_axis(const std::vector<Vector3>& points, const std::vector<double>& sd) {
  const std::vector<double> weights = weights_of("axis", points, sd, 4);
  const PlaneFit plane = fit_plane(points, sd);
  AxisFit fit;
  fit.direction = plane.normal;
  fit.tangent1 = plane.tangent1;
  fit.tangent2 = plane.tangent2;
  fit.plane = plane.quality;
  // Tilting the normal towards −tangent by a moves a point at r along the normal by a (r·tangent).
  fit.direction_covariance = plane.covariance.topLeftCorner<2, 2>();

  const auto count = static_cast<Eigen::Index>(points.size());
  MatrixXd rows(count, 3);
  VectorXd right(count);
  std::vector<Eigen::Vector2d> flat;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3 r = points[static_cast<std::size_t>(i)] - plane.centroid;
    const Eigen::Vector2d p(r.dot(fit.tangent1), r.dot(fit.tangent2));
    flat.push_back(p);
    const double w = std::sqrt(weights[static_cast<std::size_t>(i)]);
    rows.row(i) << w * 2.0 * p.transpose(), w;
    right[i] = w * p.squaredNorm();
  }
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows);
  const VectorXd start = qr.solve(right);
  Eigen::Vector2d centre = start.head<2>();
  fit.radius = std::sqrt(std::max(0.0, start[2] + centre.squaredNorm()));
  MatrixXd jacobian(count, 3);
  VectorXd residuals(count);
  for (int round = 0; round < 100; ++round) {
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Vector2d r = flat[static_cast<std::size_t>(i)] - centre;
      jacobian.row(i) << -r.normalized().transpose(), -1.0;
      residuals[i] = r.norm() - fit.radius;
    }
    const VectorXd step = step_of(jacobian, residuals, weights);
    centre += step.head<2>();
    fit.radius += step[2];
    if (step.norm() < 1e-13) break;
  }
  fit.position_covariance =
      covariance_of(jacobian, residuals, weights, !sd.empty(), fit.circle).topLeftCorner<2, 2>();
  fit.point = plane.centroid + centre.x() * fit.tangent1 + centre.y() * fit.tangent2;

  std::vector<double> angles;
  for (const Eigen::Vector2d& p : flat) {
    angles.push_back(std::atan2(p.y() - centre.y(), p.x() - centre.x()));
  }
  std::sort(angles.begin(), angles.end());
  double hole = angles.front() + 2.0 * std::numbers::pi - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) {
    hole = std::max(hole, angles[i] - angles[i - 1]);
  }
  fit.angle_range = 2.0 * std::numbers::pi - hole;
  if (fit.angle_range < 10.0 * units::deg) {
    throw InvalidInput(Fault{"axis", fmt::format("{:.1f} deg", fit.angle_range / units::deg),
                             "the points must cover an arc of at least 10 deg",
                             "turn the axis farther between the stops"});
  }
  return fit;
}

PivotFit fit_pivot(const std::vector<Pose>& poses) {
  if (poses.size() < 3) {
    throw InvalidInput(Fault{"pivot", fmt::format("{} poses", poses.size()), "must be at least 3",
                             "turn the probe about its tip while recording"});
  }
  const auto count = static_cast<Eigen::Index>(poses.size());
  MatrixXd rows(3 * count, 6);
  VectorXd right(3 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Pose& pose = poses[static_cast<std::size_t>(i)];
    rows.block<3, 3>(3 * i, 0) = pose.linear();
    rows.block<3, 3>(3 * i, 3) = -Eigen::Matrix3d::Identity();
    right.segment<3>(3 * i) = -pose.translation();
  }
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows);
  const MatrixXd r = qr.matrixR().topRows(6);
  const double smallest = std::abs(r(5, 5));
  if (!(smallest > 1e-6 * std::abs(r(0, 0)))) {
    throw InvalidInput(Fault{"pivot", fmt::format("{} poses", poses.size()),
                             "the probe was not turned, or about one axis only",
                             "turn it about two axes by 30 deg or more"});
  }
  PivotFit fit;
  const VectorXd solution = qr.solve(right);
  fit.tip_P = solution.head<3>();
  fit.pivot_F = solution.tail<3>();
  fit.condition = std::abs(r(0, 0)) / smallest;
  const VectorXd residuals = rows * solution - right;
  const std::vector<double> weights(static_cast<std::size_t>(residuals.size()), 1.0);
  fit.covariance = covariance_of(rows, residuals, weights, false, fit.quality);
  return fit;
}

RegistrationFit register_points(const std::vector<Vector3>& points_A,
                                const std::vector<Vector3>& points_B) {
  weights_of("registration", points_A, {}, 3);
  weights_of("registration", points_B, {}, 3);
  if (points_A.size() != points_B.size()) {
    throw InvalidInput(Fault{"registration",
                             fmt::format("{} and {} points", points_A.size(), points_B.size()),
                             "must be the same points in both frames", ""});
  }
  const auto count = static_cast<Eigen::Index>(points_A.size());
  Eigen::Matrix3Xd a(3, count);
  Eigen::Matrix3Xd b(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    a.col(i) = points_A[static_cast<std::size_t>(i)];
    b.col(i) = points_B[static_cast<std::size_t>(i)];
  }
  RegistrationFit fit;
  fit.X_AB.matrix() = Eigen::umeyama(b, a, false);
  const Eigen::Matrix3Xd residuals =
      a - ((fit.X_AB.linear() * b).colwise() + Vector3(fit.X_AB.translation()));
  fit.quality.residual_rms = std::sqrt(residuals.squaredNorm() / static_cast<double>(count));
  fit.quality.chi_squared = residuals.squaredNorm();
  fit.quality.freedom = static_cast<int>(3 * count) - 6;
  return fit;
}

}  // namespace osteomill::calibrate
