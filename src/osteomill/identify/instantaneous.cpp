// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/instantaneous.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/fit_uncertainty.hpp"
#include "osteomill/identify/revolution_problem.hpp"
#include "osteomill/numerics/decompositions.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::identify {
namespace {

using detail::Layout;
using Problem = detail::RevolutionProblem;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double kTurn = 2.0 * std::numbers::pi;
/// Starts are compared on no more angles than this.
constexpr Index kStartAngles = 24;
constexpr int kStartPhases = 24;  // a pitch

/// A point of the search: run-out and phase, and the best coefficients there.
struct Point {
  VectorXd u;
  MatrixXd columns;   ///< not weighted
  MatrixXd basis;     ///< orthonormal, of the weighted columns
  VectorXd linear;    ///< coefficients
  VectorXd residual;  ///< weighted
  double cost = std::numeric_limits<double>::infinity();
};

Point evaluate(const Problem& problem, const Eigen::Vector3d& deviation, const VectorXd& u) {
  Point point;
  point.u = u;
  point.columns = problem.columns(u);
  MatrixXd a = problem.weigh(point.columns, deviation);
  const VectorXd y = problem.weigh_values(problem.values(), deviation);
  VectorXd scale = a.colwise().norm();
  for (double& one : scale) one = one > 0.0 ? one : 1.0;
  a = a * scale.cwiseInverse().asDiagonal();
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
  qr.setThreshold(kRankThreshold);
  qr.compute(a);
  const Index rank = qr.rank();
  point.linear = qr.solve(y).cwiseQuotient(scale);
  point.basis = qr.householderQ() * MatrixXd::Identity(a.rows(), rank);
  point.residual = y - point.basis * (point.basis.transpose() * y);
  point.cost = point.residual.squaredNorm();
  return point;
}

/// Steps of the outer unknowns for derivatives. The forces are continuous and smooth but for kinks
/// of their slope, the ends of contact found to 2^-40 of a panel: these lose about 1e-8.
constexpr double kStep = 1e-4;

/// Derivatives of the model's forces by the outer unknowns at fixed coefficients, not weighted:
/// one-sided, for the search.
MatrixXd outer_derivatives(const Problem& problem, const Point& point) {
  MatrixXd result(point.columns.rows(), point.u.size());
  for (Index k = 0; k < point.u.size(); ++k) {
    VectorXd up = point.u;
    up[k] += kStep;
    result.col(k) = (problem.columns(up) - point.columns) * point.linear / kStep;
  }
  return result;
}

/// The same as central differences, for the errors.
MatrixXd central_derivatives(const Problem& problem, const Point& point) {
  MatrixXd result(point.columns.rows(), point.u.size());
  for (Index k = 0; k < point.u.size(); ++k) {
    VectorXd up = point.u;
    VectorXd down = point.u;
    up[k] += kStep;
    down[k] -= kStep;
    result.col(k) = (problem.columns(up) - problem.columns(down)) * point.linear / (2.0 * kStep);
  }
  return result;
}

/// Levenberg and Marquardt's steps on the projected residuals. Returns the steps taken; negative
/// when they did not suffice.
int descend(const Problem& problem, const Eigen::Vector3d& deviation, const Layout& layout,
            Point& point, int limit) {
  double damping = 1e-3;
  for (int iteration = 0; iteration < limit; ++iteration) {
    if (point.u.size() == 0) return iteration;
    MatrixXd jacobian = problem.weigh_values(outer_derivatives(problem, point), deviation);
    jacobian -= point.basis * (point.basis.transpose() * jacobian);
    for (Index k = 0; k < point.u.size(); ++k) {
      // What stands at its limit and would go beyond stays there.
      VectorXd beyond = point.u;
      beyond[k] += std::copysign(kStep, jacobian.col(k).dot(point.residual));
      layout.clamp(beyond);
      if (beyond[k] == point.u[k]) jacobian.col(k).setZero();
    }
    const MatrixXd normal = jacobian.transpose() * jacobian;
    const VectorXd gradient = jacobian.transpose() * point.residual;
    const double floor = 1e-12 * std::max(normal.diagonal().maxCoeff(), 1e-300);
    bool better = false;
    double moved = 0.0;
    double gained = 0.0;
    for (int attempt = 0; attempt < 12 && !better; ++attempt) {
      MatrixXd damped = normal;
      damped.diagonal() += damping * normal.diagonal() + VectorXd::Constant(point.u.size(), floor);
      VectorXd step = damped.ldlt().solve(gradient);
      // No step beyond what the forces stay nearly linear over: a feed, half a radian.
      step *= std::min(1.0, 0.5 / std::max(step.cwiseAbs().maxCoeff(), 1e-300));
      VectorXd to = point.u + step;
      layout.clamp(to);
      Point next = evaluate(problem, deviation, to);
      if (next.cost < point.cost) {
        moved = (to - point.u).cwiseAbs().maxCoeff();
        gained = 1.0 - next.cost / point.cost;
        point = std::move(next);
        damping = std::max(damping / 10.0, 1e-9);
        better = true;
      } else {
        damping *= 10.0;
      }
    }
    // What a step that gains a hundred-millionth of chi squared moves is far below the errors.
    if (!better || moved < 1e-7 || gained < 1e-8) return iteration + 1;
  }
  return -1;
}

/// The best of several starts: phases over a pitch (a turn where flutes differ) with no run-out,
/// then the two best phases with run-out in eight directions.
Point best_start(const Problem& problem, const Eigen::Vector3d& deviation, const Layout& layout,
                 double period) {
  const Index size = layout.size();
  std::vector<Point> phases;
  if (layout.phase) {
    const int count = kStartPhases * std::max(1, static_cast<int>(std::lround(period / kTurn)));
    for (int i = 0; i < count; ++i) {
      VectorXd u = layout.start();
      u[size - 1] = period * i / count;
      phases.push_back(evaluate(problem, deviation, u));
    }
  } else {
    phases.push_back(evaluate(problem, deviation, layout.start()));
  }
  const auto cheaper = [](const Point& one, const Point& two) { return one.cost < two.cost; };
  std::sort(phases.begin(), phases.end(), cheaper);
  if (phases.size() > 3) phases.resize(3);
  std::vector<Point> starts = phases;
  if (layout.run_out) {
    const Index first = layout.exponents();
    for (const Point& phase : phases) {
      for (int direction = 0; direction < 8; ++direction) {
        VectorXd u = phase.u;
        u[first] = 0.4 * std::cos(kTurn * direction / 8);
        u[first + 1] = 0.4 * std::sin(kTurn * direction / 8);
        starts.push_back(evaluate(problem, deviation, u));
      }
    }
  }
  std::sort(starts.begin(), starts.end(), cheaper);
  if (starts.size() > 3) starts.resize(3);
  for (Point& start : starts) descend(problem, deviation, layout, start, 6);
  return *std::min_element(starts.begin(), starts.end(), cheaper);
}

/// Run-out and phase of another cut of the same clamping, as a point of this search.
VectorXd start_of(const Layout& layout, const InstantaneousStart& hint) {
  VectorXd u = layout.start();
  const Index first = layout.exponents();
  if (layout.run_out) {
    u[first] = hint.run_out.offset * std::cos(hint.run_out.offset_angle) / layout.feed;
    u[first + 1] = hint.run_out.offset * std::sin(hint.run_out.offset_angle) / layout.feed;
  }
  if (layout.phase) u[layout.size() - 1] = hint.phase;
  return u;
}

void check(const RevolutionForces& forces, const InstantaneousOptions& options, Index unknowns) {
  const Index rows = forces.mean.rows();
  const auto refuse = [](const char* field, std::string value, const char* rule,
                         const char* remedy) {
    throw InvalidInput(Fault{field, std::move(value), rule, remedy});
  };
  if (static_cast<Index>(forces.angle.size()) != rows ||
      (forces.each.rows() > 0 && forces.each.cols() != 3 * rows)) {
    refuse("forces", fmt::format("{} angles, {} forces", forces.angle.size(), rows),
           "must have a force for each angle", "");
  }
  if (3 * rows <= unknowns) {
    refuse("forces", fmt::format("{} values for {} unknowns", 3 * rows, unknowns),
           "must be more values than unknowns", "average over more angles of the revolution");
  }
  if (!forces.mean.allFinite() || !forces.each.allFinite()) {
    refuse("forces", "", "must be finite", "mend the gaps of the record first");
  }
  if (options.units.empty()) refuse("units", "0", "must name one coefficient at least", "");
  require_within("confidence", options.confidence, 0.5, 0.9999, "");
}

/// Standard deviation of the mean of each component, or a guess where its scatter is not known.
Eigen::Vector3d first_deviation(const RevolutionForces& forces) {
  const Index rows = forces.mean.rows();
  Eigen::Vector3d deviation;
  for (Index axis = 0; axis < 3; ++axis) {
    deviation[axis] = 0.05 * forces.mean.norm() / std::sqrt(static_cast<double>(rows));
  }
  if (forces.each.rows() > 1) {
    const Eigen::Vector3d scatter = scatter_of_mean(forces.each);
    for (Index axis = 0; axis < 3; ++axis) {
      if (scatter[axis] > 0.0) deviation[axis] = scatter[axis];
    }
  }
  return deviation.cwiseMax(1e-12);
}

Eigen::Vector3d rms_by_axis(const VectorXd& values, Index rows) {
  Eigen::Vector3d result;
  for (Index axis = 0; axis < 3; ++axis) {
    result[axis] = values.segment(axis * rows, rows).norm() / std::sqrt(static_cast<double>(rows));
  }
  return result;
}

/// Jacobian of all unknowns, not weighted: units, outer unknowns in SI, offsets. What stands at its
/// limit is a constant.
MatrixXd jacobian_of(const Problem& problem, const Layout& layout, const Point& point,
                     Index units) {
  MatrixXd outer = central_derivatives(problem, point);
  // A feed of run-out, or a radian, changes the forces by about themselves. What changes them by
  // no more than rounding changes them by nothing.
  const double forces = (point.columns * point.linear).norm();
  for (Index k = 0; k < outer.cols(); ++k) {
    if (outer.col(k).norm() < kRankThreshold * forces) outer.col(k).setZero();
    if (layout.at_limit(point.u, k)) outer.col(k).setZero();
  }
  outer = outer * layout.scales().cwiseInverse().asDiagonal();
  MatrixXd jacobian(point.columns.rows(), point.columns.cols() + outer.cols());
  jacobian << point.columns.leftCols(units), outer,
      point.columns.rightCols(point.columns.cols() - units);
  return jacobian;
}

/// The first of the components that came out negative under a law that cannot be: none where all
/// are fine.
std::optional<ForceComponent> negative_component(const std::vector<UnitForce>& units,
                                                 const VectorXd& linear) {
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (units[i].exponents() > 0 && !(linear[static_cast<Index>(i)] > 0.0)) {
      return units[i].component;
    }
  }
  return {};
}

