// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/fixed_effects.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <bit>
#include <functional>

namespace osteomill::study {
namespace {

struct Projection {
  Eigen::MatrixXd residuals;
  int rank = 0;
};

/// Residuals of the responses after the columns of the chosen terms.
Projection project(const Eigen::MatrixXd& responses, std::span<const ModelTerm> terms,
                   const std::function<bool(const ModelTerm&)>& chosen) {
  Eigen::Index width = 0;
  for (const ModelTerm& term : terms) width += chosen(term) ? term.columns.cols() : 0;
  if (width == 0) return {responses, 0};
  Eigen::MatrixXd x(responses.rows(), width);
  Eigen::Index at = 0;
  for (const ModelTerm& term : terms) {
    if (!chosen(term)) continue;
    x.middleCols(at, term.columns.cols()) = term.columns;
    at += term.columns.cols();
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
  qr.setThreshold(1e-9);  // coded columns are of size one: below this a column is a sum of others
  qr.compute(x);
  const Eigen::Index rank = qr.rank();
  Eigen::MatrixXd rotated = qr.householderQ().adjoint() * responses;
  rotated.topRows(rank).setZero();
  return {qr.householderQ() * rotated, static_cast<int>(rank)};
}

Eigen::MatrixXd sum_to_zero(const Factor& factor) {
  const int last = static_cast<int>(factor.levels.size()) - 1;
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(factor.level.size()), last);
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    const int level = factor.level[i];
    if (level == last) {
      columns.row(i).setConstant(-1.0);
    } else {
      columns(i, level) = 1.0;
    }
  }
  return columns;
}

}  // namespace

ModelTerm interaction(const ModelTerm& a, const ModelTerm& b) {
  if (a.parts == 0) return b;
  ModelTerm term{a.name + ":" + b.name, a.parts | b.parts,
                 Eigen::MatrixXd(a.columns.rows(), a.columns.cols() * b.columns.cols())};
  for (Eigen::Index i = 0; i < a.columns.cols(); ++i) {
    for (Eigen::Index j = 0; j < b.columns.cols(); ++j) {
      term.columns.col(i * b.columns.cols() + j) = a.columns.col(i).cwiseProduct(b.columns.col(j));
    }
  }
  return term;
}

std::vector<ModelTerm> factorial_terms(std::span<const Factor> factors, int units,
                                       int largest_order) {
  std::vector<ModelTerm> mains;
  for (size_t f = 0; f < factors.size(); ++f) {
    mains.push_back({factors[f].name, std::uint32_t{1} << f, sum_to_zero(factors[f])});
  }
  std::vector<ModelTerm> terms;
  for (std::uint32_t parts = 0; parts < (std::uint32_t{1} << factors.size()); ++parts) {
    if (std::popcount(parts) > largest_order) continue;
    ModelTerm term{"(Intercept)", 0, Eigen::MatrixXd::Ones(units, 1)};
    for (size_t f = 0; f < factors.size(); ++f) {
      if (parts >> f & 1u) term = interaction(term, mains[f]);
    }
    terms.push_back(std::move(term));
  }
  std::stable_sort(terms.begin(), terms.end(), [](const ModelTerm& a, const ModelTerm& b) {
    return std::popcount(a.parts) < std::popcount(b.parts);
  });
  return terms;
}

FixedEffectsFit fit_fixed_effects(const Eigen::MatrixXd& responses,
                                  std::span<const ModelTerm> terms, SumOfSquares type) {
  FixedEffectsFit fit;
  const Projection full = project(responses, terms, [](const ModelTerm&) { return true; });
  fit.residuals = full.residuals;
  fit.error = full.residuals.transpose() * full.residuals;
  fit.error_rank = static_cast<int>(responses.rows()) - full.rank;
  for (size_t t = 0; t < terms.size(); ++t) {
    const ModelTerm& tested = terms[t];
    const auto base = [&](const ModelTerm& other) {
      switch (type) {
        case SumOfSquares::kI:
          return &other < &tested;
        case SumOfSquares::kII:
          return (other.parts & tested.parts) != tested.parts;
        case SumOfSquares::kIII:
          break;
      }
      return &other != &tested;
    };
    const Projection without = project(responses, terms, base);
    const Projection with = project(
        responses, terms, [&](const ModelTerm& other) { return &other == &tested || base(other); });
    const Eigen::MatrixXd explained = without.residuals - with.residuals;
    const int rank = with.rank - without.rank;
    if (rank == 0) {
      fit.aliased.push_back(tested.name);
    } else {
      fit.effects.push_back({tested.name, rank, explained.transpose() * explained});
    }
  }
  return fit;
}

}  // namespace osteomill::study
