// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/instantaneous.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "osteomill/base/error.hpp"
#include "osteomill/identify/fit_uncertainty.hpp"
#include "osteomill/numerics/distributions.hpp"
#include "osteomill/numerics/quadrature.hpp"

namespace osteomill::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double kTurn = 2.0 * std::numbers::pi;
/// Starts are compared on no more angles than this.
constexpr Index kStartAngles = 24;
constexpr int kStartPhases = 24;  // a pitch

/// The unknowns that the forces are not linear in, made dimensionless: run-out x, y and tilt x, y
/// (times the axial depth) over the feed per tooth, phase in rad.
struct Layout {
  bool run_out = false;
  bool tilt = false;
  bool phase = false;
  double feed = 0.0;
  double depth = 0.0;
  double known_phase = 0.0;

  Index size() const { return 2 * run_out + 2 * tilt + phase; }
  cutting::RunOut run_out_of(const VectorXd& u, const cutting::RunOut& known) const {
    cutting::RunOut result = known;
    Index at = 0;
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
  double phase_of(const VectorXd& u) const { return phase ? u[size() - 1] : known_phase; }
  /// From dimensionless to SI.
  VectorXd units() const {
    VectorXd result = VectorXd::Ones(size());
    if (run_out) result.segment(0, 2).setConstant(feed);
    if (tilt) result.segment(2 * run_out, 2).setConstant(feed / depth);
    return result;
  }
};

/// Values on some of the angles, and what the model says of them.
class Problem {
 public:
  Problem(const EdgeColumns& model, const Layout& layout, const InstantaneousOptions& options,
          std::vector<double> angle, const Eigen::MatrixX3d& mean, double width)
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

  Index linear() const { return static_cast<Index>(model_.units().size() + offsets_.size()); }
  const std::vector<Index>& offsets() const { return offsets_; }
  const VectorXd& values() const { return values_; }

