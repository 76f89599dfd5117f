// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/mean_force_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/cutting/condition.hpp"
#include "osteomill/numerics/decompositions.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::identify {
namespace {

using detail::FitSolution;
using detail::FitTask;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Combinations whose singular value is below a share of the largest.
std::vector<WeakDirection> weak_directions(const MatrixXd& scaled,
                                           const std::vector<std::string>& names, double share) {
  const Eigen::JacobiSVD<MatrixXd> svd(scaled, Eigen::ComputeThinU | Eigen::ComputeFullV);
  const VectorXd& singular = svd.singularValues();
  std::vector<WeakDirection> weak;
  for (Index i = scaled.cols() - 1; i >= 0; --i) {
    const double relative = i < singular.size() ? singular(i) / singular(0) : 0.0;
    if (relative >= share) break;
    WeakDirection direction{relative, {}};
    const VectorXd v = svd.matrixV().col(i);
    for (Index k = 0; k < v.size(); ++k) {
      // What is below a fifth of the largest share does not help the reader.
      if (std::abs(v(k)) >= 0.2 * v.cwiseAbs().maxCoeff()) {
        direction.shares.emplace_back(names[static_cast<std::size_t>(k)], v(k));
      }
    }
    std::sort(direction.shares.begin(), direction.shares.end(),
              [](const auto& a, const auto& b) { return std::abs(a.second) > std::abs(b.second); });
    weak.push_back(direction);
  }
  return weak;
}

std::string names_in(const WeakDirection& direction) {
  std::string text;
  for (const auto& [name, share] : direction.shares) text += (text.empty() ? "" : ", ") + name;
  return text;
}

[[noreturn]] void refuse_undetermined(const FitTask& task, const FitSolution& solution) {
  std::vector<std::string> names;
  MatrixXd scaled = task.weight.asDiagonal() * solution.sensitivity;
  for (const CoefficientKey& key : coefficients_of(task.model)) names.push_back(key.name);
  for (Index i = 0; i < scaled.cols(); ++i) {
    const double norm = scaled.col(i).norm();
    if (norm > 0.0) scaled.col(i) /= norm;
  }
  std::string together;
  for (const WeakDirection& direction : weak_directions(scaled, names, 1e-9)) {
    together += (together.empty() ? "" : "; ") + names_in(direction);
  }
  const bool curved = task.model.form == LawForm::polynomial;
  throw InvalidInput(
      Fault{"experiments", fmt::format("{} cuts", task.experiments.size()),
            fmt::format("do not tell apart the coefficients of \"{}\": {}", name_of(task.model),
                        together),
            curved ? "vary feed and axial depth; a cylinder has one kappa and takes orders 0 only"
                   : "vary feed per tooth, axial depth or immersion"});
}

VectorXd bounds_of(const std::vector<CoefficientKey>& keys, const std::vector<Bound>& bounds,
                   bool upper) {
  VectorXd values(static_cast<Index>(keys.size()));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    double value = upper ? keys[i].high : keys[i].low;
    for (const Bound& bound : bounds) {
      if (bound.coefficient != keys[i].name) continue;
      value = upper ? std::min(value, bound.high) : std::max(value, bound.low);
    }
    values(static_cast<Index>(i)) = value;
  }
  return values;
}

void check_bounds(const ForceModel& model, const std::vector<Bound>& bounds) {
  const std::vector<CoefficientKey> keys = coefficients_of(model);
  std::string known;
  for (const CoefficientKey& key : keys) known += (known.empty() ? "" : ", ") + key.name;
  FaultList faults;
  for (const Bound& bound : bounds) {
    faults.gather([&] {
      const auto key = std::find_if(keys.begin(), keys.end(), [&](const CoefficientKey& one) {
        return one.name == bound.coefficient;
      });
      if (key == keys.end()) {
        throw InvalidInput(Fault{"model.bound", bound.coefficient,
                                 "is no coefficient of \"" + name_of(model) + "\"",
                                 "known: " + known});
      }
      if (!(std::max(bound.low, key->low) < std::min(bound.high, key->high))) {
        throw InvalidInput(Fault{
            "model.bound", bound.coefficient, "must leave room between low and high",
            fmt::format("the model allows {:g} ... {:g} {}", key->low / factor_of(key->dimension),
                        key->high / factor_of(key->dimension), unit_of(key->dimension))});
      }
    });
  }
  faults.raise();
}

