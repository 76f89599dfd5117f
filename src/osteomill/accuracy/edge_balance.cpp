// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/edge_balance.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace osteomill::accuracy {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kTurn = 2.0 * std::numbers::pi;
// Forces grow with the chip to the power of a third or more; in the chip's cube root they have no
// infinite slope where the chip begins.
constexpr double kRoot = 3.0;

}  // namespace

EdgeBalance::EdgeBalance(const ToolCompliance& tool, const cutting::Cutter& cutter,
                         const cutting::CuttingLaw& law, const cutting::Condition& condition,
                         const cutting::Immersion& immersion, int slices)
    : cutter_(cutter),
      law_(law),
      condition_(condition),
      flutes_(cutter),
      slices_(slices),
      dz_(immersion.axial_depth / slices),
      contact_(
          vibration::contact_angles(immersion.kind, 0.5 * immersion.radial_depth / cutter.radius)),
      compliance_(slices, slices) {
  const cutting::Envelope envelope(cutter);
  for (int s = 0; s < slices; ++s) {
    middles_.push_back((s + 0.5) * dz_);
    points_.push_back(envelope.at(middles_.back()));
  }
  for (int s = 0; s < slices; ++s) {
    for (int m = 0; m < slices; ++m) {
      compliance_(s, m) = tool.between(middle(s), middle(m));
    }
  }
}

Turn EdgeBalance::solve(const std::vector<double>& rotations, const Turn& near) const {
  Turn turn = begin(rotations, 1.0);
  evaluate(turn);
  const bool at_once = turn.residual.lpNorm<Eigen::Infinity>() < kBalanced;
  if (!at_once && near.first == turn.first) {
    Turn next = turn;
    next.root = near.root;
    if (newton(next)) return next;
  }
  if (newton(turn)) return turn;
  Turn from = begin(rotations, 0.0);
  if (!newton(from)) return turn;
  double share = 0.0, step = 0.25;
  while (share < 1.0 && step > 0.01) {
    Turn next = begin(rotations, std::min(1.0, share + step));
    next.root = from.root;
    if (newton(next)) {
      share = std::min(1.0, share + step);
      step *= 1.5;
      from = next;
    } else {
      step *= 0.5;
      turn = next;
    }
  }
  return share < 1.0 ? turn : from;
}

/// Disturbances of the chips, a column each, after so many turns.
MatrixXd EdgeBalance::next_turn(const Turn& turn, MatrixXd chips, int turns) const {
  const auto count = static_cast<Index>(turn.rotation.size());
  const auto range = [&](Index m) {
    const auto at = static_cast<std::size_t>(m);
    return std::pair(turn.first[at], turn.first[at + 1] - turn.first[at]);
  };
  std::vector<Eigen::PartialPivLU<MatrixXd>> own;
  for (Index m = 0; m < count; ++m) {
    const auto [at, size] = range(m);
    own.emplace_back(turn.jacobian.block(at, at, size, size));
  }
  for (int i = 0; i < turns; ++i) {
    for (Index m = 0; m < count; ++m) {
      const auto [at, size] = range(m);
      if (size == 0) continue;
      const MatrixXd right = turn.jacobian.block(at, at, size, size) * chips.middleRows(at, size) -
                             turn.jacobian.middleRows(at, size) * chips;
      chips.middleRows(at, size) = own[static_cast<std::size_t>(m)].solve(right);
    }
  }
  return chips;
}

double EdgeBalance::growth(const Turn& turn) const {
  // Without symmetry, so that no mode is left out.
  MatrixXd d(turn.root.size(), 1);
  for (Index i = 0; i < d.size(); ++i) d(i) = std::cos(1.0 + 2.3 * static_cast<double>(i));
  // The first revolutions sort the modes, the geometric mean over the rest is the growth of the
  // largest, also where it is a complex pair.
  constexpr int sorting = 30, counted = 30;
  d = next_turn(turn, d, sorting);
  const double before = d.norm();
  if (!(before > 1e-100)) return 0.0;
  const double after = next_turn(turn, d / before, counted).norm();
  return std::pow(after, 1.0 / counted);
}

double EdgeBalance::exact_growth(const Turn& turn) const {
  const Index size = turn.root.size();
  if (size == 0) return 0.0;
  const Eigen::VectorXcd values = next_turn(turn, MatrixXd::Identity(size, size), 1).eigenvalues();
  return values.cwiseAbs().maxCoeff();
}

