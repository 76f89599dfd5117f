// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/anova.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <bit>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/numerics/decompositions.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::study {
namespace {

AnovaRow make_row(std::string term, double hypothesis, double df1, double error, double df2) {
  AnovaRow row{.term = std::move(term),
               .sum_of_squares = hypothesis,
               .error_sum_of_squares = error,
               .df1 = df1,
               .df2 = df2,
               .corrections = {}};
  if (!(error > 0.0)) {
    throw InvalidInput(Fault{row.term, "error sum of squares 0", "the residuals are all zero",
                             "check that the response was not computed from the factors"});
  }
  row.f = (hypothesis / df1) / (error / df2);
  row.p = numerics::f_upper_tail(row.f, df1, df2);
  row.partial_eta_squared = hypothesis / (hypothesis + error);
  return row;
}

Correction make_correction(const AnovaRow& row, const char* name, double epsilon) {
  const double used = std::min(1.0, epsilon);
  Correction c{name, epsilon, used * row.df1, used * row.df2, 1.0};
  c.p = numerics::f_upper_tail(row.f, c.df1, c.df2);
  return c;
}

/// Orthonormal contrasts among the cells for one within-subject term: differences between the
/// levels of its factors, the mean over the others.
Eigen::MatrixXd contrasts(const ModelTerm& chosen) {
  // In a full crossing the columns of different terms are orthogonal; QR makes those of one so.
  Eigen::HouseholderQR<Eigen::MatrixXd> qr(chosen.columns);
  return qr.householderQ() *
         Eigen::MatrixXd::Identity(chosen.columns.rows(), chosen.columns.cols());
}

/// Mauchly's W and the epsilons from the error sums of squares of d orthonormal contrasts.
Sphericity test_sphericity(const std::string& term, const Eigen::MatrixXd& error, int error_rank) {
  const double d = static_cast<double>(error.rows()), n = error_rank;
  Sphericity s{.term = term};
  const double trace = error.trace();
  s.greenhouse_geisser = trace * trace / (d * error.squaredNorm());
  s.huynh_feldt =
      ((n + 1.0) * d * s.greenhouse_geisser - 2.0) / (d * (n - d * s.greenhouse_geisser));
  s.tested = error_rank >= error.rows();
  if (!s.tested) return s;
  // log W from the pivots keeps small determinants from underflowing.
  const Eigen::MatrixXd scaled = error / (trace / d);
  const double log_w =
      Eigen::PartialPivLU<Eigen::MatrixXd>(scaled).matrixLU().diagonal().array().abs().log().sum();
  s.w = std::exp(log_w);
  if (!std::isfinite(log_w)) {  // contrasts without an error of their own: anything but spherical
    s.p = 0.0;
    return s;
  }
  const double rho = 1.0 - (2.0 * d * d + d + 2.0) / (6.0 * d * n);
  const double w2 = (d + 2.0) * (d - 1.0) * (d - 2.0) *
                    (2.0 * d * d * d + 6.0 * d * d + 3.0 * d + 2.0) /
                    (288.0 * (n * d * rho) * (n * d * rho));
  const double z = -n * rho * log_w, f = 0.5 * d * (d + 1.0) - 1.0;
  const double p1 = numerics::chi_squared_upper_tail(std::max(0.0, z), f);
  const double p2 = numerics::chi_squared_upper_tail(std::max(0.0, z), f + 4.0);
  s.p = std::clamp(p1 + w2 * (p2 - p1), 0.0, 1.0);
  return s;
}

std::string joined(const std::string& between, const std::string& within) {
  if (within == "(Intercept)") return between;
  if (between == "(Intercept)") return within;
  return between + ":" + within;
}

void require_error(int rank, const char* what) {
  if (rank < 1) {
    throw InvalidInput(Fault{what, std::to_string(rank) + " degrees of freedom for error",
                             "needs one or more",
                             "leave out a factor, or add subjects or repeats"});
  }
}

}  // namespace

