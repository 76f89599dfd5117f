// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <bit>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/numerics/distributions.hpp"
#include "osteomill/study/slice.hpp"

namespace osteomill::study {
namespace {

struct FixedColumns {
  Eigen::MatrixXd x;
  std::vector<std::string> names;
  std::vector<Eigen::Index> first;  ///< of each term, and the end
};

Eigen::Index rank_of(const Eigen::MatrixXd& x) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
  qr.setThreshold(1e-9);
  qr.compute(x);
  return qr.rank();
}

/// Factors with the largest order of interactions that the cells allow, then the covariates.
FixedColumns fixed_columns(const Slice& slice) {
  const std::vector<Factor> factors = slice.factors();
  const int rows = static_cast<int>(slice.y.size());
  for (int order = static_cast<int>(factors.size()); order >= 0; --order) {
    FixedColumns c;
    std::vector<ModelTerm> terms = factorial_terms(factors, rows, order);
    for (const Covariate& covariate : slice.covariates) {
      terms.push_back(
          {covariate.name, 0, Eigen::MatrixXd(covariate.value.array() - covariate.value.mean())});
    }
    Eigen::Index width = 0;
    for (const ModelTerm& term : terms) width += term.columns.cols();
    c.x.resize(rows, width);
    Eigen::Index at = 0;
    for (const ModelTerm& term : terms) {
      c.names.push_back(term.name);
      c.first.push_back(at);
      c.x.middleCols(at, term.columns.cols()) = term.columns;
      at += term.columns.cols();
    }
    c.first.push_back(at);
    if (width < rows - 1 && rank_of(c.x) == width) return c;
  }
  throw InvalidInput(Fault{"mixed model", fmt::format("{} rows", rows),
                           "the covariates leave nothing to fit", "leave one out"});
}

bool same_partition(const Factor& a, const Factor& b) {
  return combined({a, b}, static_cast<int>(a.level.size())).levels.size() ==
         std::max(a.levels.size(), b.levels.size());
}

/// Random intercepts: subject, other random factors, and subject x factors within when cells
/// repeat.
std::vector<Factor> random_factors(const Slice& slice) {
  std::vector<Factor> random;
  const int rows = static_cast<int>(slice.y.size());
  const auto useful = [&](const Factor& f) {
    return f.levels.size() >= 2 && f.levels.size() < static_cast<size_t>(rows) &&
           std::none_of(
               random.begin(), random.end(),
               [&](const Factor& other) {
                 return other.levels.size() == f.levels.size() && same_partition(other, f);
               });
  };
  if (slice.subject && useful(*slice.subject)) random.push_back(*slice.subject);
  if (!random.empty() && !slice.within.empty()) {
    std::vector<Factor> parts = slice.within;
    parts.insert(parts.begin(), *slice.subject);
    Factor crossed = combined(parts, rows);
    if (useful(crossed)) random.push_back(std::move(crossed));
  }
  for (const Factor& f : slice.random) {
    if (useful(f)) random.push_back(f);
  }
  return random;
}

bool balanced(const Slice& slice) {
  std::vector<Factor> parts = slice.within;
  if (slice.subject) parts.insert(parts.begin(), *slice.subject);
  size_t crossing = slice.subject ? slice.subject->levels.size() : 1;
  for (const Factor& f : slice.within) crossing *= f.levels.size();
  return crossing == static_cast<size_t>(slice.y.size()) &&
         combined(parts, static_cast<int>(slice.y.size())).levels.size() == crossing;
}

MixedModelData model_data(const Slice& slice, const FixedColumns& columns) {
  return {slice.y, columns.x, random_factors(slice)};
}

bool repeats(const Slice& slice) {
  return slice.subject && slice.subject->levels.size() >= 2 && slice.y.size() >= 6 &&
         !random_factors(slice).empty();
}

/// The line's value at x = 0, of which two operators give two samples whatever the components are:
/// half their difference on one degree of freedom. The slope within operators takes the means to
/// x = 0; its error is common to both, and added with its own quantile.
void set_intercept_of_two(const Slice& slice, const Covariate& covariate, double confidence,
                          RandomLine& line) {
  double n[2] = {}, x[2] = {}, y[2] = {};
  for (Eigen::Index i = 0; i < slice.y.size(); ++i) {
    const int o = slice.subject->level[static_cast<size_t>(i)];
    n[o] += 1.0;
    x[o] += covariate.value(i);
    y[o] += slice.y(i);
  }
  std::vector<Factor> parts = slice.within;
  parts.push_back(*slice.subject);
  const Factor cell = combined(parts, static_cast<int>(slice.y.size()));
  const auto about_cells = [&](const Eigen::VectorXd& of) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(cell.levels.size()));
    Eigen::VectorXd count = sum;
    for (Eigen::Index i = 0; i < of.size(); ++i) {
      sum(cell.level[static_cast<size_t>(i)]) += of(i);
      count(cell.level[static_cast<size_t>(i)]) += 1.0;
    }
    Eigen::VectorXd rest = of;
    for (Eigen::Index i = 0; i < of.size(); ++i) {
      const int k = cell.level[static_cast<size_t>(i)];
      rest(i) -= sum(k) / count(k);
    }
    return rest;
  };
  const Eigen::VectorXd rx = about_cells(covariate.value), ry = about_cells(slice.y);
  const double df =
      static_cast<double>(slice.y.size()) - static_cast<double>(cell.levels.size()) - 1.0;
  const double sxx = rx.squaredNorm();
  line.intercept_interval = {};
  if (!(df > 0.0) || !(sxx > 0.0)) return;
  const double slope = rx.dot(ry) / sxx;
  const double slope_error = std::sqrt((ry - slope * rx).squaredNorm() / df / sxx);
  const double at[2] = {(y[0] - slope * x[0]) / n[0], (y[1] - slope * x[1]) / n[1]};
  const double from_slope = slope_error * 0.5 * (x[0] / n[0] + x[1] / n[1]);
  const double p = 0.5 + 0.5 * confidence;
  const double half = std::hypot(0.5 * (at[0] - at[1]) * numerics::student_t_quantile(p, 1.0),
                                 from_slope * numerics::student_t_quantile(p, df));
  line.intercept = 0.5 * (at[0] + at[1]);
  line.intercept_interval = Interval{line.intercept - half, line.intercept + half};
}

}  // namespace

