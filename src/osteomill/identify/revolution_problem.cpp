// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/revolution_problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "osteomill/numerics/quadrature.hpp"

namespace osteomill::identify::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}  // namespace

cutting::RunOut Layout::run_out_of(const VectorXd& u, const cutting::RunOut& known) const {
  cutting::RunOut result = known;
  Index at = exponents();
  if (run_out) {
    result.offset = feed * std::hypot(u[at], u[at + 1]);
    result.offset_angle = std::atan2(u[at + 1], u[at]);
    at += 2;
  }
  if (tilt) {
    result.tilt = feed / depth * std::hypot(u[at], u[at + 1]);
    result.tilt_angle = std::atan2(u[at + 1], u[at]);
  }
  return result;
}

VectorXd Layout::scales() const {
  VectorXd result = VectorXd::Ones(size());
  const Index first = exponents();
  if (run_out) result.segment(first, 2).setConstant(feed);
  if (tilt) result.segment(first + 2 * run_out, 2).setConstant(feed / depth);
  return result;
}

VectorXd Layout::start() const {
  VectorXd u = VectorXd::Zero(size());
  Index at = 0;
  for (const UnitForce& unit : units) {
    if (unit.exponents() > 0) u[at] = 0.5;
    if (unit.exponents() > 1) u[at + 1] = -0.02;
    at += unit.exponents();
  }
  return u;
}

Layout::Limits Layout::limits() const {
  Limits result{VectorXd::Constant(size(), -kInfinity), VectorXd::Constant(size(), kInfinity)};
  Index at = 0;
  for (const UnitForce& unit : units) {
    if (unit.kind == UnitForce::Kind::power) {
      // The bracket of cutting::fit_power_law.
      result.low[at] = 0.02;
      result.high[at] = 1.5;
    }
    if (unit.kind == UnitForce::Kind::log) result.high[at + 1] = 0.0;
    at += unit.exponents();
  }
  return result;
}

void Layout::clamp(VectorXd& u) const {
  const Limits range = limits();
  u = u.cwiseMax(range.low).cwiseMin(range.high);
}

bool Layout::at_limit(const VectorXd& u, Index i) const {
  const Limits range = limits();
  return u[i] <= range.low[i] || u[i] >= range.high[i];
}

std::vector<std::string> Layout::names() const {
  std::vector<std::string> names;
  for (const UnitForce& unit : units) {
    for (const std::string& name : unit.exponent_names()) names.push_back(name);
  }
  if (run_out) names.insert(names.end(), {"run_out_x", "run_out_y"});
  if (tilt) names.insert(names.end(), {"tilt_x", "tilt_y"});
  if (phase) names.emplace_back("phase");
  return names;
}

RevolutionProblem::RevolutionProblem(const EdgeColumns& model, const Layout& layout,
                                     const InstantaneousOptions& options, std::vector<double> angle,
                                     const Eigen::MatrixX3d& mean, double width)
    : model_(model),
      layout_(layout),
      options_(options),
      angle_(std::move(angle)),
      rows_(mean.rows()),
      values_(mean.reshaped()) {
  for (Index axis = 0; axis < 3; ++axis) {
    if (options.offset_deviation[axis] > 0.0) offsets_.push_back(axis);
  }
  if (!options.harmonic_gains.empty()) {
    prepare_gains(width);
  } else if (width > 0.0) {
    prepare_width(width);
  }
}

MatrixXd RevolutionProblem::columns(const VectorXd& u) const {
  const cutting::RunOut run_out = layout_.run_out_of(u, model_.cutter().run_out);
  const double phase = layout_.phase_of(u);
  const VectorXd exponents = u.head(layout_.exponents());
  MatrixXd all(3 * rows_, linear());
  const auto units = static_cast<Index>(model_.units().size());
  if (gains_.size() == 0) {
    all.leftCols(units) = model_.at(angle_, phase, run_out, exponents);
  } else {
    const MatrixXd fine = model_.at(fine_angle_, phase, run_out, exponents);
    for (Index axis = 0; axis < 3; ++axis) {
      all.block(axis * rows_, 0, rows_, units) =
          gains_ * fine.middleRows(axis * gains_.cols(), gains_.cols());
    }
  }
  for (std::size_t i = 0; i < offsets_.size(); ++i) {
    auto column = all.col(units + static_cast<Index>(i));
    column.setZero();
    column.segment(offsets_[i] * rows_, rows_).setOnes();
  }
  return all;
}

