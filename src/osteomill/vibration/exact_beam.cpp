// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/exact_beam.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::vibration {
namespace {

struct Piece {
  double begin;
  double length;
  Section section;
  double kappa;  ///< wave number at the frequency in hand
};

double wave_number(const Section& section, double omega) {
  return std::sqrt(omega * std::sqrt(section.mass_per_length / section.bending_stiffness));
}

/// Pieces so short that κL <= 2.5: a piece clamped at both ends has its first natural frequency at
/// κL = 4.73, so the dynamic stiffness has no poles and negative pivots alone count the modes.
std::vector<Piece> pieces_at(const Beam& beam, double omega) {
  std::vector<Piece> pieces;
  const std::vector<double> places = stations(beam);
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    const double gap = places[i + 1] - places[i];
    const Section s = section_at(beam, places[i]);
    const double kappa = wave_number(s, omega);
    const int parts = std::max(2, static_cast<int>(std::ceil(kappa * gap / 2.5)));
    for (int k = 0; k < parts; ++k) {
      pieces.push_back({places[i] + gap * k / parts, gap / parts, s, kappa});
    }
  }
  return pieces;
}

/// Exact dynamic stiffness of one piece for (w₁, θ₁, w₂, θ₂); the static one in the limit.
Eigen::Matrix4d piece_stiffness(const Piece& piece) {
  const double l = piece.length;
  const double lambda = piece.kappa * l;
  double k11, k12, k13, k14, k22, k24;
  if (lambda < 0.05) {
    // Below this the closed form loses digits; static terms plus the consistent mass leave an
    // error of order λ⁸/10⁴ < 1e-14.
    const double q = std::pow(lambda, 4) / 420.0;
    k11 = 12.0 - 156.0 * q;
    k12 = 6.0 - 22.0 * q;
    k13 = -12.0 - 54.0 * q;
    k14 = 6.0 + 13.0 * q;
    k22 = 4.0 - 4.0 * q;
    k24 = 2.0 + 3.0 * q;
  } else {
    const double s = std::sin(lambda), c = std::cos(lambda);
    const double sh = std::sinh(lambda), ch = std::cosh(lambda);
    const double d = 1.0 - c * ch;
    k11 = std::pow(lambda, 3) * (s * ch + c * sh) / d;
    k12 = lambda * lambda * s * sh / d;
    k13 = -std::pow(lambda, 3) * (s + sh) / d;
    k14 = lambda * lambda * (ch - c) / d;
    k22 = lambda * (s * ch - c * sh) / d;
    k24 = lambda * (sh - s) / d;
  }
  Eigen::Matrix4d k;
  k << k11, k12 * l, k13, k14 * l,                  //
      k12 * l, k22 * l * l, -k14 * l, k24 * l * l,  //
      k13, -k14 * l, k11, -k12 * l,                 //
      k14 * l, k24 * l * l, -k12 * l, k22 * l * l;
  return k * (piece.section.bending_stiffness / (l * l * l));
}

struct System {
  std::vector<Piece> pieces;
  Eigen::MatrixXd stiffness;  ///< of the free freedoms
  std::vector<int> index;     ///< freedom (2 node + rotation) → row, -1 when held
};

System assemble(const Beam& beam, double omega) {
  System system;
  system.pieces = pieces_at(beam, omega);
  const int nodes = static_cast<int>(system.pieces.size()) + 1;
  std::vector<bool> held(2 * nodes, false);
  Eigen::VectorXd spring = Eigen::VectorXd::Zero(2 * nodes);
  const double end = length(beam);
  for (const Support& support : beam.supports) {
    int nearest = nodes - 1;
    double distance = std::abs(support.position - end);
    for (int i = 0; i < nodes - 1; ++i) {
      const double gap = std::abs(support.position - system.pieces[i].begin);
      if (gap < distance) {
        distance = gap;
        nearest = i;
      }
    }
    if (support.type != SupportType::spring) held[2 * nearest] = true;
    if (support.type == SupportType::clamp) held[2 * nearest + 1] = true;
    if (support.type == SupportType::spring) {
      spring[2 * nearest] += support.stiffness;
      spring[2 * nearest + 1] += support.rotational_stiffness;
    }
  }
  system.index.assign(2 * nodes, -1);
  int rows = 0;
  for (int i = 0; i < 2 * nodes; ++i) {
    if (!held[i]) system.index[i] = rows++;
  }
  system.stiffness = Eigen::MatrixXd::Zero(rows, rows);
  for (std::size_t p = 0; p < system.pieces.size(); ++p) {
    const Eigen::Matrix4d k = piece_stiffness(system.pieces[p]);
    for (int a = 0; a < 4; ++a) {
      const int row = system.index[2 * p + a];
      for (int b = 0; b < 4 && row >= 0; ++b) {
        const int column = system.index[2 * p + b];
        if (column >= 0) system.stiffness(row, column) += k(a, b);
      }
    }
  }
  for (int i = 0; i < 2 * nodes; ++i) {
    if (system.index[i] >= 0) system.stiffness(system.index[i], system.index[i]) += spring[i];
  }
  return system;
}

