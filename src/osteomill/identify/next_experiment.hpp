// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/identify/mean_force_fit.hpp"

namespace osteomill::identify {

/// A cut that would help, and what it would do.
struct SuggestedExperiment {
  Experiment experiment;              ///< condition and immersion; no forces
  std::string coefficient;            ///< the one that gains most
  double standard_error = 0.0;        ///< of it now, SI
  double standard_error_after = 0.0;  ///< with the cuts so far suggested, SI
};

/// Cuts, up to `count`, each the one out of a grid that lowers the standard errors of the
/// coefficients that are not determined most (sum of their logarithms), given those before it. The
/// grid: axial depths within and half beyond the tested ones, feeds from half the least to four
/// times the largest, slot and half immersion both ways. Means as exact as the present ones are
/// assumed; whether the machine can do it is not known here. Empty when all are determined.
std::vector<SuggestedExperiment> suggest_experiments(const std::vector<Experiment>& experiments,
                                                     const MeanForceFit& fit, int count = 3);

/// "a slot, 1 mm deep, at 0.012 mm a tooth"
std::string describe_cut(const Experiment& experiment);

}  // namespace osteomill::identify
