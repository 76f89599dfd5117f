// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/bounded_least_squares.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace osteomill::numerics {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd clipped(const LeastSquaresProblem& problem, VectorXd x) {
  if (problem.lower.size() == x.size()) x = x.cwiseMax(problem.lower);
  if (problem.upper.size() == x.size()) x = x.cwiseMin(problem.upper);
  return x;
}

/// Variables at a bound that the descent direction would push beyond it.
std::vector<bool> held(const LeastSquaresProblem& problem, const VectorXd& x,
                       const VectorXd& gradient) {
  std::vector<bool> result(static_cast<std::size_t>(x.size()), false);
  for (Index i = 0; i < x.size(); ++i) {
    const bool low = problem.lower.size() == x.size() && x(i) <= problem.lower(i);
    const bool high = problem.upper.size() == x.size() && x(i) >= problem.upper(i);
    result[static_cast<std::size_t>(i)] =
        (low && gradient(i) >= 0.0) || (high && gradient(i) <= 0.0);
  }
  return result;
}

/// Damped Gauss-Newton step of the variables that are free, 0 for the others.
VectorXd step_of(const MatrixXd& jacobian, const VectorXd& gradient, const std::vector<bool>& fixed,
                 double damping) {
  MatrixXd normal = jacobian.transpose() * jacobian;
  VectorXd right = -gradient;
  for (Index i = 0; i < normal.rows(); ++i) {
    // Marquardt's scaling; a variable without any effect stays where it is.
    normal(i, i) += damping * normal(i, i);
    if (fixed[static_cast<std::size_t>(i)] || normal(i, i) == 0.0) {
      normal.row(i).setZero();
      normal.col(i).setZero();
      normal(i, i) = 1.0;
      right(i) = 0.0;
    }
  }
  const VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  return scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * right);
}

}  // namespace

MatrixXd central_differences(const std::function<VectorXd(const VectorXd&)>& function,
                             const VectorXd& x) {
  MatrixXd jacobian;
  for (Index i = 0; i < x.size(); ++i) {
    const double step = 6e-6 * std::max(1e-3, std::abs(x(i)));
    VectorXd ahead = x, behind = x;
    ahead(i) += step;
    behind(i) -= step;
    const VectorXd slope = (function(ahead) - function(behind)) / (ahead(i) - behind(i));
    if (i == 0) jacobian.resize(slope.size(), x.size());
    jacobian.col(i) = slope;
  }
  return jacobian;
}

LeastSquaresSummary solve_least_squares(const LeastSquaresProblem& problem, const VectorXd& start,
                                        const LeastSquaresOptions& options) {
  const auto derivative = [&](const VectorXd& x) {
    return problem.jacobian ? problem.jacobian(x) : central_differences(problem.residual, x);
  };
  LeastSquaresSummary result;
  result.x = clipped(problem, start);
  result.residual = problem.residual(result.x);
  double damping = 1e-3;
  constexpr double kMostDamping = 1e16;
  while (result.iterations < options.most_iterations && !result.converged) {
    result.jacobian = derivative(result.x);
    const VectorXd gradient = result.jacobian.transpose() * result.residual;
    result.at_bound = held(problem, result.x, gradient);
    bool better = false;
    while (!better && !result.converged) {
      const VectorXd next =
          clipped(problem, result.x + step_of(result.jacobian, gradient, result.at_bound, damping));
      const VectorXd residual = problem.residual(next);
      const VectorXd size = result.x.cwiseAbs().cwiseMax(next.cwiseAbs());
      result.converged =
          ((next - result.x).cwiseAbs().array() <= options.tolerance * size.array()).all();
      better = residual.allFinite() && residual.squaredNorm() < result.residual.squaredNorm();
      if (better) {
        // A small step that gains nothing more in double precision.
        const double gain = result.residual.squaredNorm() - residual.squaredNorm();
        const bool small =
            ((next - result.x).cwiseAbs().array() <= 1e4 * options.tolerance * size.array()).all();
        if (small && gain <= 1e-14 * result.residual.squaredNorm()) result.converged = true;
        result.x = next;
        result.residual = residual;
        damping = std::max(1e-15, 0.1 * damping);
      } else if (damping >= kMostDamping) {
        result.converged = true;  // no descent is left at this precision
      } else {
        damping = std::max(10.0 * damping, 1e-12);
      }
    }
    ++result.iterations;
  }
  result.jacobian = derivative(result.x);
  result.at_bound = held(problem, result.x, result.jacobian.transpose() * result.residual);
  return result;
}

}  // namespace osteomill::numerics
