// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "osteomill/study/fixed_effects.hpp"
#include "osteomill/study/intervals.hpp"

/// Linear mixed model y = X b + sum_k Z_k u_k + e by restricted maximum likelihood (REML): what
/// operators, specimens and single cuts contribute to the variance, with any pattern of cells.
/// Random factors may be crossed or nested. Bates et al. 2015 (lme4) for the profiled criterion,
/// Giesbrecht and Burns 1985 for the degrees of freedom of the tests.
namespace osteomill::study {

struct MixedModelData {
  Eigen::VectorXd y;
  Eigen::MatrixXd x;           ///< fixed effects, full column rank
  std::vector<Factor> random;  ///< none, one or more; independent intercepts
};

struct MixedModelOptions {
  double confidence = 0.95;
  bool intervals = true;  ///< of the components, by component_intervals (the slow part)
  std::uint64_t seed = 1;
  int draws = 199;
};

struct VarianceComponent {
  std::string name;  ///< the random factor, or "residual"
  double sd = 0.0;
  Interval sd_interval;  ///< by component_intervals; low may be 0
  double share = 0.0;    ///< of the total variance
  bool at_zero = false;  ///< the estimate sits at its bound
};

struct MixedModel {
  bool converged = false;
  std::string reason = "not run";
  int evaluations = 0;
  double criterion = 0.0;  ///< -2 log restricted likelihood
  Eigen::VectorXd beta;
  Eigen::MatrixXd beta_covariance;
  std::vector<VarianceComponent> components;  ///< random factors in order, then "residual"
  double total_sd = 0.0;
  double total_degrees_of_freedom = 0.0;  ///< Satterthwaite's, of the total variance
};

MixedModel fit_mixed_model(const MixedModelData& data, const MixedModelOptions& options = {});

/// F-test that L b = 0, L of full row rank, Satterthwaite's denominator degrees of freedom.
struct MixedModelTest {
  double f = 0.0;
  double df1 = 0.0;
  double df2 = 0.0;
  double p = 1.0;
};
MixedModelTest test_fixed_effect(const MixedModelData& data, const MixedModel& fit,
                                 const Eigen::MatrixXd& contrast);

/// l b of one contrast with its interval, Student's t on Satterthwaite's degrees of freedom.
struct MixedModelEstimate {
  double value = 0.0;
  double standard_error = 0.0;
  double degrees_of_freedom = 0.0;
  double p = 1.0;  ///< two-sided, of l b = 0
  Interval interval;
};
MixedModelEstimate estimate_contrast(const MixedModelData& data, const MixedModel& fit,
                                     const Eigen::RowVectorXd& contrast, double confidence = 0.95);

}  // namespace osteomill::study
