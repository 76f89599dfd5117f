// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/calibrate/pose_samples.hpp"

namespace osteomill::calibrate {

/// A line in space with a sense: an axis of rotation.
struct Axis {
  Vector3 point = Vector3::Zero();
  Vector3 direction = Vector3::UnitZ();
};

/// The pose that turns a body by `angle` about the axis.
Pose turn_about(const Axis& axis, double angle);

/// Readings of the motors' Hall sensors, rad of the motor.
using Halls = Eigen::Vector2d;

/// The guide positioner as the tracker sees it: body G on the guide, F on the bone.
///
///   X_FG(C) = turn(A1_F, (C1 − H1)/K1) · turn(A2_F, (C2 − H2)/K2) · X_FG(H)
///
/// with A1, A2 as they stand at the reference readings H. [plaskos2006] eq. 4.1 gives the angles;
/// the axes need not be parallel nor the guide square to them.
struct GuideModel {
  Axis A1_F;
  Axis A2_F;
  Pose X_FG0 = Pose::Identity();  ///< at the reference readings
  Halls reference = Halls::Zero();
  Halls gear = {100.0, 100.0};  ///< K: motor turns a joint turn

  Eigen::Vector2d joints(const Halls& halls) const {
    return (halls - reference).cwiseQuotient(gear);
  }
  Pose pose(const Halls& halls) const;
};

/// What was recorded at one stop: a mean pose and the readings.
struct CalibrationStop {
  std::string name;  ///< "P1", "A1 stop 4"
  Halls halls = Halls::Zero();
  StopMean mean;
};

constexpr int kGuideParameters = 14;
using GuideCovariance = Eigen::Matrix<double, kGuideParameters, kGuideParameters>;

/// The model moved by small amounts: A1 (two shifts across, m, two tilts, rad), A2 the same, X_FG0
/// (three shifts of its origin in F, three turns in G). The covariance is of these.
GuideModel moved(const GuideModel& model, const Eigen::Matrix<double, kGuideParameters, 1>& step);

/// What happened between two stops, beside the joints' motion, in one of several ways.
struct Disturbance {
  enum class Kind { none, slip1, slip2, moved_reference, bad_stop };
  Kind kind = Kind::none;
  std::size_t from = 0;  ///< first stop after it, or the bad stop
  double angle = 0.0;    ///< of the slip, or the turn of the reference, rad
  double shift = 0.0;    ///< of the reference's origin, m
};

struct GuideFit {
  GuideModel model;
  GuideCovariance covariance = GuideCovariance::Zero();
  double chi_squared = 0.0;
  int freedom = 0;
  double probability = 1.0;              ///< of residuals this large or larger from noise alone
  double position_rms = 0.0;             ///< m
  double rotation_rms = 0.0;             ///< rad
  std::vector<double> stop_chi_squared;  ///< share of each stop
  Disturbance disturbance;               ///< as estimated together with the model
  bool converged = false;
};

struct GuideFitOptions {
  /// A disturbance is looked for when the fit without one is less probable than this.
  double alarm = 1e-4;
  int max_iterations = 50;
};

/// Weighted least squares of all stops at once, each weighted by its own variance; the start comes
/// from plane and circle fits of the two sweeps (indices of the stops that turn A1, and A2).
/// When the residuals are not noise, a slip of either axis, a moved reference body and a single bad
/// stop are tried at every place, and the one with the smallest Bayesian information criterion is
/// taken out and named.
GuideFit fit_guide(const std::vector<CalibrationStop>& stops,
                   const std::vector<std::size_t>& sweep1, const std::vector<std::size_t>& sweep2,
                   const Halls& gear, const GuideFitOptions& options = {});

}  // namespace osteomill::calibrate
