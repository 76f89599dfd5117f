// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "osteomill/identify/instantaneous.hpp"

namespace osteomill::identify {

/// One cut, or one group of cuts, left out: what the others say of it, and what it does to them
/// all.
struct LeftOutRecord {
  std::string name;  ///< of the cut, or of the group
  /// Root of the mean square of its coefficients less those of the others together, over the errors
  /// of both: about 1 where they agree.
  double ratio = 0.0;
  double influence = 0.0;  ///< as Cook's distance: above 1 the coefficients rest on it
};

/// The coefficients of several cuts of one bone, each fitted over its revolutions, as one set.
struct CombinedRecords {
  std::vector<UnitForce> units;        ///< of the law
  std::vector<Estimate> coefficients;  ///< SI; empty when no cut determines them all
  Eigen::MatrixXd covariance;
  int records = 0;                    ///< that went in
  std::vector<std::string> left_out;  ///< cuts that do not determine every coefficient
  /// Root of chi squared over its degrees of freedom: above 1 the cuts differ by more than their
  /// errors explain, and the errors are widened by it ([birge1932]).
  double birge_ratio = 1.0;
  std::vector<LeftOutRecord> leave_one;    ///< of those that went in; empty for one alone
  std::vector<LeftOutRecord> leave_group;  ///< the same by group; empty for fewer than two
  double degrees_of_freedom = 0.0;
  double condition_number = 0.0;  ///< of the combined covariance's correlations
};

/// Mean of the law's unknowns, exponents included, weighted by the inverse covariances of the fits.
/// `groups`: of each cut, specimens or days that are left out together; empty: none.
CombinedRecords combine_records(const std::vector<InstantaneousFit>& fits,
                                const std::vector<std::string>& names,
                                const std::vector<UnitForce>& units, double confidence = 0.95,
                                const std::vector<std::string>& groups = {});

}  // namespace osteomill::identify
