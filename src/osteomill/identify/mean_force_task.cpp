// SPDX-License-Identifier: BSD-3-Clause
// The least-squares core of mean_force_fit.hpp.
#include <algorithm>
#include <cmath>

#include "osteomill/identify/mean_force_fit.hpp"
#include "osteomill/numerics/bounded_least_squares.hpp"
#include "osteomill/numerics/decompositions.hpp"

namespace osteomill::identify::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Laws that the means determine take some ten; the others wander along a valley.
constexpr int kMostIterations = 60;

bool has_bounds(const FitTask& task) {
  return (task.lower.array() > -1e300).any() || (task.upper.array() < 1e300).any();
}

/// Rows that pull the coefficients towards zero.
MatrixXd ridge_rows(const FitTask& task) { return task.ridge_scale.asDiagonal(); }

bool has_ridge(const FitTask& task) { return (task.ridge_scale.array() > 0.0).any(); }

/// The weighted design with the rows of the ridge below it, and the weighted means over zeros.
std::pair<MatrixXd, VectorXd> augmented(const FitTask& task, const VectorXd& robust) {
  const VectorXd w = task.weight.cwiseProduct(robust.cwiseSqrt());
  const Index rows = task.columns.rows();
  const Index extra = has_ridge(task) ? task.columns.cols() : 0;
  MatrixXd a(rows + extra, task.columns.cols());
  VectorXd y = VectorXd::Zero(rows + extra);
  a.topRows(rows) = w.asDiagonal() * task.columns;
  y.head(rows) = w.cwiseProduct(task.measured);
  if (extra > 0) a.bottomRows(extra) = ridge_rows(task);
  return {a, y};
}

/// Minimum-norm least squares with columns scaled to length 1.
VectorXd linear_solution(const MatrixXd& a, const VectorXd& y) {
  VectorXd scale = a.colwise().norm();
  for (double& s : scale) s = s > 0.0 ? s : 1.0;
  const MatrixXd scaled = a * scale.cwiseInverse().asDiagonal();
  const VectorXd x =
      Eigen::JacobiSVD<MatrixXd>(scaled, Eigen::ComputeThinU | Eigen::ComputeThinV).solve(y);
  return x.cwiseQuotient(scale);
}

/// With given robust weights.
FitSolution solve_weighted(const FitTask& task, const VectorXd& start, const VectorXd& robust) {
  FitSolution solution;
  solution.robust_weight = robust;
  solution.at_bound.assign(static_cast<std::size_t>(start.size()), false);
  numerics::LeastSquaresProblem problem;
  problem.lower = task.lower;
  problem.upper = task.upper;
  if (is_linear(task.model)) {
    const auto [a, y] = augmented(task, robust);
    solution.sensitivity = task.columns;
    solution.values = linear_solution(a, y);
    solution.converged = true;
    const bool inside = (solution.values.array() >= task.lower.array()).all() &&
                        (solution.values.array() <= task.upper.array()).all();
    if (!has_bounds(task) || inside) return solution;
    problem.residual = [&](const VectorXd& x) -> VectorXd { return a * x - y; };
    problem.jacobian = [&](const VectorXd&) -> MatrixXd { return a; };
    const auto summary = numerics::solve_least_squares(problem, solution.values);
    solution.values = summary.x;
    solution.at_bound = summary.at_bound;
    solution.converged = summary.converged;
    return solution;
  }
  const VectorXd w = task.weight.cwiseProduct(robust.cwiseSqrt());
  problem.residual = [&](const VectorXd& x) -> VectorXd {
    return w.cwiseProduct(mean_forces(law_of(task.model, x), task.experiments) - task.measured);
  };
  const auto summary =
      numerics::solve_least_squares(problem, start, {.most_iterations = kMostIterations});
  solution.values = summary.x;
  solution.at_bound = summary.at_bound;
  solution.converged = summary.converged;
  solution.sensitivity = sensitivities(task.model, summary.x, task.experiments);
  return solution;
}

VectorXd weighted_residual(const FitTask& task, const FitSolution& solution) {
  const VectorXd predicted =
      is_linear(task.model) ? VectorXd(task.columns * solution.values)
                            : mean_forces(law_of(task.model, solution.values), task.experiments);
  return task.weight.cwiseProduct(task.measured - predicted);
}

/// Of residuals over their scale; Huber 1964, Beaton and Tukey 1974, 95 % efficient on normal ones.
double robust_weight(Loss loss, double u) {
  if (loss == Loss::huber) return std::abs(u) <= 1.345 ? 1.0 : 1.345 / std::abs(u);
  const double share = u / 4.685;
  return std::abs(share) < 1.0 ? std::pow(1.0 - share * share, 2.0) : 0.0;
}

