// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/floquet.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/vibration/exponential.hpp"

namespace osteomill::vibration {
namespace {

/// S states and O outputs known to the compiler, so that the inner loops are straight code.
template <int S, int O>
void apply_fixed(const DelayMap& map, const double* from, double* to) {
  constexpr int columns = S + 2 * O;
  double y[S], c[O * S];
  std::copy_n(from, S, y);
  std::copy_n(map.output.data(), O * S, c);
  const double* history = from + S;
  const double* step = map.matrices.data();
  for (int i = 0; i < map.steps; ++i, step += S * columns) {
    double* out = to + S + i * O;
    for (int o = 0; o < O; ++o) {
      double sum = 0.0;
      for (int s = 0; s < S; ++s) sum += c[s * O + o] * y[s];
      out[o] = sum;
    }
    const double* before = history + i * O;
    // The last step's newer sample is the state's own output, d_0.
    const double* after = i + 1 < map.steps ? before + O : to + S;
    double next[S] = {};
    for (int k = 0; k < S; ++k) {
      for (int s = 0; s < S; ++s) next[s] += step[k * S + s] * y[k];
    }
    for (int o = 0; o < O; ++o) {
      for (int s = 0; s < S; ++s) {
        next[s] += step[(S + o) * S + s] * before[o] + step[(S + O + o) * S + s] * after[o];
      }
    }
    std::copy_n(next, S, y);
  }
  std::copy_n(y, S, to);
}

void apply_any(const DelayMap& map, const double* from, double* to) {
  const Eigen::Index s = map.states, o = map.outputs;
  Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(from, s);
  for (int i = 0; i < map.steps; ++i) {
    Eigen::Map<Eigen::VectorXd>(to + s + i * o, o).noalias() = map.output * y;
    const double* before = from + s + i * o;
    const double* after = i + 1 < map.steps ? before + o : to + s;
    const double* step = map.matrices.data() + map.stride() * static_cast<std::size_t>(i);
    Eigen::VectorXd next = Eigen::Map<const Eigen::MatrixXd>(step, s, s) * y;
    next.noalias() += Eigen::Map<const Eigen::MatrixXd>(step + s * s, s, o) *
                      Eigen::Map<const Eigen::VectorXd>(before, o);
    next.noalias() += Eigen::Map<const Eigen::MatrixXd>(step + s * (s + o), s, o) *
                      Eigen::Map<const Eigen::VectorXd>(after, o);
    y.swap(next);
  }
  std::copy_n(y.data(), s, to);
}

Eigen::MatrixXd whole_matrix(const DelayMap& map) {
  const Eigen::Index n = map.dimension();
  Eigen::MatrixXd matrix(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(n, k);
    map.apply(unit.data(), matrix.col(k).data());
  }
  return matrix;
}

std::complex<double> largest(const Eigen::VectorXcd& values) {
  // Of a conjugate pair the one with positive imaginary part, so that the answer is unique.
  std::complex<double> best = 0.0;
  for (const std::complex<double>& value : values) {
    if (std::abs(value) > std::abs(best) * (1.0 + 1e-12)) best = value;
  }
  return {best.real(), std::abs(best.imag())};
}

}  // namespace

void DelayMap::apply(const double* from, double* to) const {
  if (states == 2 && outputs == 1) return apply_fixed<2, 1>(*this, from, to);
  if (states == 4 && outputs == 1) return apply_fixed<4, 1>(*this, from, to);
  if (states == 4 && outputs == 2) return apply_fixed<4, 2>(*this, from, to);
  if (states == 8 && outputs == 2) return apply_fixed<8, 2>(*this, from, to);
  apply_any(*this, from, to);
}

DelayMap semi_discretise(double period, int steps, const Eigen::MatrixXd& output,
                         const std::function<DelayCoefficients(int step)>& coefficients) {
  require_positive("period", period, "s");
  require_within("options.steps", steps, 2.0, 100000.0, "");
  DelayMap map;
  map.states = static_cast<int>(output.cols());
  map.outputs = static_cast<int>(output.rows());
  map.steps = steps;
  map.output = output;
  map.matrices.resize(map.stride() * static_cast<std::size_t>(steps));
  const double h = period / steps;
  for (int i = 0; i < steps; ++i) {
    const DelayCoefficients c = coefficients(i);
    const Eigen::MatrixXd z = c.a * h;
    const ExponentialFunctions<Eigen::MatrixXd> f = exponential_functions(z);
    double* step = map.matrices.data() + map.stride() * static_cast<std::size_t>(i);
    const Eigen::Index s = map.states, o = map.outputs;
    Eigen::Map<Eigen::MatrixXd>(step, s, s) = f.phi_0;
    Eigen::Map<Eigen::MatrixXd>(step + s * s, s, o) = h * (f.phi_1 - f.phi_2) * c.b;
    Eigen::Map<Eigen::MatrixXd>(step + s * (s + o), s, o) = h * f.phi_2 * c.b;
  }
  return map;
}

Multiplier dominant_multiplier(const DelayMap& map, double tolerance) {
  const int n = map.dimension();
  const int most = std::min(n, 80);
  std::vector<double> basis(static_cast<std::size_t>(n) * static_cast<std::size_t>(most + 1));
  const auto column = [&](int k) {
    return Eigen::Map<Eigen::VectorXd>(basis.data() + static_cast<std::ptrdiff_t>(k) * n, n);
  };
  Eigen::MatrixXd hessenberg = Eigen::MatrixXd::Zero(most + 1, most);
  // A start vector with every frequency in it, always the same.
  for (int i = 0; i < n; ++i) column(0)[i] = 1.0 / (1.0 + 0.37 * ((i * 7) % 23)) - 0.2;
  column(0).normalize();
  double previous = -1.0;
  int next_look = 8;
  Eigen::EigenSolver<Eigen::MatrixXd> solver;
  for (int k = 0; k < most; ++k) {
    map.apply(column(k).data(), column(k + 1).data());
    const double before = column(k + 1).norm();
    for (int pass = 0; pass < 2; ++pass) {
      for (int i = 0; i <= k; ++i) {
        const double share = column(i).dot(column(k + 1));
        hessenberg(i, k) += share;
        column(k + 1) -= share * column(i);
      }
      // A second pass only when the first one cancelled digits.
      if (column(k + 1).norm() > 0.7 * before) break;
    }
    const double rest = column(k + 1).norm();
    const bool closed = rest <= 1e-14 * before;
    if (k + 1 == next_look || closed || k + 1 == most) {
      solver.compute(hessenberg.topLeftCorner(k + 1, k + 1), false);
      const std::complex<double> value = largest(solver.eigenvalues());
      const double modulus = std::abs(value);
      if (!std::isfinite(modulus)) throw NoSolution("the Floquet multiplier is not finite");
      if (closed || std::abs(modulus - previous) <= tolerance * std::max(modulus, 1e-3)) {
        return {value, k + 1};
      }
      previous = modulus;
      next_look += k < 20 ? 4 : 10;
    }
    hessenberg(k + 1, k) = rest;
    column(k + 1) /= rest;
  }
  return dominant_multiplier_dense(map);
}

Multiplier dominant_multiplier_dense(const DelayMap& map) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(whole_matrix(map), false);
  return {largest(solver.eigenvalues()), map.dimension()};
}

Eigen::MatrixXcd dominant_motion(const DelayMap& map, std::complex<double> multiplier) {
  // Inverse iteration with a shift off the multiplier by 1e-7: two steps suffice.
  const Eigen::Index n = map.dimension();
  Eigen::MatrixXcd shifted = whole_matrix(map).cast<std::complex<double>>();
  shifted.diagonal().array() -= multiplier * (1.0 + 1e-7);
  const Eigen::PartialPivLU<Eigen::MatrixXcd> inverse(shifted);
  Eigen::VectorXcd v = Eigen::VectorXcd::Ones(n);
  for (int i = 0; i < 3; ++i) v = inverse.solve(v).normalized();
  // The history of the eigenvector is one period of it; divide by nothing: scale is free.
  return Eigen::Map<const Eigen::MatrixXcd>(v.data() + map.states, map.outputs, map.steps);
}

}  // namespace osteomill::vibration
