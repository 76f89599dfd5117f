// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/quadrature.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace osteomill::numerics {
namespace {

double integral(const QuadratureRule& rule, auto f) {
  double sum = 0.0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) sum += rule.weights[i] * f(rule.nodes[i]);
  return sum;
}

TEST(GaussLegendre, IsExactForPolynomialsUpToTwiceItsNodesLessOne) {
  for (const int n : {1, 2, 3, 4, 7, 16, 24}) {
    const QuadratureRule rule = gauss_legendre(n);
    ASSERT_EQ(rule.nodes.size(), static_cast<std::size_t>(n));
    for (int degree = 0; degree < 2 * n; ++degree) {
      // Rounding of the nodes: a few ulp.
      EXPECT_NEAR(integral(rule, [&](double x) { return std::pow(x, degree); }), 1.0 / (degree + 1),
                  1e-14);
    }
  }
}

TEST(GaussLegendreGathered, ResolvesAnInfiniteSlopeAtBothEnds) {
  const auto root = [](double x) { return std::pow(x * (1.0 - x), 0.3); };
  const double exact = std::tgamma(1.3) * std::tgamma(1.3) / std::tgamma(2.6);
  const double plain = std::abs(integral(gauss_legendre(24), root) - exact);
  const double gathered = std::abs(integral(gauss_legendre_gathered(24), root) - exact);
  EXPECT_LT(gathered, 1e-6 * exact);
  EXPECT_LT(gathered, 0.01 * plain);
}

}  // namespace
}  // namespace osteomill::numerics
