// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace osteomill::numerics {

/// Minimise |residual(x)|² / 2 within lower <= x <= upper.
struct LeastSquaresProblem {
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residual;
  /// Rows as the residual; empty: central differences.
  std::function<Eigen::MatrixXd(const Eigen::VectorXd&)> jacobian = {};
  Eigen::VectorXd lower = {};  ///< empty: no bounds
  Eigen::VectorXd upper = {};
};

struct LeastSquaresOptions {
  int most_iterations = 300;
  /// Done when a step changes no variable by more than this share of its size.
  double tolerance = 1e-11;
};

struct LeastSquaresSummary {
  Eigen::VectorXd x;
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
  std::vector<bool> at_bound;  ///< the bound holds the variable back
  int iterations = 0;
  bool converged = false;
};

/// Levenberg–Marquardt with scaled damping (Marquardt 1963, Moré 1978), on the variables that no
/// bound holds back, steps clipped to the bounds. Ours because Eigen's has no bounds and Debian's
/// Ceres brings GPL libraries; meant for some ten variables. `start` is clipped to the bounds.
LeastSquaresSummary solve_least_squares(const LeastSquaresProblem& problem,
                                        const Eigen::VectorXd& start,
                                        const LeastSquaresOptions& options = {});

/// Derivatives by central differences: error of third order in a step of 6e-6 of each variable.
Eigen::MatrixXd central_differences(
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& function,
    const Eigen::VectorXd& x);

}  // namespace osteomill::numerics
