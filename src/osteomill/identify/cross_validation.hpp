// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/identify/mean_force_fit.hpp"

namespace osteomill::identify {

/// Experiments that are left out together.
using Fold = std::vector<std::size_t>;

/// Each experiment by itself: its three forces come from one cut and go together.
std::vector<Fold> leave_one_out(const std::vector<Experiment>& experiments);
/// All experiments of a group; empty when fewer than two groups are named.
std::vector<Fold> leave_one_group_out(const std::vector<Experiment>& experiments);

/// Errors of predictions for cuts that the fit has not seen.
struct CrossValidation {
  /// Measured less predicted, N; unset where the others do not determine the model.
  std::vector<std::optional<geometry::Vector3>> error;
  bool complete = false;  ///< every error is there
  double rms = 0.0;       ///< over all values, N; of those that are there
  geometry::Vector3 rms_xyz = geometry::Vector3::Zero();
  std::vector<std::string> undetermined;  ///< experiments without prediction
};

/// Linear models under least squares by the hat matrix, e_i of a fold = (1 - H_ii)^-1 e (exact:
/// Cook and Weisberg 1982); bounds, robust losses and other laws by fitting again.
CrossValidation cross_validate(const std::vector<Experiment>& experiments, const MeanForceFit& fit,
                               const FitOptions& options, const std::vector<Fold>& folds);

/// The same by fitting again without each fold, whatever the model.
CrossValidation cross_validate_by_refit(const std::vector<Experiment>& experiments,
                                        const MeanForceFit& fit, const FitOptions& options,
                                        const std::vector<Fold>& folds);

}  // namespace osteomill::identify
