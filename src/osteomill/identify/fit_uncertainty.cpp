// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/fit_uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/numerics/decompositions.hpp"

namespace osteomill::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kMostGroups = 64;

/// Means of consecutive groups of rows, as equal as the count allows.
MatrixXd batch_means(const MatrixXd& rows) {
  const Index groups = std::min(rows.rows(), kMostGroups);
  MatrixXd means(groups, rows.cols());
  for (Index group = 0; group < groups; ++group) {
    const Index from = rows.rows() * group / groups;
    const Index to = rows.rows() * (group + 1) / groups;
    means.row(group) = rows.middleRows(from, to - from).colwise().mean();
  }
  return means;
}

/// Covariance of the mean of rows, from their scatter.
MatrixXd covariance_of_mean(const MatrixXd& rows) {
  const MatrixXd centred = rows.rowwise() - rows.colwise().mean();
  const auto count = static_cast<double>(rows.rows());
  return centred.transpose() * centred / (count * (count - 1.0));
}

}  // namespace

Eigen::Vector3d scatter_of_mean(const MatrixXd& each) {
  Eigen::Vector3d result = Eigen::Vector3d::Zero();
  if (each.rows() < 2) return result;
  const auto count = static_cast<double>(each.rows());
  const Index columns = each.cols() / 3;
  const MatrixXd centred = each.rowwise() - each.colwise().mean();
  for (Index axis = 0; axis < 3; ++axis) {
    const double sum = centred.middleCols(axis * columns, columns).squaredNorm();
    result[axis] = std::sqrt(sum / (static_cast<double>(columns) * count * (count - 1.0)));
  }
  return result;
}

double correlation_inflation(const VectorXd& residual) {
  const Index count = residual.size();
  const double power = residual.squaredNorm();
  if (power <= 0.0) return 1.0;
  double inflation = 1.0;
  for (Index lag = 1; lag <= count / 2; ++lag) {
    double sum = 0.0;
    for (Index i = 0; i < count; ++i) sum += residual[i] * residual[(i + lag) % count];
    const double correlation = sum / power;
    if (correlation < 2.0 / std::sqrt(static_cast<double>(count))) break;
    inflation += 2.0 * correlation;
  }
  return inflation;
}

Uncertainty uncertainty_of(const FitInput& input) {
  const Index values = input.jacobian.rows();
  const Index rows = values / 3;
  const Index unknowns = input.jacobian.cols();
  Uncertainty result;

  MatrixXd weighted = input.jacobian;
  for (Index axis = 0; axis < 3; ++axis) {
    weighted.middleRows(axis * rows, rows) /= input.deviation[axis];
  }
  // What is known of the offsets beforehand, as one more row each.
  const auto offsets = static_cast<Index>(input.offsets.size());
  MatrixXd prior = MatrixXd::Zero(offsets, unknowns);
  for (Index i = 0; i < offsets; ++i) {
    const double deviation = input.offset_deviation[input.offsets[static_cast<std::size_t>(i)]];
    prior(i, unknowns - offsets + i) = std::isfinite(deviation) ? 1.0 / deviation : 0.0;
  }
  MatrixXd all(values + offsets, unknowns);
  all << weighted, prior;
  VectorXd scale = all.colwise().norm();
  for (double& one : scale) one = one > 0.0 ? one : 1.0;
  const Eigen::JacobiSVD<MatrixXd> svd(all * scale.cwiseInverse().asDiagonal(),
                                       Eigen::ComputeThinV);
  const VectorXd& singular = svd.singularValues();
  const double least = kRankThreshold * singular[0];
  VectorXd inverse = VectorXd::Zero(unknowns);
  result.determined.assign(static_cast<std::size_t>(unknowns), true);
  double smallest = singular[0];
  for (Index k = 0; k < unknowns; ++k) {
    if (singular[k] > least) {
      inverse[k] = 1.0 / (singular[k] * singular[k]);
      smallest = singular[k];
      continue;
    }
    for (Index i = 0; i < unknowns; ++i) {
      if (std::abs(svd.matrixV()(i, k)) > 1e-3)
        result.determined[static_cast<std::size_t>(i)] = false;
    }
  }
  result.condition_number = singular[0] / smallest;
  const MatrixXd unscale = scale.cwiseInverse().asDiagonal();
  const MatrixXd bread =
      unscale * svd.matrixV() * inverse.asDiagonal() * svd.matrixV().transpose() * unscale;

  // Residual over noise, and how its neighbours go together; of the worst component.
  VectorXd residual = input.residual;
  double inflation = 1.0;
  for (Index axis = 0; axis < 3; ++axis) {
    residual.segment(axis * rows, rows) /= input.deviation[axis];
    inflation = std::max(inflation, correlation_inflation(residual.segment(axis * rows, rows)));
  }
  const auto freedom = static_cast<double>(values + offsets - unknowns);
  const double ratio = residual.squaredNorm() / std::max(freedom, 1.0);
  const MatrixXd as_noise = weighted.transpose() * weighted;
  const MatrixXd known = prior.transpose() * prior;

  if (input.each.rows() < 2) {
    result.covariance = bread * (ratio * inflation * as_noise + known) * bread;
    result.effective_values = static_cast<double>(values) / inflation;
    result.degrees_of_freedom = std::max(1.0, freedom / inflation);
    return result;
  }
  MatrixXd weights = weighted;
  for (Index axis = 0; axis < 3; ++axis) {
    weights.middleRows(axis * rows, rows) /= input.deviation[axis];
  }
  const MatrixXd scores = batch_means(input.each * weights);
  const MatrixXd noise = covariance_of_mean(scores);
  result.degrees_of_freedom = static_cast<double>(scores.rows() - 1);
  // Of independent values the score would have the covariance J' W J.
  const VectorXd independent = as_noise.diagonal();
  double share = 0.0;
  for (Index i = 0; i < unknowns; ++i) {
    if (noise(i, i) > 0.0) share += independent[i] / noise(i, i);
  }
  share /= static_cast<double>(unknowns);
  result.effective_values = static_cast<double>(values) * share;
  // The misfit counts where it is beyond what chance leaves: two standard deviations of a mean of
  // squares.
  const double chance = 1.0 + 2.0 * std::sqrt(2.0 * inflation / std::max(freedom, 1.0));
  const double misfit = ratio > chance ? (ratio - 1.0) * inflation : 0.0;
  result.covariance = bread * (noise + misfit * as_noise + known) * bread;
  return result;
}

}  // namespace osteomill::identify