std::optional<RandomLine> line_with_subjects(const Slice& slice, const Covariate& covariate,
                                             double confidence) {
  if (!repeats(slice)) return {};
  MixedModelData data{slice.y, Eigen::MatrixXd::Ones(slice.y.size(), 2), random_factors(slice)};
  data.x.col(1) = covariate.value;
  if (rank_of(data.x) < 2) return {};
  const MixedModel fit = fit_mixed_model(data, {.intervals = false});
  if (!fit.converged) return {};
  const MixedModelEstimate intercept =
      estimate_contrast(data, fit, Eigen::RowVector2d(1.0, 0.0), confidence);
  RandomLine line{estimate_contrast(data, fit, Eigen::RowVector2d(0.0, 1.0), confidence),
                  intercept.value, intercept.interval};
  if (slice.subject->levels.size() == 2) set_intercept_of_two(slice, covariate, confidence, line);
  return line;
}

std::vector<AdjustedMean> adjusted_means_with_subjects(const Slice& slice, double confidence) {
  std::vector<AdjustedMean> means;
  if (!repeats(slice) || slice.factors().empty()) return means;
  const Factor cell = combined(slice.factors(), static_cast<int>(slice.y.size()));
  const auto cells = static_cast<Eigen::Index>(cell.levels.size());
  MixedModelData data{slice.y,
                      Eigen::MatrixXd::Zero(slice.y.size(), cells + static_cast<Eigen::Index>(
                                                                        slice.covariates.size())),
                      random_factors(slice)};
  for (Eigen::Index i = 0; i < slice.y.size(); ++i) {
    data.x(i, cell.level[static_cast<size_t>(i)]) = 1.0;
  }
  for (size_t c = 0; c < slice.covariates.size(); ++c) {
    const Eigen::VectorXd& x = slice.covariates[c].value;
    data.x.col(cells + static_cast<Eigen::Index>(c)) = x.array() - x.mean();
  }
  if (data.x.cols() + 1 >= slice.y.size() || rank_of(data.x) < data.x.cols()) return means;
  const MixedModel fit = fit_mixed_model(data, {.intervals = false});
  if (!fit.converged) return means;
  for (Eigen::Index k = 0; k < cells; ++k) {
    Eigen::RowVectorXd contrast = Eigen::RowVectorXd::Zero(data.x.cols());
    contrast(k) = 1.0;
    const MixedModelEstimate e = estimate_contrast(data, fit, contrast, confidence);
    means.push_back({cell.levels[static_cast<size_t>(k)], e.value, e.standard_error, e.interval,
                     static_cast<int>(std::count(cell.level.begin(), cell.level.end(), k))});
    if (slice.subject->levels.size() > 2 || slice.covariates.size() != 1) continue;
    // Of two operators: the cell's own line at the covariate's mean.
    const Slice part = subset(slice, rows_at(cell, static_cast<int>(k)));
    if (part.subject->levels.size() < 2) continue;
    Covariate centred = part.covariates.front();
    centred.value.array() -= slice.covariates.front().value.mean();
    RandomLine line;
    set_intercept_of_two(part, centred, confidence, line);
    if (!line.intercept_interval) continue;
    const double half = line.intercept_interval->high - line.intercept;
    means.back().mean = line.intercept;
    means.back().interval = *line.intercept_interval;
    means.back().standard_error = half / numerics::student_t_quantile(0.5 + 0.5 * confidence, 1.0);
  }
  return means;
}