/// s² (A'A)^-1 in scaled columns; with a ridge the scatter of the shrunk values, with a robust loss
/// Huber's asymptotic covariance.
MatrixXd covariance_of(const FitTask& task, const FitSolution& solution, const MatrixXd& free,
                       const VectorXd& penalty, double variance, const VectorXd& residual) {
  VectorXd scale = free.colwise().norm();
  const MatrixXd scaled = free * scale.cwiseInverse().asDiagonal();
  const VectorXd ridge = penalty.cwiseQuotient(scale);
  const MatrixXd normal = scaled.transpose() * scaled;
  const MatrixXd inverse = MatrixXd(normal + MatrixXd(ridge.cwiseAbs2().asDiagonal()))
                               .ldlt()
                               .solve(MatrixXd::Identity(normal.rows(), normal.cols()));
  MatrixXd covariance = variance * inverse * normal * inverse;
  if (task.loss != Loss::squares) {
    // psi' of the two losses: 1 where a residual counts in full; means over all residuals.
    const VectorXd& w = solution.robust_weight;
    double slope = 0.0;
    for (Index i = 0; i < w.size(); ++i) {
      if (task.loss == Loss::huber) slope += w(i) >= 1.0 ? 1.0 : 0.0;
      if (task.loss == Loss::tukey) {
        const double share2 = 1.0 - std::sqrt(w(i));
        slope += std::sqrt(w(i)) * (1.0 - 5.0 * share2);
      }
    }
    slope /= static_cast<double>(w.size());
    const double psi2 =
        w.cwiseProduct(residual).squaredNorm() / static_cast<double>(w.size() - free.cols());
    // The columns carry the square roots of the robust weights: their normal matrix is about the
    // mean weight times that of all the means.
    covariance = psi2 / (slope * slope) * (w.mean() * inverse);
  }
  return scale.cwiseInverse().asDiagonal() * covariance * scale.cwiseInverse().asDiagonal();
}

void add_influence(const FitTask& task, const FitSolution& solution, const VectorXd& residual,
                   double unknowns, MeanForceFit& fit) {
  const MatrixXd hat = detail::hat_matrix(task, solution);
  const VectorXd root = solution.robust_weight.cwiseSqrt();
  const auto n = static_cast<Index>(task.experiments.size());
  fit.leverage.resize(n);
  fit.cook_distance.resize(n);
  for (Index i = 0; i < n; ++i) {
    const Eigen::Matrix3d h = hat.block<3, 3>(3 * i, 3 * i);
    const Eigen::Matrix3d rest = Eigen::Matrix3d::Identity() - h;
    const Eigen::Vector3d e = root.segment<3>(3 * i).cwiseProduct(residual.segment<3>(3 * i));
    const Eigen::Vector3d out = rest.completeOrthogonalDecomposition().solve(e);
    fit.leverage(i) = h.trace();
    fit.cook_distance(i) =
        out.dot(h * out) / (unknowns * fit.residual_deviation * fit.residual_deviation);
  }
}

}  // namespace

void check(const std::vector<Experiment>& experiments, const FitOptions& options) {
  FaultList faults;
  if (experiments.empty()) {
    throw InvalidInput(Fault{"experiments", "0", "must hold at least one cut", "add rows"});
  }
  for (const Experiment& one : experiments) {
    faults.gather([&] {
      if (!one.mean_force.allFinite()) {
        throw InvalidInput(Fault{"experiments." + one.name, "", "must have three finite forces",
                                 "leave the cut out or measure it again"});
      }
      cutting::check(one.condition, one.cutter);
      cutting::check(one.immersion, one.cutter);
      const bool known = (one.standard_error.array() > 0.0).all();
      if (options.weighting == Weighting::standard_errors && !known) {
        throw InvalidInput(Fault{"experiments." + one.name, "",
                                 "must have standard errors > 0 of all three forces",
                                 "give them, or set weights = \"equal\""});
      }
    });
  }
  faults.raise();
}

namespace detail {

FitTask task_of(const std::vector<Experiment>& experiments, const ForceModel& model,
                const FitOptions& options) {
  check(experiments, options);
  check_bounds(model, options.bounds);
  FitTask task;
  task.model = model;
  task.experiments = experiments;
  task.measured = measured_forces(experiments);
  task.weight = VectorXd::Ones(task.measured.size());
  const bool known = std::all_of(experiments.begin(), experiments.end(), [](const Experiment& one) {
    return (one.standard_error.array() > 0.0).all();
  });
  if (options.weighting != Weighting::equal && known) {
    for (std::size_t i = 0; i < experiments.size(); ++i) {
      task.weight.segment<3>(3 * static_cast<Index>(i)) =
          experiments[i].standard_error.cwiseInverse();
    }
  }
  const std::vector<CoefficientKey> keys = coefficients_of(model);
  task.lower = bounds_of(keys, options.bounds, false);
  task.upper = bounds_of(keys, options.bounds, true);
  task.loss = options.loss;
  task.ridge_scale = VectorXd::Zero(static_cast<Index>(keys.size()));
  if (is_linear(model)) {
    task.columns = sensitivities(model, {}, experiments);
    const MatrixXd weighted = task.weight.asDiagonal() * task.columns;
    if (options.ridge > 0.0) {
      task.ridge_scale = std::sqrt(options.ridge) * weighted.colwise().norm().transpose();
    }
  }
  return task;
}

}  // namespace detail

