// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "osteomill/geometry/pose.hpp"
#include "osteomill/identify/force_model.hpp"

namespace osteomill::identify {

enum class Weighting {
  automatic,        ///< standard errors where every mean has one, otherwise equal
  equal,            ///< every newton counts the same
  standard_errors,  ///< each mean by 1/standard error
};

enum class Loss {
  squares,
  huber,  ///< linear beyond 1.345 standard deviations
  tukey,  ///< outliers beyond 4.685 standard deviations do not count
};

/// What a coefficient may be, SI.
struct Bound {
  std::string coefficient;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

struct FitOptions {
  Weighting weighting = Weighting::automatic;
  Loss loss = Loss::squares;
  /// Penalty on linear models: ridge × sum of (coefficient × norm of its weighted column)²; 1 is as
  /// much as the data. 0: none.
  double ridge = 0.0;
  std::vector<Bound> bounds;
  double confidence = 0.95;
};

struct Coefficient {
  std::string name;
  Dimension dimension = Dimension::number;
  double value = 0.0;           ///< SI
  double standard_error = 0.0;  ///< SI; 0 at a bound
  double low = 0.0;             ///< ends of the confidence interval, by Student's t
  double high = 0.0;
  bool at_bound = false;
  /// Whether the standard error is at most half the value.
  bool determined = false;
  /// What run-out that nobody measured may change the value by, SI: see run_out_knowledge.hpp.
  double shift_low = 0.0;
  double shift_high = 0.0;
};

/// A combination of coefficients that the forces hardly feel: a singular vector of the design
/// matrix with columns scaled to length 1.
struct WeakDirection {
  double relative_singular_value = 0.0;                ///< over the largest one
  std::vector<std::pair<std::string, double>> shares;  ///< in the scaled coefficients, large first
};

/// A fit to mean forces, with what can be said of it. Rows are experiments.
struct MeanForceFit {
  ForceModel model;
  std::vector<Coefficient> coefficients;
  Eigen::VectorXd values;          ///< of the coefficients, SI
  Eigen::MatrixXd covariance;      ///< SI
  Eigen::MatrixX3d predicted;      ///< N
  Eigen::MatrixX3d residual;       ///< measured less predicted, N
  geometry::Vector3 residual_rms;  ///< over the experiments, N
  double residual_rms_all = 0.0;   ///< over all values, N
  double degrees_of_freedom = 0.0;
  /// Standard deviation of a residual: N, or in standard errors when these are the weights.
  double residual_deviation = 0.0;
  bool weighted = false;  ///< by standard errors
  /// Of the design matrix with columns scaled to length 1, so that units do not matter.
  double condition_number = 0.0;
  double condition_number_unscaled = 0.0;  ///< coefficients in the units of unit_of()
  std::vector<WeakDirection> weak;         ///< singular values below 1 % of the largest
  Eigen::VectorXd leverage;                ///< trace of the experiment's block of the hat matrix
  Eigen::VectorXd cook_distance;           ///< influence of each experiment on all predictions
  Eigen::MatrixX3d robust_weight;          ///< 1 without robust loss
  std::string status = "not run";          ///< "fitted" when it ran and converged

  // What cross-validation goes on with.
  Eigen::MatrixXd sensitivity;  ///< 3n × p at the solution, N per SI unit
  Eigen::VectorXd ridge_scale;  ///< penalty of each coefficient
};

/// Least squares on the mean forces: x, y, z of every experiment. Throws InvalidInput when there
/// are too few experiments for the unknowns, when the experiments do not tell them apart (the
/// combination is named), or when a bound names no coefficient.
MeanForceFit fit_mean_forces(const std::vector<Experiment>& experiments, const ForceModel& model,
                             const FitOptions& options = {});

/// What may be wrong with the experiments themselves: standard errors of some means only, a force
/// that is not finite, no experiment.
void check(const std::vector<Experiment>& experiments, const FitOptions& options);

namespace detail {

/// One least-squares task: which means, how they count. Cross-validation makes them from parts.
struct FitTask {
  ForceModel model;
  std::vector<Experiment> experiments;
  Eigen::VectorXd measured;
  Eigen::VectorXd weight;   ///< of each mean: 1 or 1/standard error
  Eigen::MatrixXd columns;  ///< of a linear model
  Eigen::VectorXd ridge_scale;
  Eigen::VectorXd lower, upper;  ///< of the coefficients
  Loss loss = Loss::squares;
};

FitTask task_of(const std::vector<Experiment>& experiments, const ForceModel& model,
                const FitOptions& options);

/// The task with the experiments whose `keep` is true.
FitTask part_of(const FitTask& task, const std::vector<bool>& keep);

struct FitSolution {
  Eigen::VectorXd values;
  Eigen::MatrixXd sensitivity;
  std::vector<bool> at_bound;
  Eigen::VectorXd robust_weight;
  bool converged = false;
};

FitSolution solve(const FitTask& task, const Eigen::VectorXd& start);

/// Whether the means determine all coefficients that no bound holds: relative singular value above
/// 1e-9, or a ridge.
bool is_determined(const FitTask& task, const FitSolution& solution);

/// The hat matrix of the weighted means at a solution, ridge and robust weights included.
Eigen::MatrixXd hat_matrix(const FitTask& task, const FitSolution& solution);

}  // namespace detail
}  // namespace osteomill::identify