/// Negative pivots of unpivoted elimination: the Sturm count of [wittrick1971]. The matrix is
/// banded (a node meets its neighbours only), so three rows below the pivot suffice.
int modes_below(const Beam& beam, double omega) {
  Eigen::MatrixXd k = assemble(beam, omega).stiffness;
  const Eigen::Index n = k.rows();
  int negative = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double pivot = k(i, i);
    if (pivot < 0.0) ++negative;
    const Eigen::Index last = std::min(n - 1, i + 3);
    for (Eigen::Index row = i + 1; row <= last; ++row) {
      const double factor = k(row, i) / pivot;
      for (Eigen::Index column = i + 1; column <= last; ++column) {
        k(row, column) -= factor * k(i, column);
      }
    }
  }
  return negative;
}

}  // namespace

std::vector<double> exact_natural_frequencies(const Beam& beam, int count) {
  check(beam);
  require_within("options.modes", count, 1.0, 100.0, "");
  // A first guess of the scale: the first mode of a clamped shaft of the whole length.
  const Section first = section_at(beam, 0.0);
  double high = 3.516 * std::sqrt(first.bending_stiffness / first.mass_per_length) /
                (length(beam) * length(beam));
  while (modes_below(beam, high) < count) high *= 2.0;
  std::vector<double> frequencies;
  for (int mode = 1; mode <= count; ++mode) {
    double low = 0.0, top = high;
    while (top - low > 1e-13 * top) {
      const double middle = 0.5 * (low + top);
      if (middle <= low || middle >= top) break;
      (modes_below(beam, middle) >= mode ? top : low) = middle;
    }
    frequencies.push_back(0.5 * (low + top) / (2.0 * std::numbers::pi));
  }
  return frequencies;
}

std::vector<double> exact_mode_shape(const Beam& beam, double natural_frequency_hz,
                                     const std::vector<double>& positions) {
  check(beam);
  require_positive("natural_frequency_hz", natural_frequency_hz, "Hz");
  const System system = assemble(beam, 2.0 * std::numbers::pi * natural_frequency_hz);
  const Eigen::PartialPivLU<Eigen::MatrixXd> inverse(system.stiffness);
  // Inverse iteration: the matrix is singular to rounding, two steps align with its null vector.
  Eigen::VectorXd v = Eigen::VectorXd::LinSpaced(system.stiffness.rows(), 1.0, 2.0);
  for (int i = 0; i < 3; ++i) v = inverse.solve(v).normalized();

  std::vector<double> shape;
  double largest = 0.0;
  for (const double x : positions) {
    std::size_t p = 0;
    while (p + 1 < system.pieces.size() && x >= system.pieces[p + 1].begin) ++p;
    const Piece& piece = system.pieces[p];
    Eigen::Vector4d ends;
    for (int a = 0; a < 4; ++a) {
      const int row = system.index[2 * p + a];
      ends[a] = row >= 0 ? v[row] : 0.0;
    }
    const double k = piece.kappa, l = piece.length;
    const auto row = [k](double s) {
      return Eigen::RowVector4d(std::cos(k * s), std::sin(k * s), std::cosh(k * s),
                                std::sinh(k * s));
    };
    const auto slope = [k](double s) {
      return Eigen::RowVector4d(-k * std::sin(k * s), k * std::cos(k * s), k * std::sinh(k * s),
                                k * std::cosh(k * s));
    };
    Eigen::Matrix4d conditions;
    conditions << row(0.0), slope(0.0), row(l), slope(l);
    const double value =
        row(x - piece.begin).dot(conditions.partialPivLu().solve(ends).transpose());
    shape.push_back(value);
    if (std::abs(value) > std::abs(largest)) largest = value;
  }
  if (largest != 0.0) {
    for (double& value : shape) value /= largest;
  }
  return shape;
}

double exact_tip_receptance(const Beam& beam, double frequency_hz) {
  check(beam);
  require_non_negative("frequency_hz", frequency_hz, "Hz");
  const System system = assemble(beam, 2.0 * std::numbers::pi * frequency_hz);
  const int tip = system.index[system.index.size() - 2];
  if (tip < 0) return 0.0;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(system.stiffness.rows());
  force[tip] = 1.0;
  return system.stiffness.partialPivLu().solve(force)[tip];
}

double clamp_pin_determinant(double kappa, double supported_length, double free_length) {
  const double a = kappa * supported_length, b = kappa * free_length;
  const double ca = std::cos(a), sa = std::sin(a), cha = std::cosh(a), sha = std::sinh(a);
  const double cb = std::cos(b), sb = std::sin(b), chb = std::cosh(b), shb = std::sinh(b);
  Eigen::Matrix<double, 5, 5> m;
  m << ca - cha, sa - sha, 0.0, 0.0, 0.0,         //
      -sa - sha, ca - cha, 0.0, -2.0, 0.0,        //
      -ca - cha, -sa - sha, 2.0, 0.0, 0.0,        //
      0.0, 0.0, -cb - chb, -sb + shb, -sb - shb,  //
      0.0, 0.0, sb - shb, -cb + chb, -cb - chb;
  return m.determinant();
}

}  // namespace osteomill::vibration
