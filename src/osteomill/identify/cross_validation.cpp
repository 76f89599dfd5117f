// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/cross_validation.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "osteomill/numerics/decompositions.hpp"

namespace osteomill::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<bool> without(std::size_t count, const Fold& fold) {
  std::vector<bool> keep(count, true);
  for (const std::size_t i : fold) keep[i] = false;
  return keep;
}

void summarise(const std::vector<Experiment>& experiments, CrossValidation& result) {
  geometry::Vector3 square = geometry::Vector3::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    if (!result.error[i]) {
      result.undetermined.push_back(experiments[i].name);
      continue;
    }
    square += result.error[i]->cwiseAbs2();
    count += 1.0;
  }
  result.complete = result.undetermined.empty() && count > 0.0;
  if (count == 0.0) return;
  result.rms_xyz = (square / count).cwiseSqrt();
  result.rms = std::sqrt(square.sum() / (3.0 * count));
}

}  // namespace

std::vector<Fold> leave_one_out(const std::vector<Experiment>& experiments) {
  std::vector<Fold> folds;
  for (std::size_t i = 0; i < experiments.size(); ++i) folds.push_back({i});
  return folds;
}

std::vector<Fold> leave_one_group_out(const std::vector<Experiment>& experiments) {
  std::map<std::string, Fold> groups;
  for (std::size_t i = 0; i < experiments.size(); ++i) groups[experiments[i].group].push_back(i);
  std::vector<Fold> folds;
  for (const auto& [name, fold] : groups) folds.push_back(fold);
  if (folds.size() < 2) folds.clear();
  return folds;
}

CrossValidation cross_validate_by_refit(const std::vector<Experiment>& experiments,
                                        const MeanForceFit& fit, const FitOptions& options,
                                        const std::vector<Fold>& folds) {
  const detail::FitTask task = detail::task_of(experiments, fit.model, options);
  CrossValidation result;
  result.error.resize(experiments.size());
  for (const Fold& fold : folds) {
    const detail::FitTask part = detail::part_of(task, without(experiments.size(), fold));
    if (part.experiments.empty()) continue;
    const detail::FitSolution solution = detail::solve(part, fit.values);
    if (!solution.converged || !detail::is_determined(part, solution)) continue;
    for (const std::size_t i : fold) {
      const Index row = 3 * static_cast<Index>(i);
      const VectorXd predicted =
          is_linear(fit.model) ? VectorXd(task.columns.middleRows(row, 3) * solution.values)
                               : mean_forces(law_of(fit.model, solution.values), {experiments[i]});
      result.error[i] = task.measured.segment<3>(row) - predicted;
    }
  }
  summarise(experiments, result);
  return result;
}

CrossValidation cross_validate(const std::vector<Experiment>& experiments, const MeanForceFit& fit,
                               const FitOptions& options, const std::vector<Fold>& folds) {
  if (!is_linear(fit.model) || options.loss != Loss::squares || !options.bounds.empty()) {
    return cross_validate_by_refit(experiments, fit, options, folds);
  }
  const detail::FitTask task = detail::task_of(experiments, fit.model, options);
  detail::FitSolution solution;
  solution.values = fit.values;
  solution.sensitivity = task.columns;
  solution.robust_weight = VectorXd::Ones(task.measured.size());
  solution.at_bound.assign(static_cast<std::size_t>(fit.values.size()), false);
  const MatrixXd hat = detail::hat_matrix(task, solution);
  const VectorXd residual = task.weight.cwiseProduct(task.measured - task.columns * fit.values);
  CrossValidation result;
  result.error.resize(experiments.size());
  for (const Fold& fold : folds) {
    std::vector<Index> rows;
    for (const std::size_t i : fold) {
      for (Index c = 0; c < 3; ++c) rows.push_back(3 * static_cast<Index>(i) + c);
    }
    const auto size = static_cast<Index>(rows.size());
    const Eigen::ColPivHouseholderQR<MatrixXd> rest(MatrixXd::Identity(size, size) -
                                                    MatrixXd(hat(rows, rows)));
    // 1 - H is singular exactly when the rest does not determine the model.
    const VectorXd diagonal = rest.matrixR().diagonal().cwiseAbs();
    if (diagonal.minCoeff() < 1e-9) continue;
    const VectorXd error = rest.solve(VectorXd(residual(rows)));
    for (std::size_t k = 0; k < fold.size(); ++k) {
      const Index row = 3 * static_cast<Index>(fold[k]);
      result.error[fold[k]] =
          error.segment<3>(3 * static_cast<Index>(k)).cwiseQuotient(task.weight.segment<3>(row));
    }
  }
  summarise(experiments, result);
  return result;
}

}  // namespace osteomill::identify
