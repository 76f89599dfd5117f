// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/distributions.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace osteomill::numerics {
namespace {

// Closed forms: t with 1 and 2 degrees of freedom, chi squared with 2, F with (2, n).
TEST(Distributions, MeetTheirClosedForms) {
  // Boost promises a few units in the last place; 1e-13 leaves room for the closed forms' own.
  for (const double t : {-2.5, -0.3, 0.0, 0.8, 6.0}) {
    EXPECT_NEAR(student_t_cdf(t, 1.0), 0.5 + std::atan(t) / M_PI, 1e-13);
    EXPECT_NEAR(student_t_cdf(t, 2.0), 0.5 + t / (2.0 * std::sqrt(2.0 + t * t)), 1e-13);
    EXPECT_NEAR(normal_cdf(t), 0.5 * std::erfc(-t / std::sqrt(2.0)), 1e-13);
  }
  for (const double x : {0.1, 1.0, 5.0, 30.0}) {
    EXPECT_NEAR(chi_squared_upper_tail(x, 2.0), std::exp(-0.5 * x), 1e-13);
    EXPECT_NEAR(f_upper_tail(x, 2.0, 7.0), std::pow(1.0 + 2.0 * x / 7.0, -3.5), 1e-13);
  }
}

TEST(Distributions, QuantilesInvertTheirDistributions) {
  for (const double p : {0.025, 0.3, 0.975}) {
    EXPECT_NEAR(normal_cdf(normal_quantile(p)), p, 1e-12);
    EXPECT_NEAR(student_t_cdf(student_t_quantile(p, 7.3), 7.3), p, 1e-12);
    EXPECT_NEAR(chi_squared_cdf(chi_squared_quantile(p, 12.5), 12.5), p, 1e-12);
    EXPECT_NEAR(f_cdf(f_quantile(p, 3.0, 9.5), 3.0, 9.5), p, 1e-12);
  }
}

TEST(Distributions, NoncentralOnesBecomeCentralWithoutNoncentralityAndAgreeWithEachOther) {
  EXPECT_NEAR(noncentral_t_cdf(1.7, 9.0, 0.0), student_t_cdf(1.7, 9.0), 1e-12);
  EXPECT_NEAR(noncentral_f_cdf(2.7, 3.0, 9.0, 0.0), f_cdf(2.7, 3.0, 9.0), 1e-12);
  // t squared with noncentrality d is F(1, n) with noncentrality d squared.
  const double t = 2.2, d = 1.3, n = 11.0;
  EXPECT_NEAR(noncentral_t_cdf(t, n, d) - noncentral_t_cdf(-t, n, d),
              noncentral_f_cdf(t * t, 1.0, n, d * d), 1e-10);
}

}  // namespace
}  // namespace osteomill::numerics