/// Factors of log laws as their logarithm, K1 of N/mm.
void take_logarithms(const std::vector<UnitForce>& units, VectorXd& values, MatrixXd& covariance) {
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (units[i].kind != UnitForce::Kind::log) continue;
    const auto k = static_cast<Index>(i);
    const double slope = 1.0 / (values[k] * std::numbers::ln10);
    covariance.row(k) *= slope;
    covariance.col(k) *= slope;
    values[k] = std::log10(values[k] / units::n_per_mm);
  }
}

}  // namespace

InstantaneousFit fit_instantaneous(const RevolutionForces& forces, const cutting::Cutter& cutter,
                                   const cutting::Condition& condition,
                                   const cutting::Immersion& immersion,
                                   const InstantaneousOptions& options) {
  InstantaneousFit fit;
  const EdgeColumns model(cutter, condition, immersion, options.units);
  // The axis of a cutter with one flute may lie anywhere: every turn takes the same chip.
  const bool several = cutter.flutes > 1;
  if (options.run_out && !several) {
    fit.verdict.emplace_back(
        "one flute takes the same chip whatever its run-out, so run-out was not sought");
  }
  const Layout layout{.units = options.units,
                      .run_out = options.run_out && several,
                      .tilt = options.tilt && several,
                      .phase = !options.phase.has_value(),
                      .feed = condition.feed_per_tooth,
                      .depth = immersion.axial_depth,
                      .known_phase = options.phase.value_or(0.0)};
  const auto units = static_cast<Index>(options.units.size());
  const Index rows = forces.mean.rows();
  const Index offsets = (options.offset_deviation.array() > 0.0).count();
  check(forces, options, units + layout.size() + offsets);

  const bool alike = cutter.pitch.empty() && cutter.radius_error.empty();
  const double period = alike ? kTurn / cutter.flutes : kTurn;

  Eigen::Vector3d deviation = first_deviation(forces);
  const Problem problem(model, layout, options, forces.angle, forces.mean, forces.width);
  const bool known_scatter = forces.each.rows() > 1;
  const auto search = [&](const VectorXd& start) {
    Point point = evaluate(problem, deviation, start);
    const int steps = descend(problem, deviation, layout, point, options.max_iterations);
    fit.status = steps < 0 ? FitStatus::iteration_limit : FitStatus::converged;
    fit.iterations += std::abs(steps);
    return point;
  };
  Point point;
  bool found = false;
  if (options.start && known_scatter) {
    point = search(start_of(layout, *options.start));
    // Where it led astray the residuals are far above the scatter, and the search begins anew.
    found = point.cost <= 2.0 * static_cast<double>(3 * rows - units - layout.size());
  }
  if (!found) {
    const Index stride = std::max<Index>(1, (rows + kStartAngles - 1) / kStartAngles);
    const Index count = (rows + stride - 1) / stride;
    std::vector<double> angle;
    Eigen::MatrixX3d mean(count, 3);
    for (Index i = 0; i < count; ++i) {
      angle.push_back(forces.angle[static_cast<std::size_t>(i * stride)]);
      mean.row(i) = forces.mean.row(i * stride);
    }
    const Problem coarse(model, layout, options, std::move(angle), mean, forces.width);
    point = search(best_start(coarse, deviation, layout, period).u);
    if (!known_scatter) {
      // The residuals of a first fit say how noisy each component is.
      deviation =
          rms_by_axis(problem.values() - point.columns * point.linear, rows).cwiseMax(1e-12);
      point = search(point.u);
    }
  }
  if (const auto negative = negative_component(options.units, point.linear)) {
    // The nearest that such a law can be is no force at all.
    InstantaneousOptions fewer = options;
    std::erase_if(fewer.units, [&](const UnitForce& unit) { return unit.component == *negative; });
    fit = fit_instantaneous(forces, cutter, condition, immersion, fewer);
    fit.verdict.push_back(
        fmt::format("the {} force would be negative, which this law cannot be: it is held at zero",
                    name_of(*negative)));
    return fit;
  }

  fit.run_out = layout.run_out_of(point.u, cutter.run_out);
  fit.phase = layout.phase_of(point.u);
  VectorXd outer = point.u.cwiseProduct(layout.scales());
  if (layout.phase) {
    // Flutes that are alike may be counted from any of them: flute 0 is the one within a pitch.
    const double turned = period * std::floor(fit.phase / period);
    fit.phase -= turned;
    outer[layout.size() - 1] = fit.phase;
  }
  const VectorXd model_forces = point.columns * point.linear;
  fit.fitted = model_forces.reshaped(rows, 3);
  const VectorXd residual = problem.values() - model_forces;
  fit.residual_rms = rms_by_axis(residual, rows);

  const MatrixXd jacobian = jacobian_of(problem, layout, point, units);
  const Uncertainty uncertainty = uncertainty_of(
      {jacobian, residual, deviation, forces.each, options.offset_deviation, problem.offsets()});
  fit.condition_number = uncertainty.condition_number;
  fit.degrees_of_freedom = uncertainty.degrees_of_freedom;
  fit.noise_rms = known_scatter ? scatter_of_mean(forces.each) : Eigen::Vector3d::Zero();
  fit.effective_values = uncertainty.effective_values;

  VectorXd values(units + layout.size() + offsets);
  values << point.linear.head(units), outer, point.linear.tail(offsets);
  fit.units = options.units;
  fit.covariance = uncertainty.covariance;
  take_logarithms(options.units, values, fit.covariance);
  std::vector<std::string> names;
  for (const UnitForce& unit : options.units) names.push_back(unit.name(numbered(options.units)));
  for (const std::string& name : layout.names()) names.push_back(name);
  for (const Index axis : problem.offsets()) names.push_back(std::string("offset_") + "xyz"[axis]);
  const double quantile = numerics::student_t_quantile(0.5 + 0.5 * options.confidence,
                                                       std::max(fit.degrees_of_freedom, 1.0));
  for (Index i = 0; i < values.size(); ++i) {
    const double error = std::sqrt(std::max(0.0, fit.covariance(i, i)));
    fit.estimates.push_back({names[static_cast<std::size_t>(i)], values[i], error,
                             values[i] - quantile * error, values[i] + quantile * error,
                             uncertainty.determined[static_cast<std::size_t>(i)]});
    const Index of_outer = i - units;
    fit.estimates.back().at_limit =
        of_outer >= 0 && of_outer < layout.size() && layout.at_limit(point.u, of_outer);
  }
  for (std::string& sentence : verdict_of(fit, options.confidence)) {
    fit.verdict.push_back(std::move(sentence));
  }
  return fit;
}

}  // namespace osteomill::identify
