// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/study/analysis.hpp"

/// Inside of analyse_study: the rows that one response has, and the parts of the report that each
/// source file of the analysis writes.
namespace osteomill::study {

struct Slice {
  std::string response;
  Eigen::VectorXd y;
  std::vector<Factor> between;
  std::vector<Factor> within;
  std::vector<Factor> blocks;
  std::vector<Factor> random;  ///< beside the subject
  std::optional<Factor> subject;
  std::vector<Covariate> covariates;  ///< complete in every row of the slice
  Factor cell;                        ///< of the exclusive means
  std::vector<int> lines;

  std::vector<Factor> factors() const;  ///< between and within
};

/// The rows of the slice for which keep[i] is true; levels that no row has are left out.
Slice subset(const Slice& slice, const std::vector<bool>& keep);
Factor subset(const Factor& factor, const std::vector<bool>& keep);

/// One factor whose levels are the combinations that occur; "all" for none.
Factor combined(const std::vector<Factor>& factors, int rows);

/// The groupings that results are given for: all, each factor, their combination.
std::vector<Factor> groupings(const Slice& slice);

/// Values of y in the rows where the factor has this level.
std::vector<double> values_at(const Slice& slice, const Factor& factor, int level);
std::vector<bool> rows_at(const Factor& factor, int level);

/// Whether the residuals about exclusive means look normal; nothing where no cell repeats.
std::optional<bool> report_normality(const Slice& slice, StudyReport& report);
/// Analyses of variance and covariance, the mixed model's tests. Where no cell repeats, the
/// residuals of the analysis of variance are tested for normality.
void report_anova(const Slice& slice, std::optional<bool> normal, StudyReport& report);
void report_mixed_model(const Slice& slice, StudyReport& report);
void report_covariance(const Slice& slice, StudyReport& report);
void report_contributions(const Slice& slice, const Slice& with_movement, StudyReport& report);

/// Straight line and adjusted means where operators' cuts repeat: operators at random, so that an
/// interval is that of other operators too, not of these few. Nothing where no operator repeats.
struct RandomLine {
  MixedModelEstimate slope;
  double intercept = 0.0;
  std::optional<Interval> intercept_interval;  ///< unset: two operators, nothing left for the slope
};
std::optional<RandomLine> line_with_subjects(const Slice& slice, const Covariate& covariate,
                                             double confidence);
std::vector<AdjustedMean> adjusted_means_with_subjects(const Slice& slice, double confidence);

/// Groups, pooled SDs, forecasts, two-sample tests, regressions.
void report_groups(const Slice& slice, StudyReport& report);
void report_forecasts(const Slice& slice, StudyReport& report);
void report_comparisons(const Slice& slice, StudyReport& report);
void report_regressions(const Slice& slice, StudyReport& report);

}  // namespace osteomill::study
