// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "osteomill/identify/cross_validation.hpp"
#include "osteomill/identify/run_out_knowledge.hpp"

namespace osteomill::identify {

/// A model that took part in the comparison.
struct Candidate {
  ForceModel model;
  std::string name;
  int unknowns = 0;
  std::optional<MeanForceFit> fit;             ///< unset: could not be fitted
  std::optional<CrossValidation> leave_one;    ///< each experiment out
  std::optional<CrossValidation> leave_group;  ///< each group out; unset without groups
  std::string not_ranked;                      ///< why not; empty: ranked
  std::string remedy = "measure more cuts or choose a smaller model";  ///< where not ranked
  /// Mean over the folds of its squared error less that of the best, summed over x, y, z, N², and
  /// the standard error of that mean.
  double excess = 0.0;
  double excess_error = 0.0;
  bool tied = false;    ///< with the best: the excess is within its standard error
  bool chosen = false;  ///< the fewest unknowns among the best and what ties with it
};

enum class RankBy { leave_one_out, leave_one_group_out };

struct SelectionOptions {
  FitOptions fit;
  RankBy rank_by = RankBy::leave_one_out;
  int largest_shear_order = 3;  ///< of the models that "auto" tries on rounded cutters
  int largest_edge_order = 3;
  /// A model that is judged in words beside the chosen one, ranked or not.
  std::optional<ForceModel> reference = {};
  RunOutKnowledge run_out = {};  ///< that the experiments were made with
};

/// The models that are worth trying on these experiments: on cutters whose kappa varies
/// polynomials of all orders; on cylinders constants, and laws along and across the fibres; on both
/// power and log laws.
std::vector<ForceModel> models_to_try(const std::vector<Experiment>& experiments,
                                      const SelectionOptions& options);

/// Fits and cross-validates every model; ranked ones first, by the error of prediction, then those
/// that could not be ranked with the reason. Throws InvalidInput with all reasons when none could.
std::vector<Candidate> rank_models(const std::vector<Experiment>& experiments,
                                   const std::vector<ForceModel>& models,
                                   const SelectionOptions& options);

}  // namespace osteomill::identify
