// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// Linear models of factors and covariates: columns, least squares, sums of squares.
namespace osteomill::study {

/// A grouping of the units (cuts, subjects): level[i] is an index into levels.
struct Factor {
  std::string name;
  std::vector<std::string> levels;
  std::vector<int> level;
};

/// How a term's sum of squares is taken where the design is unbalanced:
/// I in the order listed; II over all terms that do not contain it; III over all others, with
/// columns that sum to zero. All three are the same in a balanced design.
enum class SumOfSquares { kI, kII, kIII };

/// A term of the model and its columns. `parts` is the set of variables in it as bits: A = 1,
/// B = 2, A:B = 3; the intercept is the empty set.
struct ModelTerm {
  std::string name;
  std::uint32_t parts = 0;
  Eigen::MatrixXd columns;
};

/// Intercept, main effects and all interactions up to `largest_order`, in that order, coded to sum
/// to zero over the levels.
std::vector<ModelTerm> factorial_terms(std::span<const Factor> factors, int units,
                                       int largest_order = 32);

/// The interaction of two terms: products of their columns.
ModelTerm interaction(const ModelTerm& a, const ModelTerm& b);

struct Effect {
  std::string term;
  int rank = 0;                ///< degrees of freedom in one response column
  Eigen::MatrixXd hypothesis;  ///< sums of squares and products of the response columns
};

struct FixedEffectsFit {
  std::vector<Effect> effects;
  Eigen::MatrixXd error;  ///< sums of squares and products of the residuals
  int error_rank = 0;
  Eigen::MatrixXd residuals;
  std::vector<std::string> aliased;  ///< terms with nothing left after the others
};

/// Least squares of one or more response columns on the terms.
FixedEffectsFit fit_fixed_effects(const Eigen::MatrixXd& responses,
                                  std::span<const ModelTerm> terms,
                                  SumOfSquares type = SumOfSquares::kII);

}  // namespace osteomill::study