double median_deviation(VectorXd r) {
  r = r.cwiseAbs();
  std::sort(r.begin(), r.end());
  const Index n = r.size();
  return 1.4826 * 0.5 * (r((n - 1) / 2) + r(n / 2));
}

/// Iteratively reweighted least squares, the scale from the median deviation.
FitSolution reweighted(const FitTask& task, Loss loss, FitSolution solution) {
  for (int i = 0; i < 200; ++i) {
    const VectorXd residual = weighted_residual(task, solution);
    const double scale = median_deviation(residual);
    if (scale <= 0.0) return solution;  // half the means are met exactly
    const VectorXd robust =
        residual.unaryExpr([&](double r) { return robust_weight(loss, r / scale); });
    FitSolution next = solve_weighted(task, solution.values, robust);
    const VectorXd size = next.values.cwiseAbs().cwiseMax(solution.values.cwiseAbs());
    const bool settled =
        ((next.values - solution.values).cwiseAbs().array() <= 1e-9 * size.array()).all();
    solution = std::move(next);
    if (settled) return solution;
  }
  solution.converged = false;
  return solution;
}

/// Weighted and scaled columns of the coefficients that no bound holds.
MatrixXd free_columns(const FitTask& task, const FitSolution& solution) {
  const VectorXd w = task.weight.cwiseProduct(solution.robust_weight.cwiseSqrt());
  MatrixXd columns(solution.sensitivity.rows(), 0);
  for (Index i = 0; i < solution.values.size(); ++i) {
    if (solution.at_bound[static_cast<std::size_t>(i)]) continue;
    columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
    columns.col(columns.cols() - 1) = w.cwiseProduct(solution.sensitivity.col(i));
  }
  return columns;
}

}  // namespace

FitTask part_of(const FitTask& task, const std::vector<bool>& keep) {
  FitTask part = task;
  part.experiments.clear();
  std::vector<Index> rows;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    part.experiments.push_back(task.experiments[i]);
    for (Index c = 0; c < 3; ++c) rows.push_back(3 * static_cast<Index>(i) + c);
  }
  part.measured = task.measured(rows).eval();
  part.weight = task.weight(rows).eval();
  if (task.columns.rows() > 0) part.columns = task.columns(rows, Eigen::all).eval();
  return part;
}

FitSolution solve(const FitTask& task, const VectorXd& start) {
  FitSolution solution = solve_weighted(task, start, VectorXd::Ones(task.measured.size()));
  if (task.loss == Loss::squares) return solution;
  // Tukey's loss has valleys: it starts from Huber's, which has one.
  solution = reweighted(task, Loss::huber, solution);
  return task.loss == Loss::huber ? solution : reweighted(task, Loss::tukey, solution);
}

bool is_determined(const FitTask& task, const FitSolution& solution) {
  if (has_ridge(task)) return true;
  MatrixXd columns = free_columns(task, solution);
  if (columns.cols() == 0) return true;
  if (columns.rows() < columns.cols()) return false;
  const VectorXd scale = columns.colwise().norm();
  if ((scale.array() <= 0.0).any()) return false;
  columns = columns * scale.cwiseInverse().asDiagonal();
  const VectorXd singular = Eigen::JacobiSVD<MatrixXd>(columns).singularValues();
  return singular(singular.size() - 1) > 1e-9 * singular(0);
}

MatrixXd hat_matrix(const FitTask& task, const FitSolution& solution) {
  const MatrixXd columns = free_columns(task, solution);
  if (!has_ridge(task)) {
    VectorXd scale = columns.colwise().norm();
    const MatrixXd scaled = columns * scale.cwiseInverse().asDiagonal();
    const MatrixXd u =
        Eigen::JacobiSVD<MatrixXd>(scaled, Eigen::ComputeThinU | Eigen::ComputeThinV).matrixU();
    return u * u.transpose();
  }
  MatrixXd a(columns.rows() + columns.cols(), columns.cols());
  VectorXd penalty(columns.cols());
  Index at = 0;
  for (Index i = 0; i < solution.values.size(); ++i) {
    if (!solution.at_bound[static_cast<std::size_t>(i)]) penalty(at++) = task.ridge_scale(i);
  }
  a << columns, MatrixXd(penalty.asDiagonal());
  const MatrixXd u =
      Eigen::JacobiSVD<MatrixXd>(a, Eigen::ComputeThinU | Eigen::ComputeThinV).matrixU();
  const MatrixXd top = u.topRows(columns.rows());
  return top * top.transpose();
}

}  // namespace osteomill::identify::detail