Anova analyse_variance(const RepeatedMeasures& data, SumOfSquares type) {
  const int subjects = static_cast<int>(data.y.rows()), cells = static_cast<int>(data.y.cols());
  const std::vector<ModelTerm> between = factorial_terms(data.between, subjects);
  const std::vector<ModelTerm> within = factorial_terms(data.within, cells);
  Anova anova;
  // About the grand mean: it takes nothing from the contrasts and spares the sums their digits.
  const Eigen::MatrixXd y = data.y.array() - data.y.mean();
  for (const ModelTerm& cell_term : within) {
    const Eigen::MatrixXd transformed = y * contrasts(cell_term);
    const FixedEffectsFit fit = fit_fixed_effects(transformed, between, type);
    require_error(fit.error_rank, "analysis of variance");
    const double d = static_cast<double>(transformed.cols());
    std::optional<Sphericity> sphericity;
    if (transformed.cols() > 1) {
      sphericity = test_sphericity(cell_term.name, fit.error, fit.error_rank);
      anova.sphericity.push_back(*sphericity);
    }
    for (const Effect& effect : fit.effects) {
      if (cell_term.parts == 0 && effect.term == "(Intercept)") continue;  // the grand mean
      AnovaRow row = make_row(joined(effect.term, cell_term.name), effect.hypothesis.trace(),
                              effect.rank * d, fit.error.trace(), fit.error_rank * d);
      if (sphericity) {
        row.corrections = {
            make_correction(row, "Greenhouse-Geisser", sphericity->greenhouse_geisser),
            make_correction(row, "Huynh-Feldt", sphericity->huynh_feldt)};
      }
      anova.rows.push_back(std::move(row));
    }
    for (const std::string& term : fit.aliased) {
      anova.aliased.push_back(joined(term, cell_term.name));
    }
  }
  anova.residuals = fit_fixed_effects(y, between, type).residuals;
  return anova;
}

Anova analyse_blocks(const Eigen::VectorXd& y, const std::vector<Factor>& blocks,
                     const std::vector<Factor>& factors, SumOfSquares type) {
  const int units = static_cast<int>(y.size());
  std::vector<ModelTerm> terms = factorial_terms(factors, units);
  std::vector<ModelTerm> block_terms = factorial_terms(blocks, units, 1);
  for (size_t b = 1; b < block_terms.size(); ++b) {
    block_terms[b].parts <<= factors.size();
    // Behind the intercept, before the factors: sequential sums of squares take blocks out first.
    terms.insert(terms.begin() + static_cast<std::ptrdiff_t>(b), std::move(block_terms[b]));
  }
  const FixedEffectsFit fit = fit_fixed_effects(y.array() - y.mean(), terms, type);
  require_error(fit.error_rank, "analysis in blocks");
  Anova anova;
  anova.residuals = fit.residuals;
  for (const Effect& effect : fit.effects) {
    if (effect.term == "(Intercept)") continue;
    anova.rows.push_back(make_row(effect.term, effect.hypothesis(0, 0), effect.rank,
                                  fit.error(0, 0), fit.error_rank));
  }
  for (const std::string& term : fit.aliased) {
    if (term != "(Intercept)") anova.aliased.push_back(term);
  }
  return anova;
}

