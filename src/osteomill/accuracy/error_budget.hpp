// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace osteomill::accuracy {

enum class ErrorShape {
  normal,     ///< `spread` is the standard deviation
  uniform,    ///< within ± spread
  triangular  ///< within ± spread, most likely in the middle
};

/// One source of error of a procedure, in one plane: registration, guide positioning, fixation,
/// tool deflection, backlash, cutting. Any unit, the same for all.
struct ErrorSource {
  std::string name;
  double bias = 0.0;
  double spread = 0.0;
  ErrorShape shape = ErrorShape::normal;
  /// How often it enters independently: 2 for the cuts on femur and tibia (√2 SD in
  /// [plaskos2002] §2.4).
  int times = 1;
};

/// Error of an angle that a compliance makes: load × compliance, as from [plaskos2006] Table 5.2
/// and §5.7 (K = 125 N/mm of fixation and of the guide).
ErrorSource source_from_compliance(std::string name, double load_mean, double load_sd,
                                   double compliance);

struct BudgetShare {
  std::string name;
  double standard_deviation = 0.0;  ///< with `times`
  double share_of_variance = 0.0;   ///< 0 … 1
};

struct Budget {
  double bias = 0.0;
  double standard_deviation = 0.0;
  std::vector<BudgetShare> shares;
};

/// Independent errors: biases add, variances add; [plaskos2006] §4.2.1.
Budget propagate(const std::vector<ErrorSource>& sources);

/// The standard deviation that one more source may have, so that the total keeps to `allowed`;
/// negative (the root of what is missing) when nothing is left.
double remaining_deviation(const std::vector<ErrorSource>& sources, double allowed);

/// The standard deviation of a normal error that stays within ± half_window with that probability.
double allowed_deviation(double half_window, double probability);

struct SampledBudget {
  double mean = 0.0;
  double standard_deviation = 0.0;
  double share_within = 0.0;     ///< of the window
  double low = 0.0, high = 0.0;  ///< 2.5 and 97.5 % quantiles
  int samples = 0;
};

/// The same by Monte Carlo, with the shapes as they are; sample i depends on seed and i alone.
SampledBudget sample(const std::vector<ErrorSource>& sources, double half_window, int samples,
                     std::uint64_t seed);

}  // namespace osteomill::accuracy
