// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/numerics/distributions.hpp"
#include "osteomill/study/diagnostics.hpp"
#include "osteomill/study/measured_coverage.hpp"
#include "osteomill/study/slice.hpp"

namespace osteomill::study {
namespace {

std::vector<Factor> with_subject(const Slice& slice) {
  std::vector<Factor> all = groupings(slice);
  if (slice.subject) {
    all.push_back(*slice.subject);
    if (!slice.within.empty()) {
      std::vector<Factor> parts = slice.within;
      parts.insert(parts.begin(), *slice.subject);
      all.push_back(combined(parts, static_cast<int>(slice.y.size())));
    }
  }
  return all;
}

Interval scaled(const Interval& interval, double factor) {
  return {factor * interval.low, factor * interval.high};
}

/// Mean of each subject among the rows that are kept; without subjects the values themselves.
struct SubjectMeans {
  std::vector<double> mean;
  std::vector<int> subject;
};
SubjectMeans subject_means(const Slice& slice, const std::vector<bool>& keep) {
  SubjectMeans result;
  if (!slice.subject) {
    for (size_t i = 0; i < keep.size(); ++i) {
      if (keep[i]) result.mean.push_back(slice.y(static_cast<Eigen::Index>(i)));
    }
    return result;
  }
  for (size_t s = 0; s < slice.subject->levels.size(); ++s) {
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < keep.size(); ++i) {
      if (!keep[i] || slice.subject->level[i] != static_cast<int>(s)) continue;
      sum += slice.y(static_cast<Eigen::Index>(i));
      count += 1.0;
    }
    if (count == 0.0) continue;
    result.mean.push_back(sum / count);
    result.subject.push_back(static_cast<int>(s));
  }
  return result;
}

TestRecord record(const std::string& name, const Slice& slice, const std::string& term,
                  const TwoSampleTest& test, bool is_f) {
  TestRecord r{.name = name,
               .response = slice.response,
               .term = term,
               .statistic_name = is_f ? "F" : "t",
               .statistic = test.statistic,
               .df1 = test.df1,
               .df2 = {},
               .p = test.p,
               .corrections = {},
               .estimate = test.estimate,
               .interval = test.interval};
  if (is_f) r.df2 = test.df2;
  return r;
}

/// Tests that ask one question together: Holm's p beside each.
void add_family(std::vector<TestRecord> family, StudyReport& report) {
  std::vector<double> p;
  for (const TestRecord& test : family) p.push_back(test.p);
  const std::vector<double> adjusted = holm(p);
  for (size_t i = 0; i < family.size(); ++i) {
    if (family.size() > 1) {
      family[i].corrections.push_back(
          {"Holm", 1.0, family[i].df1, family[i].df2.value_or(0.0), adjusted[i]});
    }
    report.tests.push_back(std::move(family[i]));
  }
}

bool can_test(const std::vector<double>& values) {
  return values.size() >= 2 && *std::max_element(values.begin(), values.end()) >
                                   *std::min_element(values.begin(), values.end());
}

/// F-test of the pooled SDs and t-tests of the means between two levels of a factor.
struct Families {
  std::vector<TestRecord> variances, means, pooled_means;
};

void compare_levels(const Slice& slice, const Factor& factor, bool is_within, int a, int b,
                    Families& families, double confidence) {
  const std::vector<bool> in_a = rows_at(factor, a), in_b = rows_at(factor, b);
  const std::string term =
      fmt::format("{}: {} / {}", factor.name, factor.levels[a], factor.levels[b]);
  const Slice sa = subset(slice, in_a), sb = subset(slice, in_b);
  const std::vector<double> ya(sa.y.begin(), sa.y.end()), yb(sb.y.begin(), sb.y.end());
  const Moments va = pooled_within(ya, sa.cell.level), vb = pooled_within(yb, sb.cell.level);
  if (va.sd > 0.0 && vb.sd > 0.0) {
    families.variances.push_back(
        record("F-test of variances", slice, term, variance_ratio_test(va, vb, confidence), true));
  }
  const std::string difference =
      fmt::format("{}: {} - {}", factor.name, factor.levels[a], factor.levels[b]);
  const SubjectMeans ma = subject_means(slice, in_a), mb = subject_means(slice, in_b);
  if (is_within && slice.subject) {
    std::vector<double> paired;
    for (size_t i = 0; i < ma.subject.size(); ++i) {
      const auto other = std::find(mb.subject.begin(), mb.subject.end(), ma.subject[i]);
      if (other == mb.subject.end()) continue;
      paired.push_back(ma.mean[i] - mb.mean[static_cast<size_t>(other - mb.subject.begin())]);
    }
    if (can_test(paired)) {
      families.means.push_back(record("paired t-test", slice, difference,
                                      one_sample_t_test(moments(paired), 0.0, confidence), false));
    }
  } else if (can_test(ma.mean) && can_test(mb.mean)) {
    const Moments x = moments(ma.mean), y = moments(mb.mean);
    families.means.push_back(
        record("Welch t-test", slice, difference, welch_t_test(x, y, confidence), false));
    families.pooled_means.push_back(
        record("pooled t-test", slice, difference, pooled_t_test(x, y, confidence), false));
  }
}

/// Within one operator single cuts are the units: SD ratio and means of two techniques.
void compare_inside(const Slice& slice, const Factor& factor, int a, int b, Families& families,
                    double confidence) {
  for (size_t s = 0; s < slice.subject->levels.size(); ++s) {
    const Slice own = subset(slice, rows_at(*slice.subject, static_cast<int>(s)));
    const Factor& f = *std::find_if(own.within.begin(), own.within.end(),
                                    [&](const Factor& w) { return w.name == factor.name; });
    const auto find = [&](const std::string& level) {
      return static_cast<int>(std::find(f.levels.begin(), f.levels.end(), level) -
                              f.levels.begin());
    };
    const std::vector<double> ya = values_at(own, f, find(factor.levels[a]));
    const std::vector<double> yb = values_at(own, f, find(factor.levels[b]));
    // Two cuts make an SD of one degree of freedom: true, and of no use to anyone.
    if (ya.size() < 3 || yb.size() < 3 || !can_test(ya) || !can_test(yb)) continue;
    const Moments x = moments(ya), y = moments(yb);
    const std::string who = fmt::format(" | {} {}", slice.subject->name, slice.subject->levels[s]);
    families.variances.push_back(
        record("F-test of variances", slice,
               fmt::format("{}: {} / {}", factor.name, factor.levels[a], factor.levels[b]) + who,
               variance_ratio_test(x, y, confidence), true));
    families.means.push_back(
        record("Welch t-test", slice,
               fmt::format("{}: {} - {}", factor.name, factor.levels[a], factor.levels[b]) + who,
               welch_t_test(x, y, confidence), false));
  }
}

}  // namespace

