// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "osteomill/identify/axes_check.hpp"
#include "osteomill/identify/model_selection.hpp"
#include "osteomill/identify/next_experiment.hpp"

namespace osteomill::identify {

/// All that mean forces say: the models compared, the one that is chosen, and a verdict in words.
struct MeanForceIdentification {
  std::vector<Candidate> candidates;   ///< in the order of rank_models
  std::size_t chosen = 0;              ///< index among them
  std::optional<Candidate> reference;  ///< the one of the options; otherwise, when it was tried and
                                       ///< not chosen, the cubic of [tian2023]
  AxesCheck axes;
  std::vector<SuggestedExperiment> suggested;
  RunOutKnowledge run_out;  ///< that the fits allow for
  /// What the data determine and what not, which cuts stand out, which would help; a sentence each.
  std::vector<std::string> verdict;
  std::vector<std::string> warnings;

  const Candidate& best() const { return candidates[chosen]; }
};

/// Compares the models; one model alone is fitted and judged as well.
MeanForceIdentification identify_mean_forces(const std::vector<Experiment>& experiments,
                                             const std::vector<ForceModel>& models,
                                             const SelectionOptions& options = {});

}  // namespace osteomill::identify
