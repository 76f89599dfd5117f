// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "osteomill/study/mixed_model.hpp"

/// Intervals of variance components that hold the truth as often where a component is nothing as
/// where it is large.
namespace osteomill::study {

struct ComponentIntervalOptions {
  double confidence = 0.95;
  std::uint64_t seed = 1;
  int draws = 199;  ///< simulated studies for each value that is tried
};

/// Of the SD of each random factor, in order, then of the residual.
///
/// A value v is inside where the restricted likelihood ratio of "the component is v" to "any" is
/// within the `confidence` quantile of what it is in studies simulated from v and, for the other
/// components, from their restricted estimates given v: a Monte Carlo test turned round, whose
/// level does not depend on the number of draws. At v = 0 this quantile is far below chi2_1's, for
/// the estimate can only lie on one side: [crainiceanu2004] for one component. That values are
/// ordered by the likelihood ratio, and so that the interval passes by itself from one limit to
/// two, is [feldman1998]; that nuisances are put in by their estimates, [chuang2000].
std::vector<Interval> component_intervals(const MixedModelData& data,
                                          const ComponentIntervalOptions& options = {});

/// Whether each of these SDs lies inside, by the one test that it needs: for simulated studies.
std::vector<bool> component_intervals_hold(const MixedModelData& data,
                                           const std::vector<double>& sd,
                                           const ComponentIntervalOptions& options = {});

}  // namespace osteomill::study
