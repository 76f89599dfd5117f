// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "osteomill/study/anova.hpp"
#include "osteomill/study/intervals.hpp"

/// Tests of what other tests assume, and what to use where they fail.
namespace osteomill::study {

struct DiagnosticTest {
  double statistic = 0.0;
  double df1 = 0.0;  ///< 0 where the test has none
  double df2 = 0.0;
  double p = 1.0;
};

/// Normality, Shapiro and Wilk by Royston's approximation (1995, AS R94), 3 <= n <= 5000.
DiagnosticTest shapiro_wilk(std::span<const double> values);

/// Equal variances of groups, Brown and Forsythe 1974: analysis of variance of the distances from
/// the group medians. Holds for samples that are not normal.
DiagnosticTest brown_forsythe(std::span<const double> values, std::span<const int> group);

/// Interval of a pooled within-cell SD without normality: Bonett's kurtosis-adjusted interval of
/// the log variance [bonett2006], with Student's quantile and medians [niwitpong2008]. What misses
/// for long tails is the upper end: it is raised to that of the studentised bootstrap of residuals
/// where this is higher. The lower end goes no further than normal errors in such cells ask for, by
/// simulation. Seeded.
Interval bootstrap_sd_interval(std::span<const double> values, std::span<const int> cell,
                               std::uint64_t seed, int draws = 2000, double confidence = 0.95);

/// p-values of the rows of analyse_variance without normality: whole subjects' residuals are drawn
/// again with replacement, and the share of draws whose F reaches the observed one is counted.
std::vector<double> bootstrap_anova_p(const RepeatedMeasures& data, const Anova& anova,
                                      SumOfSquares type, std::uint64_t seed, int draws = 999);

}  // namespace osteomill::study
