// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/study/diagnostics.hpp"
#include "osteomill/study/measured_coverage.hpp"
#include "osteomill/study/slice.hpp"

namespace osteomill::study {
namespace {

void add_rows(const std::string& name, const Slice& slice, const std::vector<AnovaRow>& rows,
              StudyReport& report) {
  for (const AnovaRow& row : rows) {
    report.tests.push_back({.name = name,
                            .response = slice.response,
                            .term = row.term,
                            .statistic_name = "F",
                            .statistic = row.f,
                            .df1 = row.df1,
                            .df2 = row.df2,
                            .p = row.p,
                            .corrections = row.corrections,
                            .estimate = {},
                            .interval = {}});
  }
}

void add_aliased(const Slice& slice, const Anova& anova, StudyReport& report) {
  for (const std::string& term : anova.aliased) {
    report.findings.push_back(
        {fmt::format("{}: {} cannot be told from the other terms", slice.response, term),
         "it is left out; the other terms are tested",
         {}});
  }
}

void add_sphericity(const Slice& slice, const Anova& anova, StudyReport& report) {
  for (const Sphericity& s : anova.sphericity) {
    if (!s.tested) {
      report.findings.push_back(
          {fmt::format("{}: too few subjects to test sphericity of {}", slice.response, s.term),
           "read its Greenhouse-Geisser p",
           {}});
      continue;
    }
    const bool holds = s.p >= report.design.alpha;
    report.assumptions.push_back(
        {"sphericity (Mauchly)", slice.response, s.term, holds, s.w, s.p,
         holds ? ""
               : fmt::format("read the Greenhouse-Geisser p of {} in place of the plain one",
                             s.term)});
  }
}

bool add_normality(const Slice& slice, const char* term, std::span<const double> residuals,
                   StudyReport& report) {
  const DiagnosticTest test = shapiro_wilk(residuals);
  const bool holds = test.p >= report.design.alpha;
  report.assumptions.push_back(
      {"normal residuals (Shapiro-Wilk)", slice.response, term, holds, test.statistic, test.p,
       holds ? ""
             : fmt::format("do not rely on chi-squared intervals, F-tests of variances, shares "
                           "outside and tolerance intervals; read the intervals without normality, "
                           "the bootstrap p and Brown-Forsythe ({})",
                           kCoverageIfNotNormal)});
  return holds;
}

/// Means of the cells subject x within-combination. NaN never leaves: incomplete subjects are named
/// and left out before anything is computed.
struct CellMeans {
  Eigen::MatrixXd mean;  ///< subjects x cells
  Eigen::MatrixXi count;
  Factor cells;
  std::vector<size_t> first_row_of_subject;
  std::vector<size_t> first_row_of_cell;
};

CellMeans cell_means(const Slice& slice) {
  CellMeans c;
  const int rows = static_cast<int>(slice.y.size());
  c.cells = combined(slice.within, rows);
  const auto subjects = static_cast<Eigen::Index>(slice.subject->levels.size());
  const auto cells = static_cast<Eigen::Index>(c.cells.levels.size());
  c.mean = Eigen::MatrixXd::Zero(subjects, cells);
  c.count = Eigen::MatrixXi::Zero(subjects, cells);
  c.first_row_of_subject.resize(static_cast<size_t>(subjects));
  c.first_row_of_cell.resize(static_cast<size_t>(cells));
  for (int i = rows - 1; i >= 0; --i) {
    const int s = slice.subject->level[i], k = c.cells.level[i];
    c.mean(s, k) += slice.y(i);
    ++c.count(s, k);
    c.first_row_of_subject[s] = static_cast<size_t>(i);
    c.first_row_of_cell[k] = static_cast<size_t>(i);
  }
  c.mean.array() /= c.count.cast<double>().array().max(1.0);
  return c;
}

Factor picked(const Factor& factor, const std::vector<size_t>& rows) {
  Factor result{factor.name, factor.levels, {}};
  for (const size_t row : rows) result.level.push_back(factor.level[row]);
  return subset(result, std::vector<bool>(rows.size(), true));
}

void analyse_in_blocks(const Slice& slice, const CellMeans& c, const std::string& why,
                       StudyReport& report) {
  std::vector<double> y;
  std::vector<size_t> rows;
  for (size_t i = 0; i < slice.cell.level.size(); ++i) {
    const int s = slice.subject->level[i], k = c.cells.level[i];
    const bool first = std::none_of(rows.begin(), rows.end(), [&](size_t r) {
      return slice.subject->level[r] == s && c.cells.level[r] == k;
    });
    if (!first) continue;
    rows.push_back(i);
    y.push_back(c.mean(s, k));
  }
  std::vector<Factor> factors;
  for (const Factor& f : slice.within) factors.push_back(picked(f, rows));
  const Anova anova = analyse_blocks(
      Eigen::Map<const Eigen::VectorXd>(y.data(), static_cast<Eigen::Index>(y.size())),
      {picked(*slice.subject, rows)}, factors, report.design.sum_of_squares);
  report.findings.push_back(
      {fmt::format("{}: {}", slice.response, why),
       fmt::format("analysed with {} as additive blocks and one pooled error{}",
                   slice.subject->name,
                   slice.between.empty() ? "" : "; see the mixed model for the factors between"),
       {}});
  add_rows("ANOVA in blocks", slice, anova.rows, report);
  add_aliased(slice, anova, report);
}

void analyse_with_subjects(const Slice& slice, std::optional<bool> normal, StudyReport& report) {
  const CellMeans c = cell_means(slice);
  size_t crossing = 1;
  for (const Factor& f : slice.within) crossing *= f.levels.size();
  std::vector<size_t> complete;
  std::string incomplete;
  for (Eigen::Index s = 0; s < c.mean.rows(); ++s) {
    if ((c.count.row(s).array() > 0).all() && static_cast<size_t>(c.mean.cols()) == crossing) {
      complete.push_back(static_cast<size_t>(s));
    } else {
      incomplete += (incomplete.empty() ? "" : ", ") + slice.subject->levels[s];
    }
  }
  if (slice.subject->levels.size() < 2) {
    report.findings.push_back(
        {fmt::format("{}: one {} only ({})", slice.response, slice.subject->name,
                     slice.subject->levels.front()),
         "no test generalises beyond this one; its own means, SDs, intervals, comparisons and "
         "regressions are computed",
         {}});
    return;
  }
  RepeatedMeasures data;
  data.y.resize(static_cast<Eigen::Index>(complete.size()), c.mean.cols());
  std::vector<size_t> subject_rows;
  for (size_t s = 0; s < complete.size(); ++s) {
    data.y.row(static_cast<Eigen::Index>(s)) = c.mean.row(static_cast<Eigen::Index>(complete[s]));
    subject_rows.push_back(c.first_row_of_subject[complete[s]]);
  }
  for (const Factor& f : slice.between) data.between.push_back(picked(f, subject_rows));
  for (const Factor& f : slice.within) data.within.push_back(picked(f, c.first_row_of_cell));
  const bool groups_left = std::none_of(data.between.begin(), data.between.end(),
                                        [](const Factor& f) { return f.levels.size() < 2; });
  const size_t groups = combined(data.between, static_cast<int>(complete.size())).levels.size();
  if (complete.size() < 2 || complete.size() <= groups || !groups_left) {
    if (incomplete.empty() || slice.within.empty()) {
      report.findings.push_back(
          {fmt::format("{}: {} subjects in {} group(s) leave no degrees of freedom for error",
                       slice.response, complete.size(), groups),
           "means, SDs, intervals and regressions are computed; add subjects for the test",
           {}});
      return;
    }
    analyse_in_blocks(slice, c,
                      fmt::format("too few {}s have every combination of the factors within",
                                  slice.subject->name),
                      report);
    return;
  }
  if (!incomplete.empty()) {
    report.findings.push_back(
        {fmt::format("{}: missing cells: {} {} did not make every combination of {}",
                     slice.response, slice.subject->name, incomplete, c.cells.name),
         fmt::format("the repeated-measures ANOVA uses the {} complete ones; the mixed model uses "
                     "all rows",
                     complete.size()),
         {}});
  }
  Anova anova = analyse_variance(data, report.design.sum_of_squares);
  if (!normal && anova.residuals.size() <= 5000) {
    normal = add_normality(slice, "residuals of the ANOVA",
                           {anova.residuals.data(), static_cast<size_t>(anova.residuals.size())},
                           report);
  }
  if (!normal.value_or(true)) {
    const std::vector<double> p =
        bootstrap_anova_p(data, anova, report.design.sum_of_squares, report.design.seed);
    for (size_t r = 0; r < anova.rows.size(); ++r) {
      anova.rows[r].corrections.push_back(
          {"residual bootstrap", 1.0, anova.rows[r].df1, anova.rows[r].df2, p[r]});
    }
  }
  add_rows(slice.within.empty() ? "ANOVA of subject means" : "repeated-measures ANOVA", slice,
           anova.rows, report);
  add_sphericity(slice, anova, report);
  add_aliased(slice, anova, report);
}

}  // namespace

std::string normality_note() {
  return fmt::format(
      "With normal errors the intervals held the truth in 93-97 % of simulated studies; more often "
      "those of components from two operators, and those of a share outside where few operators "
      "are off by a mean far from zero (up to 99 %). Few cuts hide what a test of normality would "
      "reject: {}. The "
      "intervals of an SD without normality have beside them what they held for as many cuts.",
      kCoverageIfNotNormal);
}

std::optional<bool> report_normality(const Slice& slice, StudyReport& report) {
  std::vector<double> values(slice.y.begin(), slice.y.end());
  const Moments pooled = pooled_within(values, slice.cell.level);
  if (pooled.degrees_of_freedom < 3.0 || !(pooled.sd > 0.0)) return {};
  std::vector<double> sum(slice.cell.levels.size(), 0.0), count(slice.cell.levels.size(), 0.0);
  for (size_t i = 0; i < values.size(); ++i) {
    sum[slice.cell.level[i]] += values[i];
    count[slice.cell.level[i]] += 1.0;
  }
  std::vector<double> residuals;
  for (size_t i = 0; i < values.size(); ++i) {
    const int k = slice.cell.level[i];
    // Scaled back to the size of the errors; a cell of two gives a mirrored pair: one is enough.
    if (count[k] < 2.0) continue;
    const bool pair = count[k] == 2.0;
    const double r = (values[i] - sum[k] / count[k]) * std::sqrt(count[k] / (count[k] - 1.0));
    if (pair && std::find(slice.cell.level.begin(),
                          slice.cell.level.begin() + static_cast<std::ptrdiff_t>(i),
                          k) != slice.cell.level.begin() + static_cast<std::ptrdiff_t>(i)) {
      continue;
    }
    residuals.push_back(r);
  }
  if (residuals.size() < 3 || residuals.size() > 5000) return {};
  const bool normal = add_normality(slice, "residuals about exclusive means", residuals, report);
  for (const Factor& factor : slice.factors()) {
    std::vector<double> all;
    std::vector<int> group;
    for (size_t i = 0; i < values.size(); ++i) {
      const int k = slice.cell.level[i];
      if (count[k] < 2.0) continue;
      all.push_back((values[i] - sum[k] / count[k]) * std::sqrt(count[k] / (count[k] - 1.0)));
      group.push_back(factor.level[i]);
    }
    if (all.empty() || *std::min_element(group.begin(), group.end()) ==
                           *std::max_element(group.begin(), group.end())) {
      continue;
    }
    const DiagnosticTest equal = brown_forsythe(all, group);
    const bool holds = equal.p >= report.design.alpha;
    report.assumptions.push_back(
        {"equal variances (Brown-Forsythe)", slice.response, factor.name, holds, equal.statistic,
         equal.p,
         holds ? ""
               : fmt::format("the levels of {} differ in variability: read their SDs apart and "
                             "Welch's test for the means",
                             factor.name)});
  }
  return normal;
}

void report_anova(const Slice& slice, std::optional<bool> normal, StudyReport& report) {
  if (slice.factors().empty() && slice.blocks.empty()) return;
  try {
    if (!slice.blocks.empty()) {
      const Anova anova =
          analyse_blocks(slice.y, slice.blocks, slice.factors(), report.design.sum_of_squares);
      add_rows("ANOVA in blocks", slice, anova.rows, report);
      add_aliased(slice, anova, report);
    } else if (slice.subject) {
      analyse_with_subjects(slice, normal, report);
    } else {
      RepeatedMeasures data{slice.y, slice.between, {}};
      const Anova anova = analyse_variance(data, report.design.sum_of_squares);
      add_rows("ANOVA", slice, anova.rows, report);
      add_aliased(slice, anova, report);
    }
  } catch (const InvalidInput& error) {
    report.findings.push_back(
        {fmt::format("{}: no analysis of variance: {}", slice.response, error.what()),
         "means, SDs, intervals and regressions are computed",
         {}});
  }
}

void report_covariance(const Slice& slice, StudyReport& report) {
  if (slice.covariates.empty()) return;
  try {
    const Ancova ancova =
        analyse_covariance(slice.y, slice.factors(), slice.covariates, report.design.sum_of_squares,
                           report.design.confidence);
    // Where operators repeat, cuts are not independent: the mixed model has the tests and the
    // means.
    std::vector<AdjustedMean> means = adjusted_means_with_subjects(slice, report.design.confidence);
    if (means.empty()) {
      means = ancova.adjusted_means;
      add_rows("ANCOVA", slice, ancova.anova.rows, report);
    }
    add_rows("ANCOVA, equal slopes", slice, ancova.slopes, report);
    add_aliased(slice, ancova.anova, report);
    for (const AnovaRow& row : ancova.slopes) {
      const bool holds = row.p >= report.design.alpha;
      report.assumptions.push_back(
          {"equal slopes", slice.response, row.term, holds, row.f, row.p,
           holds ? ""
                 : "the groups differ by another amount at each value of the covariate: the ANCOVA "
                   "and its adjusted means do not answer the question; read the regressions"});
    }
    for (AdjustedMean& adjusted : means) {
      report.adjusted_means.push_back({slice.response, std::move(adjusted)});
    }
  } catch (const InvalidInput& error) {
    report.findings.push_back(
        {fmt::format("{}: no analysis of covariance: {}", slice.response, error.what()),
         "the regressions without groups are computed",
         {}});
  }
}

}  // namespace osteomill::study