EdgeBalance::Stiffness EdgeBalance::stiffness(const Turn& turn, Index m) const {
  const Index at = turn.first[static_cast<std::size_t>(m)];
  const Index size = turn.first[static_cast<std::size_t>(m) + 1] - at;
  MatrixXd z(size, size);
  for (Index i = 0; i < size; ++i) {
    for (Index k = 0; k < size; ++k) {
      z(i, k) = -outward_by(turn, at + i, at + k) / turn.rise[at + k];
    }
  }
  Stiffness result;
  const Eigen::VectorXcd values = z.eigenvalues();
  for (const std::complex<double>& own : values) {
    result.over_tool = std::max(result.over_tool, std::abs(own));
    result.left = std::max(result.left, std::abs(own / (1.0 + own)));
  }
  return result;
}

Eigen::Vector2d EdgeBalance::sum(const Turn& turn, Index m, const VectorXd& influence) const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (Index i = turn.first[static_cast<std::size_t>(m)];
       i < turn.first[static_cast<std::size_t>(m) + 1]; ++i) {
    const double by = influence[turn.edges[static_cast<std::size_t>(i)].slice];
    sum += by * Eigen::Vector2d(turn.force_x[i], turn.force_y[i]);
  }
  return sum;
}

/// The edges in contact, with unequalness of flutes and run-out by `share`, and rigid chips.
Turn EdgeBalance::begin(const std::vector<double>& rotations, double share) const {
  Turn turn;
  turn.rotation = rotations;
  const auto count = static_cast<Index>(rotations.size());
  for (Index m = 0; m < count; ++m) {
    turn.first.push_back(static_cast<Index>(turn.edges.size()));
    for (int s = 0; s < slices_; ++s) {
      for (int j = 0; j < cutter_.flutes; ++j) add_edge(turn, m, s, j, share);
    }
  }
  const auto size = static_cast<Index>(turn.edges.size());
  turn.first.push_back(size);
  turn.meets.resize(static_cast<std::size_t>(size));
  turn.root.resize(size);
  for (Index i = 0; i < size; ++i) {
    const Edge& edge = turn.edges[static_cast<std::size_t>(i)];
    double chip = edge.own_gap;
    for (const Before& b : edge.before) chip = std::min(chip, b.gap);
    const double ratio = chip / condition_.feed_per_tooth;
    turn.root[i] = ratio > 0.0 ? std::pow(ratio, 1.0 / kRoot) : ratio;
  }
  return turn;
}

void EdgeBalance::add_edge(Turn& turn, Index m, int s, int j, double share) const {
  const int flutes = cutter_.flutes;
  const cutting::ProfilePoint& point = points_[static_cast<std::size_t>(s)];
  const auto angle = [&](int flute) {
    return (1.0 - share) * kTurn * flute / flutes + share * flutes_.angle(flute);
  };
  const double turned = turn.rotation[static_cast<std::size_t>(m)] - angle(j) - point.lag;
  double theta = turned - kTurn * std::floor(turned / kTurn);
  // Both ends of the contact count as in it, and there the chip is nothing: as in a rigid cut.
  constexpr double same = 1e-9;
  if (kTurn - theta < same) theta = 0.0;
  if (theta < contact_.entry - same || theta > contact_.exit + same) return;
  const bool at_wall = theta < same || std::abs(theta - std::numbers::pi) < same;
  const double sine = std::sin(theta), cosine = std::cos(theta);
  const double into = at_wall ? 0.0 : std::max(0.0, sine);
  const double feed_a_turn = condition_.feed_per_tooth * flutes;
  Edge edge{.rotation = m,
            .slice = s,
            .sine = sine,
            .cosine = cosine,
            .own_gap = feed_a_turn * into,
            .before = {},
            .t = cutting::motion(theta),
            .normal = cutting::outward_normal(theta, point.kappa)};
  const auto count = static_cast<Index>(turn.rotation.size());
  for (int k = 1; k < flutes; ++k) {
    const int other = (j - k + flutes) % flutes;
    double since = angle(j) - angle(other);
    if (since <= 0.0) since += kTurn;
    const double shift = since / kTurn * static_cast<double>(count);
    const double whole = std::ceil(shift - 1e-9);
    const Index low = ((m - static_cast<Index>(whole)) % count + count) % count;
    edge.before.push_back(
        {.gap = feed_a_turn * since / kTurn * into +
                share * (flutes_.deviation(j, point) - flutes_.deviation(other, point)),
         .low = low,
         .high = (low + 1) % count,
         .share = std::max(0.0, whole - shift)});
  }
  turn.edges.push_back(std::move(edge));
}

