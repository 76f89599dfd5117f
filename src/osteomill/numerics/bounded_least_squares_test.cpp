// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/bounded_least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace osteomill::numerics {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// NIST StRD "Misra1a" (lower difficulty): y = b1 (1 - exp(-b2 x)). Certified values.
TEST(BoundedLeastSquares, GivesTheCertifiedValuesOfMisra1a) {
  const VectorXd x{{77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8,
                    593.1, 689.1, 760.0}};
  const VectorXd y{{10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01,
                    66.40, 75.47, 81.78}};
  LeastSquaresProblem problem;
  problem.residual = [&](const VectorXd& b) -> VectorXd {
    return b(0) * (1.0 - (-b(1) * x.array()).exp()) - y.array();
  };
  for (const VectorXd& start : {VectorXd{{500.0, 1e-4}}, VectorXd{{250.0, 5e-4}}}) {
    const LeastSquaresSummary fit = solve_least_squares(problem, start);
    EXPECT_TRUE(fit.converged);
    // Derivatives by differences leave some eight digits.
    EXPECT_NEAR(fit.x(0), 2.3894212918e+02, 2e-5);
    EXPECT_NEAR(fit.x(1), 5.5015643181e-04, 5e-11);
    EXPECT_NEAR(fit.residual.squaredNorm(), 1.2455138894e-01, 1e-11);
  }
}

TEST(BoundedLeastSquares, HoldsAVariableAtItsBoundOnlyWhenTheBoundHoldsItBack) {
  const MatrixXd a{{1.0, 1.0}, {1.0, 2.0}, {1.0, 3.0}};
  const VectorXd y{{1.0, 0.0, -2.0}};  // slope -1.5 without bounds
  LeastSquaresProblem problem;
  problem.residual = [&](const VectorXd& x) -> VectorXd { return a * x - y; };
  problem.jacobian = [&](const VectorXd&) -> MatrixXd { return a; };
  problem.lower = VectorXd{{-10.0, 0.0}};
  problem.upper = VectorXd{{10.0, 10.0}};
  const LeastSquaresSummary fit = solve_least_squares(problem, VectorXd{{-10.0, 5.0}});
  EXPECT_TRUE(fit.converged);
  EXPECT_FALSE(fit.at_bound[0]);
  EXPECT_TRUE(fit.at_bound[1]);
  // With the slope held at 0 the other is the mean.
  EXPECT_NEAR(fit.x(0), -1.0 / 3.0, 1e-9);
  EXPECT_EQ(fit.x(1), 0.0);
  problem.lower(1) = -10.0;
  const LeastSquaresSummary loose = solve_least_squares(problem, VectorXd{{0.0, -10.0}});
  EXPECT_NEAR(loose.x(1), -1.5, 1e-9);
  EXPECT_FALSE(loose.at_bound[1]);
}

}  // namespace
}  // namespace osteomill::numerics