void report_mixed_model(const Slice& slice, StudyReport& report) {
  if (!slice.subject || slice.subject->levels.size() < 2 || slice.y.size() < 6) return;
  const FixedColumns columns = fixed_columns(slice);
  const MixedModelData data = model_data(slice, columns);
  if (data.random.empty()) return;
  const bool with_covariates = !slice.covariates.empty();
  // With covariates only the tests are reported: the components are those of all rows.
  const MixedModel fit = fit_mixed_model(data, {.confidence = report.design.confidence,
                                                .intervals = !with_covariates,
                                                .seed = report.design.seed,
                                                .draws = report.design.component_draws});
  if (!fit.converged) {
    report.findings.push_back({fmt::format("{}: mixed model: {}", slice.response, fit.reason),
                               "its components and tests are left out",
                               {}});
    return;
  }
  if (!with_covariates) {
    for (const VarianceComponent& component : fit.components) {
      ComponentRecord record{slice.response, component};
      if (component.name == "residual") record.component.name = "cut (residual)";
      report.components.push_back(std::move(record));
    }
  }
  if (balanced(slice) && !with_covariates) return;  // the same as the analysis of variance
  for (size_t t = 0; t + 1 < columns.first.size(); ++t) {
    if (columns.names[t] == "(Intercept)") continue;
    const Eigen::Index width = columns.first[t + 1] - columns.first[t];
    Eigen::MatrixXd contrast = Eigen::MatrixXd::Zero(width, columns.x.cols());
    contrast.middleCols(columns.first[t], width).setIdentity();
    const MixedModelTest test = test_fixed_effect(data, fit, contrast);
    report.tests.push_back({.name = with_covariates ? "mixed-model ANCOVA" : "mixed model",
                            .response = slice.response,
                            .term = columns.names[t],
                            .statistic_name = "F",
                            .statistic = test.f,
                            .df1 = test.df1,
                            .df2 = test.df2,
                            .p = test.p,
                            .corrections = {},
                            .estimate = {},
                            .interval = {}});
  }
}

void report_contributions(const Slice& slice, const Slice& with_movement, StudyReport& report) {
  if (!slice.subject || slice.subject->levels.size() < 2 || slice.y.size() < 6) return;
  const FixedColumns columns = fixed_columns(slice);
  const MixedModelData data = model_data(slice, columns);
  if (data.random.empty()) return;
  const MixedModel fit = fit_mixed_model(data, {.intervals = false});
  std::vector<ContributionRecord> parts;
  double left = 0.0;
  for (const VarianceComponent& component : fit.components) {
    if (component.name == "residual") {
      left = component.sd * component.sd;
    } else {
      parts.push_back({slice.response, component.name, component.sd * component.sd, 0.0});
    }
  }
  const auto take = [&](const std::string& source, double variance) {
    variance = std::clamp(variance, 0.0, left);
    parts.push_back({slice.response, source, variance, 0.0});
    left -= variance;
  };
  if (!with_movement.covariates.empty() && with_movement.y.size() >= 6 &&
      with_movement.subject->levels.size() >= 2) {
    // What the residual loses when the guide's movement is known, on the rows that know it.
    Slice without = with_movement;
    without.covariates.clear();
    const auto residual = [&](const Slice& s) {
      const MixedModel model =
          fit_mixed_model(model_data(s, fixed_columns(s)), {.intervals = false});
      return model.components.back().sd * model.components.back().sd;
    };
    const double before = residual(without), after = residual(with_movement);
    take("guide movement", left * (1.0 - after / before));
  }
  if (const auto known = report.design.measurement_sd.find(slice.response);
      known != report.design.measurement_sd.end()) {
    take("measurement", known->second * known->second);
  }
  parts.push_back({slice.response, "cut (rest)", left, 0.0});
  double total = 0.0;
  for (const ContributionRecord& part : parts) total += part.variance;
  for (ContributionRecord& part : parts) {
    part.share = total > 0.0 ? part.variance / total : 0.0;
    report.contributions.push_back(part);
  }
}

}  // namespace osteomill::study
