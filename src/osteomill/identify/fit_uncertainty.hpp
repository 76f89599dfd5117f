// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace osteomill::identify {

/// Singular values below this share of the largest belong to what the data do not determine: the
/// derivatives are good to about 1e-8.
inline constexpr double kRankThreshold = 1e-6;

/// What the uncertainty of a fit over a revolution is worked out from. Values are stacked: x at all
/// angles, then y, then z.
struct FitInput {
  const Eigen::MatrixXd& jacobian;   ///< 3 n × unknowns; offsets of the force are the last
  const Eigen::VectorXd& residual;   ///< 3 n
  const Eigen::Vector3d& deviation;  ///< weights of the fit are one over these
  const Eigen::MatrixXd& each;       ///< revolutions in the order of time; empty: not known
  const Eigen::Vector3d& offset_deviation;
  const std::vector<Eigen::Index>& offsets;  ///< components that have one
};

struct Uncertainty {
  Eigen::MatrixXd covariance;
  double degrees_of_freedom = 0.0;
  double condition_number = 0.0;  ///< of the weighted Jacobian with columns of unit length
  double effective_values = 0.0;  ///< see InstantaneousFit
  std::vector<bool> determined;
};

/// Standard deviation of the mean of each component that the scatter of revolutions gives, N;
/// root mean square over the angles.
Eigen::Vector3d scatter_of_mean(const Eigen::MatrixXd& each);

/// How much the variance of a mean grows because neighbours on a circle go together: 1 + 2 sum of
/// the autocorrelations up to the first that is not significant, >= 1.
double correlation_inflation(const Eigen::VectorXd& residual);

/// Covariance of weighted least squares.
///
/// With the scatter of revolutions known it is the sandwich B S B: B the inverse of the weighted
/// normal matrix, S the covariance of the score J' W mean, estimated from the scores of
/// consecutive groups of revolutions (batch means, at most 64 groups). Whatever correlation there
/// is within a group, over angles, components and time, is in S; the intervals have as many degrees
/// of freedom as groups less one. Where the residuals are larger than the scatter explains, the
/// misfit is added as if it were noise of the residuals' own correlation. Without scatter, the
/// residuals are all there is and are taken so.
Uncertainty uncertainty_of(const FitInput& input);

}  // namespace osteomill::identify