  /// Forces of each unknown the model is linear in, 3 n rows.
  MatrixXd columns(const VectorXd& u) const {
    const cutting::RunOut run_out = layout_.run_out_of(u, model_.cutter().run_out);
    const double phase = layout_.phase_of(u);
    MatrixXd all(3 * rows_, linear());
    const auto units = static_cast<Index>(model_.units().size());
    if (gains_.size() == 0) {
      all.leftCols(units) = model_.at(angle_, phase, run_out);
    } else {
      const MatrixXd fine = model_.at(fine_angle_, phase, run_out);
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

  /// Rows for what is known of the offsets beforehand.
  Index prior_rows() const {
    return std::count_if(offsets_.begin(), offsets_.end(), [&](Index axis) {
      return std::isfinite(options_.offset_deviation[axis]);
    });
  }
  double offset_weight(std::size_t i) const { return 1.0 / options_.offset_deviation[offsets_[i]]; }

  /// Columns over the standard deviation of the values, prior rows below.
  MatrixXd weigh(const MatrixXd& columns, const Eigen::Vector3d& deviation) const {
    MatrixXd result = MatrixXd::Zero(3 * rows_ + prior_rows(), columns.cols());
    for (Index axis = 0; axis < 3; ++axis) {
      result.middleRows(axis * rows_, rows_) =
          columns.middleRows(axis * rows_, rows_) / deviation[axis];
    }
    Index row = 3 * rows_;
    for (std::size_t i = 0; i < offsets_.size(); ++i) {
      if (!std::isfinite(options_.offset_deviation[offsets_[i]])) continue;
      result(row++, linear() - static_cast<Index>(offsets_.size() - i)) = offset_weight(i);
    }
    return result;
  }
  /// The same for derivatives and values, which the prior rows have none of.
  MatrixXd weigh_values(const MatrixXd& columns, const Eigen::Vector3d& deviation) const {
    MatrixXd result = MatrixXd::Zero(3 * rows_ + prior_rows(), columns.cols());
    for (Index axis = 0; axis < 3; ++axis) {
      result.middleRows(axis * rows_, rows_) =
          columns.middleRows(axis * rows_, rows_) / deviation[axis];
    }
    return result;
  }

 private:
  /// The model is worked out on a grid of its own, fine enough that its higher harmonics, which the
  /// filter took away, do not fold back: of the first that does, a step in the force has left less
  /// than a third of what it has at the last that counts.
  void prepare_gains(double width) {
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
        const double twice =
            2.0 * std::cos(angle_[static_cast<std::size_t>(i)] - fine_angle_.back());
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
  void prepare_width(double width) {
    const numerics::QuadratureRule rule = numerics::gauss_legendre(3);
    const auto nodes = static_cast<Index>(rule.nodes.size());
    gains_ = MatrixXd::Zero(rows_, nodes * rows_);
    for (Index i = 0; i < rows_; ++i) {
      for (Index k = 0; k < nodes; ++k) {
        const auto node = static_cast<std::size_t>(k);
        fine_angle_.push_back(angle_[static_cast<std::size_t>(i)] +
                              width * (rule.nodes[node] - 0.5));
        gains_(i, nodes * i + k) = rule.weights[node];
      }
    }
  }

  const EdgeColumns& model_;
  const Layout& layout_;
  const InstantaneousOptions& options_;
  std::vector<double> angle_;
  Index rows_;
  VectorXd values_;
  std::vector<Index> offsets_;
  std::vector<double> fine_angle_;
  MatrixXd gains_;
};

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
int descend(const Problem& problem, const Eigen::Vector3d& deviation, Point& point, int limit) {
  double damping = 1e-3;
  for (int iteration = 0; iteration < limit; ++iteration) {
    if (point.u.size() == 0) return iteration;
    MatrixXd jacobian = problem.weigh_values(outer_derivatives(problem, point), deviation);
    jacobian -= point.basis * (point.basis.transpose() * jacobian);
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
      Point next = evaluate(problem, deviation, point.u + step);
      if (next.cost < point.cost) {
        moved = step.cwiseAbs().maxCoeff();
        gained = 1.0 - next.cost / point.cost;
        point = std::move(next);
        damping = std::max(damping / 10.0, 1e-9);
        better = true;
      } else {
        damping *= 10.0;
      }
    }
    if (!better || (moved < 1e-7 && gained < 1e-9)) return iteration + 1;
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
      VectorXd u = VectorXd::Zero(size);
      u[size - 1] = period * i / count;
      phases.push_back(evaluate(problem, deviation, u));
    }
  } else {
    phases.push_back(evaluate(problem, deviation, VectorXd::Zero(size)));
  }
  const auto cheaper = [](const Point& one, const Point& two) { return one.cost < two.cost; };
  std::sort(phases.begin(), phases.end(), cheaper);
  if (phases.size() > 3) phases.resize(3);
  std::vector<Point> starts = phases;
  if (layout.run_out) {
    for (const Point& phase : phases) {
      for (int direction = 0; direction < 8; ++direction) {
        VectorXd u = phase.u;
        u[0] = 0.4 * std::cos(kTurn * direction / 8);
        u[1] = 0.4 * std::sin(kTurn * direction / 8);
        starts.push_back(evaluate(problem, deviation, u));
      }
    }
  }
  std::sort(starts.begin(), starts.end(), cheaper);
  if (starts.size() > 3) starts.resize(3);
  for (Point& start : starts) descend(problem, deviation, start, 6);
  return *std::min_element(starts.begin(), starts.end(), cheaper);
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

std::vector<std::string> outer_names(const Layout& layout) {
  std::vector<std::string> names;
  if (layout.run_out) names.insert(names.end(), {"run_out_x", "run_out_y"});
  if (layout.tilt) names.insert(names.end(), {"tilt_x", "tilt_y"});
  if (layout.phase) names.emplace_back("phase");
  return names;
}

/// Jacobian of all unknowns, not weighted: units, outer unknowns in SI, offsets.
MatrixXd jacobian_of(const Problem& problem, const Layout& layout, const Point& point,
                     Index units) {
  MatrixXd outer = central_derivatives(problem, point);
  // A feed of run-out, or a radian, changes the forces by about themselves. What changes them by
  // no more than rounding changes them by nothing.
  const double forces = (point.columns * point.linear).norm();
  for (Index k = 0; k < outer.cols(); ++k) {
    if (outer.col(k).norm() < kRankThreshold * forces) outer.col(k).setZero();
  }
  outer = outer * layout.units().cwiseInverse().asDiagonal();
  MatrixXd jacobian(point.columns.rows(), point.columns.cols() + outer.cols());
  jacobian << point.columns.leftCols(units), outer,
      point.columns.rightCols(point.columns.cols() - units);
  return jacobian;
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
  const Layout layout{options.run_out && several, options.tilt && several,
                      !options.phase.has_value(), condition.feed_per_tooth,
                      immersion.axial_depth,      options.phase.value_or(0.0)};
  const auto units = static_cast<Index>(options.units.size());
  const Index rows = forces.mean.rows();
  const Index offsets = (options.offset_deviation.array() > 0.0).count();
  check(forces, options, units + layout.size() + offsets);

  const bool alike = cutter.pitch.empty() && cutter.radius_error.empty();
  const double period = alike ? kTurn / cutter.flutes : kTurn;

  Eigen::Vector3d deviation = first_deviation(forces);
  Point point;
  {
    const Index stride = std::max<Index>(1, (rows + kStartAngles - 1) / kStartAngles);
    const Index count = (rows + stride - 1) / stride;
    std::vector<double> angle;
    Eigen::MatrixX3d mean(count, 3);
    for (Index i = 0; i < count; ++i) {
      angle.push_back(forces.angle[static_cast<std::size_t>(i * stride)]);
      mean.row(i) = forces.mean.row(i * stride);
    }
    const Problem coarse(model, layout, options, std::move(angle), mean, forces.width);
    point = best_start(coarse, deviation, layout, period);
  }
  const Problem problem(model, layout, options, forces.angle, forces.mean, forces.width);
  const bool known_scatter = forces.each.rows() > 1;
  // Without scatter the residuals of a first fit say how noisy each component is.
  for (int pass = 0; pass < (known_scatter ? 1 : 2); ++pass) {
    if (pass > 0) {
      deviation =
          rms_by_axis(problem.values() - point.columns * point.linear, rows).cwiseMax(1e-12);
    }
    point = evaluate(problem, deviation, point.u);
    const int steps = descend(problem, deviation, point, options.max_iterations);
    fit.status = steps < 0 ? FitStatus::iteration_limit : FitStatus::converged;
    fit.iterations += std::abs(steps);
  }

  fit.run_out = layout.run_out_of(point.u, cutter.run_out);
  fit.phase = layout.phase_of(point.u);
  VectorXd outer = point.u.cwiseProduct(layout.units());
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
  fit.covariance = uncertainty.covariance;
  fit.condition_number = uncertainty.condition_number;
  fit.degrees_of_freedom = uncertainty.degrees_of_freedom;
  fit.noise_rms = known_scatter ? scatter_of_mean(forces.each) : Eigen::Vector3d::Zero();
  fit.effective_values = uncertainty.effective_values;

  VectorXd values(units + layout.size() + offsets);
  values << point.linear.head(units), outer, point.linear.tail(offsets);
  std::vector<std::string> names;
  for (const UnitForce& unit : options.units) names.push_back(unit.name(numbered(options.units)));
  for (const std::string& name : outer_names(layout)) names.push_back(name);
  for (const Index axis : problem.offsets()) names.push_back(std::string("offset_") + "xyz"[axis]);
  const double quantile = numerics::student_t_quantile(0.5 + 0.5 * options.confidence,
                                                       std::max(fit.degrees_of_freedom, 1.0));
  for (Index i = 0; i < values.size(); ++i) {
    const double error = std::sqrt(std::max(0.0, fit.covariance(i, i)));
    fit.estimates.push_back({names[static_cast<std::size_t>(i)], values[i], error,
                             values[i] - quantile * error, values[i] + quantile * error,
                             uncertainty.determined[static_cast<std::size_t>(i)]});
  }
  for (std::string& sentence : verdict_of(fit, options.confidence)) {
    fit.verdict.push_back(std::move(sentence));
  }
  return fit;
}

}  // namespace osteomill::identify