Index RevolutionProblem::prior_rows() const {
  return std::count_if(offsets_.begin(), offsets_.end(),
                       [&](Index axis) { return std::isfinite(options_.offset_deviation[axis]); });
}

MatrixXd RevolutionProblem::weigh_values(const MatrixXd& columns,
                                         const Eigen::Vector3d& deviation) const {
  MatrixXd result = MatrixXd::Zero(3 * rows_ + prior_rows(), columns.cols());
  for (Index axis = 0; axis < 3; ++axis) {
    result.middleRows(axis * rows_, rows_) =
        columns.middleRows(axis * rows_, rows_) / deviation[axis];
  }
  return result;
}

MatrixXd RevolutionProblem::weigh(const MatrixXd& columns, const Eigen::Vector3d& deviation) const {
  MatrixXd result = weigh_values(columns, deviation);
  Index row = 3 * rows_;
  for (std::size_t i = 0; i < offsets_.size(); ++i) {
    const double known = options_.offset_deviation[offsets_[i]];
    if (!std::isfinite(known)) continue;
    result(row++, linear() - static_cast<Index>(offsets_.size() - i)) = 1.0 / known;
  }
  return result;
}

/// The model is worked out on a grid of its own, fine enough that its higher harmonics, which the
/// filter took away, do not fold back: of the first that does, a step in the force has left less
/// than a third of what it has at the last that counts.
void RevolutionProblem::prepare_gains(double width) {
  std::vector<double> gains = options_.harmonic_gains;
  for (std::size_t h = 1; h < gains.size(); ++h) {
    const double half = 0.5 * static_cast<double>(h) * width;
    if (half > 0.0) gains[h] *= std::sin(half) / half;
  }
  const auto harmonics = static_cast<Index>(gains.size());
  const Index fine = std::max<Index>(72, 8 * harmonics);
  gains_.resize(rows_, fine);
  for (Index k = 0; k < fine; ++k) {
    fine_angle_.push_back(kTurn * static_cast<double>(k) / static_cast<double>(fine));
    for (Index i = 0; i < rows_; ++i) {
      // Sum of g_h cos(h d) by Clenshaw's recurrence.
      const double twice = 2.0 * std::cos(angle_[static_cast<std::size_t>(i)] - fine_angle_.back());
      double next = 0.0;
      double after = 0.0;
      for (Index h = harmonics - 1; h > 0; --h) {
        const double gain = 2.0 * gains[static_cast<std::size_t>(h)];
        after = std::exchange(next, gain + twice * next - after);
      }
      gains_(i, k) = (gains[0] + 0.5 * twice * next - after) / static_cast<double>(fine);
    }
  }
}

/// Means over a width about each angle, by three nodes.
void RevolutionProblem::prepare_width(double width) {
  const numerics::QuadratureRule rule = numerics::gauss_legendre(3);
  const auto nodes = static_cast<Index>(rule.nodes.size());
  gains_ = MatrixXd::Zero(rows_, nodes * rows_);
  for (Index i = 0; i < rows_; ++i) {
    for (Index k = 0; k < nodes; ++k) {
      const auto node = static_cast<std::size_t>(k);
      fine_angle_.push_back(angle_[static_cast<std::size_t>(i)] + width * (rule.nodes[node] - 0.5));
      gains_(i, nodes * i + k) = rule.weights[node];
    }
  }
}

}  // namespace osteomill::identify::detail
