// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/quadrature.hpp"

#include <boost/math/special_functions/legendre.hpp>

namespace osteomill::numerics {

QuadratureRule gauss_legendre(int n) {
  const std::vector<double> zeros = boost::math::legendre_p_zeros<double>(n);  // those >= 0
  QuadratureRule rule;
  const auto add = [&](double x) {
    const double slope = boost::math::legendre_p_prime(n, x);
    rule.nodes.push_back(0.5 * (1.0 + x));
    rule.weights.push_back(1.0 / ((1.0 - x * x) * slope * slope));
  };
  for (auto x = zeros.rbegin(); x != zeros.rend(); ++x) {
    if (*x > 0.0) add(-*x);
  }
  for (const double x : zeros) add(x);
  return rule;
}

QuadratureRule gauss_legendre_gathered(int n) {
  QuadratureRule rule = gauss_legendre(n);
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    const double u = rule.nodes[i];
    rule.nodes[i] = u * u * (3.0 - 2.0 * u);
    rule.weights[i] *= 6.0 * u * (1.0 - u);
  }
  return rule;
}

}  // namespace osteomill::numerics