void report_groups(const Slice& slice, StudyReport& report) {
  const double confidence = report.design.confidence;
  const int cuts = report.design.cuts_per_alignment;
  for (const Factor& factor : with_subject(slice)) {
    for (size_t k = 0; k < factor.levels.size(); ++k) {
      const Slice part = subset(slice, rows_at(factor, static_cast<int>(k)));
      const std::vector<double> y(part.y.begin(), part.y.end());
      const auto [low, high] = std::minmax_element(y.begin(), y.end());
      report.groups.push_back(
          {slice.response, factor.name, factor.levels[k], static_cast<int>(y.size()),
           std::accumulate(y.begin(), y.end(), 0.0) / static_cast<double>(y.size()),
           y.size() > 1 ? moments(y).sd : 0.0, *low, *high});
      const Moments pooled = pooled_within(y, part.cell.level);
      if (pooled.degrees_of_freedom < 1.0) continue;
      VariabilityRecord v{.response = slice.response,
                          .factor = factor.name,
                          .group = factor.levels[k],
                          .count = pooled.count,
                          .sd = pooled.sd,
                          .interval = sd_interval(pooled.sd, pooled.degrees_of_freedom, confidence),
                          .degrees_of_freedom = pooled.degrees_of_freedom,
                          .combined_sd = combined_sd(pooled.sd, cuts),
                          .combined_interval = {},
                          .coverage_if_not_normal = coverage_of_chi_squared(pooled.count),
                          .bootstrap_interval = {},
                          .bootstrap_coverage = {}};
      v.combined_interval = scaled(v.interval, combined_sd(1.0, cuts));
      if (pooled.degrees_of_freedom >= 5.0 && pooled.sd > 0.0) {
        v.bootstrap_interval = bootstrap_sd_interval(y, part.cell.level, report.design.seed,
                                                     report.design.bootstrap_draws, confidence);
        v.bootstrap_coverage = coverage_without_normality(pooled.count);
      }
      report.variability.push_back(std::move(v));
    }
  }
}

void report_forecasts(const Slice& slice, StudyReport& report) {
  if (unit_of(slice.response) != "deg") return;
  const Design& design = report.design;
  for (const Factor& factor : groupings(slice)) {
    for (size_t k = 0; k < factor.levels.size(); ++k) {
      const Slice part = subset(slice, rows_at(factor, static_cast<int>(k)));
      const std::vector<double> y(part.y.begin(), part.y.end());
      if (!can_test(y) || y.size() < 4) continue;
      const Population population =
          part.subject ? estimate_population(y, part.subject->level) : estimate_population(y, {});
      const ForecastOptions options{.limit = design.limit_deg,
                                    .content = design.tolerance_content,
                                    .confidence = design.confidence,
                                    .seed = design.seed,
                                    .draws = design.forecast_draws};
      report.forecasts.push_back({slice.response, factor.name, factor.levels[k], population,
                                  forecast(population, 1, options),
                                  forecast(population, design.cuts_per_alignment, options)});
    }
  }
}

