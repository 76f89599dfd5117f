// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace osteomill::numerics {

/// Nodes and weights on [0, 1]: integral of f over [a, b] = (b - a) sum weight f(a + (b - a) node).
struct QuadratureRule {
  std::vector<double> nodes;
  std::vector<double> weights;
};

/// Gauss-Legendre with n >= 1 nodes: exact for polynomials up to degree 2n - 1.
QuadratureRule gauss_legendre(int n);

/// Gauss-Legendre after x = 3u² - 2u³, which gathers the nodes at both ends: for integrands whose
/// slope is infinite there, such as a power of the chip thickness at entry and exit.
QuadratureRule gauss_legendre_gathered(int n);

}  // namespace osteomill::numerics
