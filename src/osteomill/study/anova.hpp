// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/study/fixed_effects.hpp"
#include "osteomill/study/intervals.hpp"

/// Analysis of variance: factorial, repeated measures, blocks, covariance.
namespace osteomill::study {

/// The same F on fewer degrees of freedom, where sphericity does not hold.
struct Correction {
  std::string name;  ///< "Greenhouse-Geisser", "Huynh-Feldt"
  double epsilon = 1.0;
  double df1 = 0.0;
  double df2 = 0.0;
  double p = 1.0;
};

struct AnovaRow {
  std::string term;
  double sum_of_squares = 0.0;
  double error_sum_of_squares = 0.0;
  double df1 = 0.0;
  double df2 = 0.0;
  double f = 0.0;
  double p = 1.0;
  double partial_eta_squared = 0.0;
  std::vector<Correction> corrections;
};

/// Mauchly's test that the differences between the levels of a within-subject term have one
/// variance. chi2 approximation with the second-order term of Anderson 2003, 10.7.4. (R 4.2's
/// mauchly.test has the number of columns in one place where that of the contrasts belongs: p off
/// by 0.1 %.)
struct Sphericity {
  std::string term;
  bool tested = false;  ///< false: too few subjects for the determinant
  double w = 1.0;
  double p = 1.0;
  double greenhouse_geisser = 1.0;
  double huynh_feldt = 1.0;  ///< Lecoutre's form; may pass 1, the correction then uses 1
};

struct Anova {
  std::vector<AnovaRow> rows;
  std::vector<Sphericity> sphericity;
  std::vector<std::string> aliased;
  Eigen::MatrixXd residuals;  ///< of the responses about the full between-subject model
};

/// One row of y a subject (or one unit), one column a cell of the within-subject factors; each
/// within factor has its level for each column. All combinations must be there.
struct RepeatedMeasures {
  Eigen::MatrixXd y;
  std::vector<Factor> between;
  std::vector<Factor> within;
};

/// Univariate repeated-measures analysis with one error term for each set of within factors, by
/// orthonormal contrasts; without within factors the ordinary factorial analysis. Between factors
/// may be unbalanced. Throws InvalidInput when no degrees of freedom are left for error.
Anova analyse_variance(const RepeatedMeasures& data, SumOfSquares type = SumOfSquares::kII);

/// Factors crossed inside blocks (or subjects) that do not hold every combination: additive block,
/// all interactions that the blocks leave, one pooled error. Terms that are the blocks' own
/// differences are named in `aliased`.
Anova analyse_blocks(const Eigen::VectorXd& y, const std::vector<Factor>& blocks,
                     const std::vector<Factor>& factors, SumOfSquares type = SumOfSquares::kII);

struct AdjustedMean {
  std::string level;  ///< "expert", or "expert:open" for two factors
  double mean = 0.0;
  double standard_error = 0.0;
  Interval interval;
  int count = 0;
};

/// Analysis of covariance. The slopes are taken as equal; `slopes` tests it, and where it fails the
/// rows and the adjusted means answer a question that the data do not allow.
struct Ancova {
  Anova anova;                               ///< factors and covariates, with equal slopes
  std::vector<AnovaRow> slopes;              ///< covariate x factors, one row a covariate
  std::vector<AdjustedMean> adjusted_means;  ///< at the covariates' means
  double residual_sd = 0.0;
};
struct Covariate {
  std::string name;
  Eigen::VectorXd value;
};
Ancova analyse_covariance(const Eigen::VectorXd& y, const std::vector<Factor>& factors,
                          const std::vector<Covariate>& covariates,
                          SumOfSquares type = SumOfSquares::kII, double confidence = 0.95);

}  // namespace osteomill::study