bool EdgeBalance::newton(Turn& turn) const {
  evaluate(turn);
  for (int i = 0; i < 40; ++i) {
    if (turn.residual.lpNorm<Eigen::Infinity>() < kBalanced) break;
    assemble(turn);
    const VectorXd change = turn.jacobian.partialPivLu().solve(turn.residual);
    const VectorXd from = turn.root;
    const double norm = turn.residual.norm();
    double share = 1.0;
    do {
      turn.root = from - share * change;
      evaluate(turn);
      share *= 0.5;
    } while (!(turn.residual.norm() < norm) && share > 1e-3);
  }
  assemble(turn);
  return turn.residual.lpNorm<Eigen::Infinity>() < kBalanced;
}

/// Chips, forces and the residual of the turn at its unknowns.
void EdgeBalance::evaluate(Turn& turn) const {
  const auto size = static_cast<Index>(turn.edges.size());
  const Index n = slices_, count = static_cast<Index>(turn.rotation.size());
  for (VectorXd* list :
       {&turn.force_x, &turn.force_y, &turn.slope_x, &turn.slope_y, &turn.rise, &turn.residual}) {
    list->resize(size);
  }
  MatrixXd forces = MatrixXd::Zero(n, 2 * count);
  VectorXd chip(size);
  for (Index i = 0; i < size; ++i) {
    const Edge& edge = turn.edges[static_cast<std::size_t>(i)];
    const double root = turn.root[i], feed = condition_.feed_per_tooth;
    chip[i] = root > 0.0 ? feed * std::pow(root, kRoot) : feed * root;
    turn.rise[i] = root > 0.0 ? kRoot * feed * std::pow(root, kRoot - 1.0) : feed;
    const auto force_at = [&](double h) -> Eigen::Vector2d {
      return dz_ * cutting::edge_force(law_, h, condition_.fibre_T, edge.t, edge.normal,
                                       points_[static_cast<std::size_t>(edge.slice)])
                       .head<2>();
    };
    const Eigen::Vector2d force = force_at(std::max(0.0, chip[i]));
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();
    if (chip[i] > 0.0) {
      const double small = 1e-4 * chip[i];
      slope =
          turn.rise[i] * (force_at(chip[i] + small) - force_at(chip[i] - small)) / (2.0 * small);
    }
    turn.force_x[i] = force.x();
    turn.force_y[i] = force.y();
    turn.slope_x[i] = slope.x();
    turn.slope_y[i] = slope.y();
    forces(edge.slice, 2 * edge.rotation) += force.x();
    forces(edge.slice, 2 * edge.rotation + 1) += force.y();
  }
  const MatrixXd deflection = compliance_ * forces;
  for (Index i = 0; i < size; ++i) {
    const Edge& edge = turn.edges[static_cast<std::size_t>(i)];
    const auto outward = [&](Index rotation) {
      return edge.sine * deflection(edge.slice, 2 * rotation) +
             edge.cosine * deflection(edge.slice, 2 * rotation + 1);
    };
    const double own = outward(edge.rotation);
    double least = edge.own_gap;
    turn.meets[static_cast<std::size_t>(i)] = -1;
    for (std::size_t k = 0; k < edge.before.size(); ++k) {
      const Before& b = edge.before[k];
      const double was = (1.0 - b.share) * outward(b.low) + b.share * outward(b.high);
      if (b.gap + own - was < least) {
        least = b.gap + own - was;
        turn.meets[static_cast<std::size_t>(i)] = static_cast<Index>(k);
      }
    }
    turn.residual[i] = chip[i] - least;
  }
}

/// How the place of edge i, at the rotation of edge k, moves outward with the unknown of k.
double EdgeBalance::outward_by(const Turn& turn, Index i, Index k) const {
  const Edge& edge = turn.edges[static_cast<std::size_t>(i)];
  return compliance_(edge.slice, turn.edges[static_cast<std::size_t>(k)].slice) *
         (edge.sine * turn.slope_x[k] + edge.cosine * turn.slope_y[k]);
}

void EdgeBalance::assemble(Turn& turn) const {
  const auto size = static_cast<Index>(turn.edges.size());
  turn.jacobian = turn.rise.asDiagonal();
  const auto add = [&](Index i, Index rotation, double by) {
    for (Index k = turn.first[static_cast<std::size_t>(rotation)];
         k < turn.first[static_cast<std::size_t>(rotation) + 1]; ++k) {
      turn.jacobian(i, k) += by * outward_by(turn, i, k);
    }
  };
  for (Index i = 0; i < size; ++i) {
    const Index meets = turn.meets[static_cast<std::size_t>(i)];
    if (meets < 0) continue;
    const Edge& edge = turn.edges[static_cast<std::size_t>(i)];
    const Before& b = edge.before[static_cast<std::size_t>(meets)];
    add(i, edge.rotation, -1.0);
    add(i, b.low, 1.0 - b.share);
    if (b.share > 0.0) add(i, b.high, b.share);
  }
}

}  // namespace osteomill::accuracy