Ancova analyse_covariance(const Eigen::VectorXd& y, const std::vector<Factor>& factors,
                          const std::vector<Covariate>& covariates, SumOfSquares type,
                          double confidence) {
  const int units = static_cast<int>(y.size());
  const std::vector<ModelTerm> factorial = factorial_terms(factors, units);
  std::vector<ModelTerm> terms{factorial.front()};
  for (size_t c = 0; c < covariates.size(); ++c) {
    const Eigen::VectorXd centred = covariates[c].value.array() - covariates[c].value.mean();
    const double size = std::sqrt(centred.squaredNorm() / units);
    if (!(size > 0.0)) {
      throw InvalidInput(Fault{covariates[c].name, "one value throughout", "a covariate must vary",
                               "leave it out of covariates"});
    }
    terms.push_back({covariates[c].name, std::uint32_t{1} << (factors.size() + c),
                     Eigen::MatrixXd(centred / size)});
  }
  terms.insert(terms.end(), factorial.begin() + 1, factorial.end());

  const Eigen::VectorXd centred = y.array() - y.mean();
  const FixedEffectsFit fit = fit_fixed_effects(centred, terms, type);
  require_error(fit.error_rank, "analysis of covariance");
  Ancova ancova;
  ancova.anova.residuals = fit.residuals;
  ancova.anova.aliased = fit.aliased;
  std::erase(ancova.anova.aliased, "(Intercept)");
  ancova.residual_sd = std::sqrt(fit.error(0, 0) / fit.error_rank);
  for (const Effect& effect : fit.effects) {
    if (effect.term == "(Intercept)") continue;
    ancova.anova.rows.push_back(make_row(effect.term, effect.hypothesis(0, 0), effect.rank,
                                         fit.error(0, 0), fit.error_rank));
  }

  for (size_t c = 0; c < covariates.size() && !factors.empty(); ++c) {
    // One slope for each cell of the factors against one slope for all.
    std::vector<ModelTerm> widened = terms;
    ModelTerm slopes{covariates[c].name + " slopes", ~std::uint32_t{0}, {}};
    for (size_t t = 1; t < factorial.size(); ++t) {
      const ModelTerm product = interaction(terms[1 + c], factorial[t]);
      const Eigen::Index before = slopes.columns.cols();
      slopes.columns.conservativeResize(units, before + product.columns.cols());
      slopes.columns.rightCols(product.columns.cols()) = product.columns;
    }
    widened.push_back(std::move(slopes));
    const FixedEffectsFit wide = fit_fixed_effects(centred, widened, SumOfSquares::kIII);
    if (wide.error_rank < 1 || wide.effects.back().term != widened.back().name) continue;
    const std::string name = factors.size() == 1 ? factors[0].name : std::string("cells");
    ancova.slopes.push_back(make_row(covariates[c].name + ":" + name,
                                     wide.effects.back().hypothesis(0, 0), wide.effects.back().rank,
                                     wide.error(0, 0), wide.error_rank));
  }

  if (factors.empty()) return ancova;
  // Adjusted means: cells of the factors at the covariates' means, y = C a + X b.
  std::vector<std::string> cell_names;
  std::vector<int> cell(units, 0);
  for (int i = 0; i < units; ++i) {
    std::string name;
    for (const Factor& factor : factors) {
      name += (name.empty() ? "" : ":") + factor.levels[factor.level[i]];
    }
    const auto found = std::find(cell_names.begin(), cell_names.end(), name);
    cell[i] = static_cast<int>(found - cell_names.begin());
    if (found == cell_names.end()) cell_names.push_back(name);
  }
  const int cells = static_cast<int>(cell_names.size());
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(units, cells + static_cast<int>(covariates.size()));
  for (int i = 0; i < units; ++i) x(i, cell[i]) = 1.0;
  for (size_t c = 0; c < covariates.size(); ++c)
    x.col(cells + static_cast<int>(c)) = terms[1 + c].columns;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(x);
  if (qr.rank() < x.cols()) return ancova;
  const Eigen::VectorXd coefficient = qr.solve(centred);
  const Eigen::MatrixXd covariance = (x.transpose() * x).inverse();
  const double t = numerics::student_t_quantile(0.5 + 0.5 * confidence, fit.error_rank);
  for (int k = 0; k < cells; ++k) {
    AdjustedMean adjusted{cell_names[k],
                          coefficient(k) + y.mean(),
                          ancova.residual_sd * std::sqrt(covariance(k, k)),
                          {},
                          static_cast<int>(std::count(cell.begin(), cell.end(), k))};
    adjusted.interval = {adjusted.mean - t * adjusted.standard_error,
                         adjusted.mean + t * adjusted.standard_error};
    ancova.adjusted_means.push_back(std::move(adjusted));
  }
  return ancova;
}

}  // namespace osteomill::study
