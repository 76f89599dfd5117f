// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

/// Sample size of a study that is still to be made. Differences and SDs in any one unit.
namespace osteomill::study {

enum class PlanQuestion {
  kMeansPaired,   ///< two techniques, every operator uses both: difference of the means
  kMeansGroups,   ///< two groups of operators: difference of the means
  kSdRatio,       ///< two techniques: ratio of their SDs, F-test on pooled within-operator SDs
  kSdPrecision,   ///< one technique: its SD to a relative half-width
  kShareOutside,  ///< one technique: show that no more than a share lies outside +- limit
};

struct PlanOptions {
  PlanQuestion question = PlanQuestion::kMeansPaired;
  double difference = 0.0;                ///< means: the least difference worth finding
  double within_operator_sd = 1.0;        ///< cut to cut
  double between_operator_sd = 0.0;       ///< groups: of the operators' own means
  double operator_by_technique_sd = 0.0;  ///< paired: of the operators' own differences
  double sd_ratio = 0.5;                  ///< SD ratio: new over old, not 1
  double relative_half_width = 0.2;       ///< SD precision: of the interval, upper end over SD - 1
  double limit = 3.0;                     ///< share outside
  double mean = 0.0;                      ///< share outside: expected bias
  double largest_share = 0.05;            ///< share outside: to be shown
  int cuts_per_operator = 8;              ///< with each technique
  double alpha = 0.05;                    ///< two-sided
  double power = 0.9;
  int most_operators = 1000;
};

struct PlanPoint {
  int operators = 0;   ///< in each group for kMeansGroups
  int cuts = 0;        ///< of the whole study
  double power = 0.0;  ///< SD precision: share of studies that reach the half-width
};

struct Plan {
  bool feasible = false;
  std::string reason = "not run";
  PlanPoint least;               ///< the smallest study that reaches the power
  std::vector<PlanPoint> curve;  ///< from one operator (or the fewest that can be tested) on
};

/// Power of one study.
PlanPoint plan_point(const PlanOptions& options, int operators);

/// The least number of operators. Throws InvalidInput for options out of range.
Plan plan_study(const PlanOptions& options);

}  // namespace osteomill::study
