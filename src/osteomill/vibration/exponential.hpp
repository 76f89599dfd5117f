// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace osteomill::vibration {

/// φ₀ = e^Z, φ₁ = (e^Z − 1)/Z, φ₂ = (φ₁ − 1)/Z: what an exact step of ẏ = A y + b₀ + b₁ t needs.
template <class Matrix>
struct ExponentialFunctions {
  Matrix phi_0, phi_1, phi_2;
};

/// Taylor series of φ₂ for a norm up to 1, then doubling; to machine precision.
template <class Matrix>
ExponentialFunctions<Matrix> exponential_functions(Matrix z) {
  const double norm = z.cwiseAbs().colwise().sum().maxCoeff();
  const int doublings = norm > 1.0 ? static_cast<int>(std::ceil(std::log2(norm))) : 0;
  if (doublings > 0) z *= std::ldexp(1.0, -doublings);
  // norm^k/(k+2)! < 1e-16 for k = 15 at norm 1; fewer terms for smaller ones.
  const double size = std::ldexp(norm, -doublings);
  int terms = 3;
  double term = std::pow(size, 3) / 120.0;
  while (term > 1e-17 && terms < 18) {
    ++terms;
    term *= size / (terms + 2);
  }
  const Matrix one = Matrix::Identity(z.rows(), z.cols());
  Matrix sum = one;
  for (int k = terms; k >= 1; --k) {
    // φ₂ = 1/2 (1 + Z/3 (1 + Z/4 (1 + …)))
    Matrix product;
    product.noalias() = z * sum;
    sum = one + product / (k + 2.0);
  }
  ExponentialFunctions<Matrix> f;
  f.phi_2 = 0.5 * sum;
  f.phi_1 = one;
  f.phi_1.noalias() += z * f.phi_2;
  f.phi_0 = one;
  f.phi_0.noalias() += z * f.phi_1;
  for (int i = 0; i < doublings; ++i) {
    Matrix phi_2 = f.phi_1 + f.phi_2;
    phi_2.noalias() += f.phi_0 * f.phi_2;
    Matrix phi_1 = f.phi_1;
    phi_1.noalias() += f.phi_0 * f.phi_1;
    Matrix phi_0;
    phi_0.noalias() = f.phi_0 * f.phi_0;
    f.phi_2 = 0.25 * phi_2;
    f.phi_1 = 0.5 * phi_1;
    f.phi_0 = phi_0;
  }
  return f;
}

}  // namespace osteomill::vibration
