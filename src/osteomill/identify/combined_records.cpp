// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/combined_records.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "osteomill/numerics/decompositions.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::identify {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

CombinedRecords combine_records(const std::vector<InstantaneousFit>& fits,
                                const std::vector<std::string>& names,
                                const std::vector<UnitForce>& units, double confidence,
                                const std::vector<std::string>& groups) {
  const auto p = static_cast<Index>(units.size()) + exponents_of(units);
  CombinedRecords result;
  result.units = units;
  std::vector<const InstantaneousFit*> used;
  std::vector<std::string> used_names, used_groups;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    // A component that came out negative is not among the units of its fit.
    const bool determined = fits[i].units.size() == units.size() &&
                            std::all_of(fits[i].estimates.begin(), fits[i].estimates.begin() + p,
                                        [](const Estimate& one) { return one.determined; });
    if (determined) {
      used.push_back(&fits[i]);
      used_names.push_back(names[i]);
      if (!groups.empty()) used_groups.push_back(groups[i]);
    } else {
      result.left_out.push_back(names[i]);
    }
  }
  result.records = static_cast<int>(used.size());
  if (used.empty()) return result;
  // Pressures and edge forces differ by powers of ten: scaled by the errors of the first cut.
  const VectorXd scale = used.front()->covariance.diagonal().head(p).cwiseSqrt();
  const auto values_of = [&](const InstantaneousFit& fit) {
    VectorXd values(p);
    for (Index k = 0; k < p; ++k) {
      values(k) = fit.estimates[static_cast<std::size_t>(k)].value / scale(k);
    }
    return values;
  };
  const auto weight_of = [&](const InstantaneousFit& fit) -> MatrixXd {
    const MatrixXd covariance = scale.cwiseInverse().asDiagonal() *
                                fit.covariance.topLeftCorner(p, p) *
                                scale.cwiseInverse().asDiagonal();
    return covariance.ldlt().solve(MatrixXd::Identity(p, p));
  };
  MatrixXd weight = MatrixXd::Zero(p, p);
  VectorXd sum = VectorXd::Zero(p);
  for (const InstantaneousFit* fit : used) {
    weight += weight_of(*fit);
    sum += weight_of(*fit) * values_of(*fit);
  }
  const VectorXd mean = weight.ldlt().solve(sum);
  double chi2 = 0.0;
  for (const InstantaneousFit* fit : used) {
    const VectorXd off = values_of(*fit) - mean;
    chi2 += off.dot(weight_of(*fit) * off);
  }
  double degrees = used.front()->degrees_of_freedom;
  if (used.size() > 1) {
    degrees = static_cast<double>(p) * static_cast<double>(used.size() - 1);
    result.birge_ratio = std::sqrt(chi2 / degrees);
  }
  const double widening = std::max(1.0, result.birge_ratio);
  const auto inverse = [&](const MatrixXd& m) -> MatrixXd {
    return m.ldlt().solve(MatrixXd::Identity(p, p));
  };
  const auto leave_out = [&](const std::vector<std::string>& labels) {
    std::vector<LeftOutRecord> all;
    const std::set<std::string> different(labels.begin(), labels.end());
    for (const std::string& label : different) {
      if (different.size() < 2) break;
      MatrixXd own = MatrixXd::Zero(p, p);
      VectorXd own_sum = VectorXd::Zero(p);
      for (std::size_t i = 0; i < used.size(); ++i) {
        if (labels[i] != label) continue;
        own += weight_of(*used[i]);
        own_sum += weight_of(*used[i]) * values_of(*used[i]);
      }
      const MatrixXd others = weight - own;
      const VectorXd without = others.ldlt().solve(sum - own_sum);
      const VectorXd off = own.ldlt().solve(own_sum) - without;
      const VectorXd shift = mean - without;
      all.push_back({label,
                     std::sqrt(off.dot(inverse(inverse(own) + inverse(others)) * off) /
                               static_cast<double>(p)),
                     shift.dot(weight * shift) / (static_cast<double>(p) * widening * widening)});
    }
    return all;
  };
  result.leave_one = leave_out(used_names);
  result.leave_group = leave_out(used_groups);
  result.covariance =
      widening * widening *
      (scale.asDiagonal() * weight.ldlt().solve(MatrixXd::Identity(p, p)) * scale.asDiagonal());
  result.degrees_of_freedom = degrees;
  const VectorXd deviation = result.covariance.diagonal().cwiseSqrt();
  const MatrixXd correlation = deviation.cwiseInverse().asDiagonal() * result.covariance *
                               deviation.cwiseInverse().asDiagonal();
  const VectorXd spread =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(correlation, Eigen::EigenvaluesOnly).eigenvalues();
  result.condition_number = std::sqrt(spread(p - 1) / spread(0));
  const double t = numerics::student_t_quantile(0.5 + 0.5 * confidence, std::max(1.0, degrees));
  for (Index k = 0; k < p; ++k) {
    Estimate one;
    one.name = used.front()->estimates[static_cast<std::size_t>(k)].name;
    one.value = mean(k) * scale(k);
    one.standard_error = std::sqrt(result.covariance(k, k));
    one.low = one.value - t * one.standard_error;
    one.high = one.value + t * one.standard_error;
    result.coefficients.push_back(one);
  }
  return result;
}

}  // namespace osteomill::identify
