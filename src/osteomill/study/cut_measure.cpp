// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/cut_measure.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/study/intervals.hpp"

namespace osteomill::study {

Eigen::Matrix3d guide_frame(const Vector3& outward_B, const Vector3& entry_B) {
  const Vector3 z = outward_B.normalized();
  const Vector3 across = entry_B - entry_B.dot(z) * z;
  if (!(outward_B.norm() > 0.0) || !(across.norm() > 1e-6 * entry_B.norm()) ||
      !across.allFinite()) {
    throw InvalidInput(Fault{"guide", "normal and entry direction parallel or zero",
                             "they must span a plane",
                             "give the entry direction along the guide plane"});
  }
  Eigen::Matrix3d R_BG;
  R_BG.col(0) = across.normalized();
  R_BG.col(1) = z.cross(R_BG.col(0));
  R_BG.col(2) = z;
  return R_BG;
}

CutSide side_of(CutKind kind, bool right_knee) {
  const bool left_is_y = kind == CutKind::kProximalTibia || kind == CutKind::kAnteriorFemur;
  return {left_is_y == right_knee};  // medial of a right knee is the patient's left
}

CutError cut_error(const Eigen::Matrix3d& R_BG, const Vector3& normal_B, CutSide side,
                   RotationOrder order) {
  Vector3 n = (R_BG.transpose() * normal_B).normalized();
  if (!(n.norm() > 0.5)) {
    throw InvalidInput(Fault{"cut normal", "zero or not finite", "must be a direction", ""});
  }
  if (n.z() < 0.0) n = -n;
  double about_x = 0.0, about_y = 0.0;
  if (order == RotationOrder::kVarusThenFlexion) {
    about_x = -std::asin(std::clamp(n.y(), -1.0, 1.0));
    about_y = std::atan2(n.x(), n.z());
  } else {
    about_y = std::asin(std::clamp(n.x(), -1.0, 1.0));
    about_x = std::atan2(-n.y(), n.z());
  }
  return {side.medial_is_y ? -about_x : about_x, about_y};
}

Vector3 cut_normal(const Eigen::Matrix3d& R_BG, const CutError& error, CutSide side,
                   RotationOrder order) {
  const double about_x = side.medial_is_y ? -error.varus_valgus : error.varus_valgus;
  const Eigen::AngleAxisd x(about_x, Vector3::UnitX());
  const Eigen::AngleAxisd y(error.flexion_extension, Vector3::UnitY());
  return R_BG * (order == RotationOrder::kVarusThenFlexion ? y * (x * Vector3::UnitZ())
                                                           : x * (y * Vector3::UnitZ()));
}

Eigen::Matrix3d checked_rotation(const Eigen::Matrix3d& R, const char* name) {
  const double determinant = R.determinant();
  if (determinant < 0.0) {
    throw InvalidInput(Fault{name, fmt::format("determinant {:.4f}", determinant),
                             "the frame is mirrored (left-handed)",
                             "reverse one axis of the export, or swap two"});
  }
  const double off = (R.transpose() * R - Eigen::Matrix3d::Identity()).norm();
  if (!(off < 3e-3)) {
    throw InvalidInput(Fault{name, fmt::format("off a rotation by {:.3g}", off),
                             "must be a rotation matrix or a quaternion of length one",
                             "export more digits, and rotations without scale"});
  }
  // The nearest rotation, by the polar iteration; quadratic from so close.
  Eigen::Matrix3d nearest = R;
  for (int i = 0; i < 6; ++i) nearest = 0.5 * (nearest + nearest.inverse().transpose().eval());
  return nearest;
}

PlaneFit fit_plane(std::span<const Vector3> points, const Vector3& outward) {
  const double n = static_cast<double>(points.size());
  if (points.size() < 4) {
    throw InvalidInput(Fault{"points", fmt::format("{}", points.size()),
                             "a plane with its precision needs 4 or more", "digitise more points"});
  }
  PlaneFit fit;
  for (const Vector3& p : points) fit.centroid += p / n;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vector3& p : points) spread += (p - fit.centroid) * (p - fit.centroid).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
  if (!(eigen.eigenvalues()(1) > 1e-12 * eigen.eigenvalues()(2)) || !spread.allFinite()) {
    throw InvalidInput(Fault{"points", "all on one line", "must span a plane",
                             "digitise points spread over the whole surface"});
  }
  fit.normal = eigen.eigenvectors().col(0);
  if (fit.normal.dot(outward) < 0.0) fit.normal = -fit.normal;
  fit.axis1 = eigen.eigenvectors().col(2);
  fit.axis2 = fit.normal.cross(fit.axis1);

  double squares = 0.0, low = 0.0, high = 0.0;
  Eigen::MatrixXd quadric(points.size(), 6);
  Eigen::VectorXd height(points.size());
  const double size = std::sqrt(eigen.eigenvalues()(2) / n);
  for (size_t i = 0; i < points.size(); ++i) {
    const Vector3 d = points[i] - fit.centroid;
    const double h = d.dot(fit.normal), u = d.dot(fit.axis1) / size, v = d.dot(fit.axis2) / size;
    squares += h * h;
    low = std::min(low, h);
    high = std::max(high, h);
    quadric.row(static_cast<Eigen::Index>(i)) << 1.0, u, v, u * u, u * v, v * v;
    height(static_cast<Eigen::Index>(i)) = h;
  }
  fit.residual_sd = std::sqrt(squares / (n - 3.0));
  fit.flatness = high - low;
  fit.flatness_rms = std::sqrt(squares / n);
  fit.tilt_sd_about_axis2 = fit.residual_sd / std::sqrt(eigen.eigenvalues()(2));
  fit.tilt_sd_about_axis1 = fit.residual_sd / std::sqrt(eigen.eigenvalues()(1));
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(quadric);
  fit.roughness_known = points.size() >= 12 && qr.rank() == 6;
  if (fit.roughness_known) {
    fit.roughness_rms = (height - quadric * qr.solve(height)).norm() / std::sqrt(n - 6.0);
  }
  return fit;
}

PlacementPrecision placement_precision(std::span<const double> repeated, double confidence) {
  const Moments m = moments(repeated);
  return {m.sd, sd_interval(m.sd, m.degrees_of_freedom, confidence).high, m.count};
}

}  // namespace osteomill::study
