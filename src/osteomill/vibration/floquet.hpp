// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <complex>
#include <functional>
#include <vector>

namespace osteomill::vibration {

/// A linear periodic equation with one delay that equals its period, one period long, in steps:
///   y_{i+1} = P_i y_i + G_i d_{i−m} + H_i d_{i−m+1},  d = C y,  i = 0 … m − 1.
/// Semi-discretisation and full discretisation both end in this form. Its state is y with the m
/// outputs before it; one application advances it by the delay.
struct DelayMap {
  int states = 0;
  int outputs = 0;
  int steps = 0;
  Eigen::MatrixXd output;  ///< C
  /// [P | G | H] of each step, column by column.
  std::vector<double> matrices;

  int dimension() const { return states + steps * outputs; }
  std::size_t stride() const {
    return static_cast<std::size_t>(states) * static_cast<std::size_t>(states + 2 * outputs);
  }
  /// `from` and `to` hold y, then d of the m instants before it, the oldest first.
  void apply(const double* from, double* to) const;
};

/// ẏ = A(t) y + B(t) d(t − T): mean coefficients over step i of m.
struct DelayCoefficients {
  Eigen::MatrixXd a;
  Eigen::MatrixXd b;
};

/// First-order semi-discretisation, [insperger2004]: coefficients at their mean over each step, the
/// delayed term linear between its samples, each step solved exactly. Second order in the step.
DelayMap semi_discretise(double period, int steps, const Eigen::MatrixXd& output,
                         const std::function<DelayCoefficients(int step)>& coefficients);

/// The Floquet multiplier of the largest modulus: the cut is stable when it is below 1.
struct Multiplier {
  std::complex<double> value;
  int iterations = 0;  ///< applications of the map
};

/// By Arnoldi's method from a fixed start vector, to `tolerance` in the modulus.
Multiplier dominant_multiplier(const DelayMap& map, double tolerance = 1e-8);

/// The same from all eigenvalues of the whole matrix: slow, the reference of the tests.
Multiplier dominant_multiplier_dense(const DelayMap& map);

/// The eigenvector's outputs over one period, d_0 … d_{m−1}, for the dominant multiplier.
Eigen::MatrixXcd dominant_motion(const DelayMap& map, std::complex<double> multiplier);

}  // namespace osteomill::vibration
