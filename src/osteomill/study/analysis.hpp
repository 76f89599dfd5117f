// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/base/progress.hpp"
#include "osteomill/study/anova.hpp"
#include "osteomill/study/forecast.hpp"
#include "osteomill/study/intervals.hpp"
#include "osteomill/study/measured_coverage.hpp"
#include "osteomill/study/mixed_model.hpp"
#include "osteomill/study/table.hpp"

/// From the table of a study and its design to everything the report says.
namespace osteomill::study {

struct Design {
  std::vector<std::string> between;     ///< factors that differ between subjects
  std::vector<std::string> within;      ///< factors that every subject meets at each level
  std::vector<std::string> blocks;      ///< additive nuisance factors
  std::vector<std::string> covariates;  ///< a column guide_movement_X goes with response X alone
  std::vector<std::string> responses;
  std::vector<std::string> random;  ///< further random factors; specimen is taken by itself
  std::vector<std::string> exclusive_means;  ///< cells of the pooled SD
  std::string subject = "operator";
  SumOfSquares sum_of_squares = SumOfSquares::kII;
  double confidence = 0.95;
  double alpha = 0.05;                           ///< an assumption with p below it has failed
  double limit_deg = 3.0;                        ///< alignment window, [plaskos2002] 2.4
  int cuts_per_alignment = 2;                    ///< tibia and femur
  double tolerance_content = 0.95;               ///< share of cuts that a tolerance interval holds
  std::map<std::string, double> measurement_sd;  ///< by response, from repeated placements
  std::uint64_t seed = 1;
  int bootstrap_draws = 2000;
  int forecast_draws = 10000;
  int component_draws = 199;  ///< simulated studies for each value tried of a component's interval
};

/// What the columns of the table suggest where the design says nothing: the two errors and the time
/// as responses, group as between, technique and guide as within factors when they vary.
Design complete_design(const Design& design, const Table& table, std::vector<Finding>& findings);

struct TestRecord {
  std::string name;  ///< "repeated-measures ANOVA", "F-test of variances", ...
  std::string response;
  std::string term;
  std::string statistic_name;  ///< F or t
  double statistic = 0.0;
  double df1 = 0.0;
  std::optional<double> df2;  ///< none for t
  double p = 1.0;
  std::vector<Correction> corrections;
  std::optional<double> estimate;    ///< difference of means, ratio of variances
  std::optional<Interval> interval;  ///< of the estimate
};

struct AssumptionRecord {
  std::string name;
  std::string response;
  std::string term;
  bool holds = true;
  double statistic = 0.0;
  double p = 1.0;
  std::string consequence;  ///< what it means for the results, when it fails
};

struct GroupSummary {
  std::string response;
  std::string factor;
  std::string group;
  int count = 0;
  double mean = 0.0;
  double sd = 0.0;  ///< about the group's own mean
  double low = 0.0;
  double high = 0.0;
};

struct VariabilityRecord {
  std::string response;
  std::string factor;  ///< "all", "technique", "operator", "group × technique"
  std::string group;
  int count = 0;
  double sd = 0.0;    ///< residuals about exclusive means
  Interval interval;  ///< chi-squared: of normal errors
  double degrees_of_freedom = 0.0;
  double combined_sd = 0.0;  ///< of an alignment of several cuts
  Interval combined_interval;
  std::optional<CoverageRange> coverage_if_not_normal;  ///< of the chi-squared interval, measured
  /// Without normality. It is given whether or not the residuals look normal: chosen by that test,
  /// the two together would hold the truth too seldom where few cuts hide long tails.
  std::optional<Interval> bootstrap_interval;
  std::optional<CoverageRange> bootstrap_coverage;  ///< as measured for so many cuts
};

/// What the population of such cuts will do, operators included.
struct ForecastRecord {
  std::string response;
  std::string factor;
  std::string group;
  Population population;
  Forecast one_cut;
  Forecast alignment;  ///< of several cuts: means add, SDs by the root
};

struct RegressionRecord {
  std::string response;
  std::string covariate;
  std::string factor;
  std::string group;
  int count = 0;
  double slope = 0.0;
  double intercept = 0.0;
  Interval slope_interval;
  /// Unset for two operators whose cuts leave nothing for the slope.
  std::optional<Interval> intercept_interval;
  double r_squared = 0.0;
  std::optional<Interval> r_squared_interval;
  double p = 1.0;
  std::vector<double> x, y;  ///< the points
};

struct ContributionRecord {
  std::string response;
  std::string source;  ///< operator, specimen, guide movement, measurement, cut
  double variance = 0.0;
  double share = 0.0;
};

struct ComponentRecord {
  std::string response;
  VarianceComponent component;
};

struct AdjustedMeanRecord {
  std::string response;
  AdjustedMean adjusted;
};

/// What qualifies every report, with its numbers: a test of normality on few cuts proves little.
std::string normality_note();

struct StudyReport {
  Design design;  ///< as used
  int rows = 0;
  std::vector<Finding> findings;
  std::vector<TestRecord> tests;
  std::vector<AssumptionRecord> assumptions;
  std::vector<GroupSummary> groups;
  std::vector<VariabilityRecord> variability;
  std::vector<ForecastRecord> forecasts;
  std::vector<RegressionRecord> regressions;
  std::vector<ComponentRecord> components;
  std::vector<ContributionRecord> contributions;
  std::vector<AdjustedMeanRecord> adjusted_means;
};

/// Throws InvalidInput for what makes the table unusable (all faults at once); what only narrows
/// the answer is a Finding that says what could still be computed.
StudyReport analyse_study(Table table, const Design& design, const Progress& progress = {});

}  // namespace osteomill::study