MeanForceFit fit_mean_forces(const std::vector<Experiment>& experiments, const ForceModel& model,
                             const FitOptions& options) {
  const FitTask task = detail::task_of(experiments, model, options);
  const std::vector<CoefficientKey> keys = coefficients_of(model);
  const Index values = task.measured.size();
  if (values <= static_cast<Index>(keys.size())) {
    throw InvalidInput(Fault{
        "experiments", fmt::format("{} cuts with {} mean forces", experiments.size(), values),
        fmt::format("must give more than the {} unknowns of \"{}\"", keys.size(), name_of(model)),
        fmt::format("cut at least {} times, or choose a model with fewer unknowns",
                    keys.size() / 3 + 1)});
  }
  const VectorXd start = is_linear(model) ? VectorXd::Zero(static_cast<Index>(keys.size()))
                                          : starting_values(model, experiments);
  const FitSolution solution = detail::solve(task, start);
  if (!detail::is_determined(task, solution)) refuse_undetermined(task, solution);

  MeanForceFit fit;
  fit.model = model;
  fit.values = solution.values;
  fit.sensitivity = solution.sensitivity;
  fit.ridge_scale = task.ridge_scale;
  fit.weighted = (task.weight.array() != 1.0).any();
  const VectorXd predicted = is_linear(model)
                                 ? VectorXd(task.columns * solution.values)
                                 : mean_forces(law_of(model, solution.values), experiments);
  const auto n = static_cast<Index>(experiments.size());
  fit.predicted = predicted.reshaped<Eigen::RowMajor>(n, 3);
  fit.residual = (task.measured - predicted).reshaped<Eigen::RowMajor>(n, 3);
  fit.robust_weight = solution.robust_weight.reshaped<Eigen::RowMajor>(n, 3);
  fit.residual_rms = (fit.residual.colwise().squaredNorm() / static_cast<double>(n)).cwiseSqrt();
  fit.residual_rms_all = fit.residual.norm() / std::sqrt(static_cast<double>(values));

  // Coefficients that no bound holds back, in weighted and robust-weighted columns.
  std::vector<Index> free;
  for (Index i = 0; i < static_cast<Index>(keys.size()); ++i) {
    if (!solution.at_bound[static_cast<std::size_t>(i)]) free.push_back(i);
  }
  const VectorXd row_weight = task.weight.cwiseProduct(solution.robust_weight.cwiseSqrt());
  const MatrixXd columns =
      row_weight.asDiagonal() * MatrixXd(solution.sensitivity(Eigen::all, free));
  const VectorXd penalty = task.ridge_scale(free);
  const VectorXd residual = task.weight.cwiseProduct(task.measured - predicted);
  const double effective = detail::hat_matrix(task, solution).trace();
  fit.degrees_of_freedom = static_cast<double>(values) - effective;
  fit.residual_deviation = std::sqrt(
      solution.robust_weight.cwiseProduct(residual.cwiseAbs2()).sum() / fit.degrees_of_freedom);
  const MatrixXd covariance = covariance_of(
      task, solution, columns, penalty, fit.residual_deviation * fit.residual_deviation, residual);
  const auto p = static_cast<Index>(keys.size());
  fit.covariance = MatrixXd::Zero(p, p);
  fit.covariance(free, free) = covariance;

  MatrixXd scaled = columns, in_units = columns;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < free.size(); ++k) {
    const auto column = static_cast<Index>(k);
    const CoefficientKey& key = keys[static_cast<std::size_t>(free[k])];
    scaled.col(column) /= columns.col(column).norm();
    in_units.col(column) *= factor_of(key.dimension);
    names.push_back(key.name);
  }
  const auto condition = [](const MatrixXd& a) {
    const VectorXd singular = Eigen::JacobiSVD<MatrixXd>(a).singularValues();
    return singular(0) / singular(singular.size() - 1);
  };
  if (!free.empty()) {
    fit.condition_number = condition(scaled);
    fit.condition_number_unscaled = condition(in_units);
    fit.weak = weak_directions(scaled, names, 0.01);
  }
  add_influence(task, solution, residual, effective, fit);

  const double t = numerics::student_t_quantile(0.5 + 0.5 * options.confidence,
                                                std::max(1e-3, fit.degrees_of_freedom));
  for (Index i = 0; i < p; ++i) {
    const CoefficientKey& key = keys[static_cast<std::size_t>(i)];
    Coefficient one{.name = key.name, .dimension = key.dimension, .value = fit.values(i)};
    one.standard_error = std::sqrt(fit.covariance(i, i));
    one.at_bound = solution.at_bound[static_cast<std::size_t>(i)];
    one.low = one.value - t * one.standard_error;
    one.high = one.value + t * one.standard_error;
    one.determined = !one.at_bound && one.standard_error <= 0.5 * std::abs(one.value);
    fit.coefficients.push_back(one);
  }
  fit.status = solution.converged ? "fitted" : "not converged";
  return fit;
}

}  // namespace osteomill::identify