void report_comparisons(const Slice& slice, StudyReport& report) {
  const double confidence = report.design.confidence;
  const auto compare = [&](const Factor& factor, bool is_within) {
    Families all, inside;
    const int levels = static_cast<int>(factor.levels.size());
    if (levels > 6)
      return;  // pairs of many levels say nothing that the analysis of variance does not
    for (int a = 0; a < levels; ++a) {
      for (int b = a + 1; b < levels; ++b) {
        compare_levels(slice, factor, is_within, a, b, all, confidence);
        if (is_within && slice.subject) compare_inside(slice, factor, a, b, inside, confidence);
      }
    }
    add_family(std::move(all.variances), report);
    add_family(std::move(all.means), report);
    add_family(std::move(all.pooled_means), report);
    add_family(std::move(inside.variances), report);
    add_family(std::move(inside.means), report);
  };
  for (const Factor& factor : slice.between) compare(factor, false);
  for (const Factor& factor : slice.within) compare(factor, true);

  if (!slice.subject || unit_of(slice.response) != "deg") return;
  // Bias of each operator with each technique: single cuts are the units.
  std::vector<Factor> parts = slice.within;
  parts.insert(parts.begin(), *slice.subject);
  const Factor cells = combined(parts, static_cast<int>(slice.y.size()));
  std::vector<TestRecord> family;
  for (size_t k = 0; k < cells.levels.size(); ++k) {
    const std::vector<double> y = values_at(slice, cells, static_cast<int>(k));
    if (y.size() < 3 || !can_test(y)) continue;
    family.push_back(record("bias t-test", slice, fmt::format("{} {}", cells.name, cells.levels[k]),
                            one_sample_t_test(moments(y), 0.0, confidence), false));
  }
  add_family(std::move(family), report);
}

void report_regressions(const Slice& slice, StudyReport& report) {
  const double confidence = report.design.confidence;
  for (const Factor& factor : groupings(slice)) {
    for (size_t k = 0; k < factor.levels.size(); ++k) {
      const Slice part = subset(slice, rows_at(factor, static_cast<int>(k)));
      for (const Covariate& covariate : part.covariates) {
        const double n = static_cast<double>(part.y.size());
        if (part.y.size() < 4) continue;
        const Eigen::VectorXd x = covariate.value.array() - covariate.value.mean();
        const Eigen::VectorXd y = part.y.array() - part.y.mean();
        const double sxx = x.squaredNorm(), sxy = x.dot(y), syy = y.squaredNorm();
        if (!(sxx > 0.0) || !(syy > 0.0)) continue;
        RegressionRecord r{.response = slice.response,
                           .covariate = covariate.name,
                           .factor = factor.name,
                           .group = factor.levels[k],
                           .count = static_cast<int>(n),
                           .slope = sxy / sxx,
                           .intercept = part.y.mean() - sxy / sxx * covariate.value.mean(),
                           .slope_interval = {},
                           .intercept_interval = {},
                           .r_squared = std::min(1.0, sxy * sxy / (sxx * syy)),
                           .r_squared_interval = {},
                           .p = 0.0,
                           .x = {covariate.value.begin(), covariate.value.end()},
                           .y = {part.y.begin(), part.y.end()}};
        const double variance = (y - r.slope * x).squaredNorm() / (n - 2.0);
        const double t = numerics::student_t_quantile(0.5 + 0.5 * confidence, n - 2.0);
        // With operators' own biases the cuts are not independent: line and intervals come from the
        // model with operators at random; r² and its interval stay those of the plain correlation.
        const std::optional<RandomLine> random = line_with_subjects(part, covariate, confidence);
        const double slope_error = std::sqrt(variance / sxx);
        const double intercept_error =
            std::sqrt(variance * (1.0 / n + covariate.value.mean() * covariate.value.mean() / sxx));
        r.slope_interval = {r.slope - t * slope_error, r.slope + t * slope_error};
        r.intercept_interval =
            Interval{r.intercept - t * intercept_error, r.intercept + t * intercept_error};
        if (random) {
          r.slope = random->slope.value;
          r.intercept = random->intercept;
          r.slope_interval = random->slope.interval;
          r.intercept_interval = random->intercept_interval;
          r.p = random->slope.p;
        }
        if (slope_error > 0.0) {
          if (!random) r.p = numerics::student_t_two_sided_p(r.slope / slope_error, n - 2.0);
          r.r_squared_interval =
              r_squared_interval(std::copysign(std::sqrt(r.r_squared), sxy), r.count, confidence);
        }
        report.regressions.push_back(std::move(r));
      }
    }
  }
}

}  // namespace osteomill::study
