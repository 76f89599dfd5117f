// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "osteomill/base/random.hpp"
#include "osteomill/study/analysis.hpp"

/// Studies whose truth is known, and the count of how often the intervals of their reports hold it.
namespace osteomill::study {

/// Errors of single cuts, mean 0 and SD 1.
enum class ErrorShape {
  kNormal,
  kUniform,
  kLaplace,
  kStudent5,
  kGamma4,
  kExponential,
  kLognormal,
  kWeibull,
  kLogistic,
  kContaminated,
  kTriangular,
  kBeta,
};

/// What a shape is used for: methods are chosen by the design shapes and judged by the held-out
/// ones, which were named before any result of them was seen.
enum class ShapeRole { kNormal, kDesign, kHeldOut };

struct NamedShape {
  ErrorShape shape;
  const char* name;
  ShapeRole role;
};
const std::vector<NamedShape>& error_shapes();

double draw_error(Random& random, ErrorShape shape);

/// Operators cross techniques; y = operator + operator x technique + movement + error, all means 0.
/// The guide's movement is normal with SD 1 and explains `movement_share` of a cut's own variance.
struct SimulatedStudy {
  int operators = 8;
  int groups = 1;  ///< operators take turns
  int techniques = 2;
  std::vector<int> cuts = {5};  ///< of operator o with technique t: entry (o techniques + t), again
                                ///< from the start
  double operator_sd = 0.5;
  double operator_technique_sd = 0.3;
  std::vector<double> cut_sd = {1.0};  ///< by technique, the last for the rest
  double movement_share = 0.0;
  bool with_movement = false;  ///< the table has its column
  ErrorShape shape = ErrorShape::kNormal;
  std::string response = "varus_valgus_deg";

  int rows() const;
};

/// What the drawn study is made of.
struct DrawnStudy {
  Table table;
  std::vector<std::vector<double>> bias;  ///< of operator and technique
  double movement_mean = 0.0;
};
DrawnStudy draw_study(const SimulatedStudy& study, Random& random);

/// Of the error of one cut by another operator and of the sum of two such: sorted draws.
struct SimulatedPopulation {
  std::vector<double> one, two;

  double share_outside(const std::vector<double>& of, double limit) const;
  double content(const std::vector<double>& of, const Interval& interval) const;
};
SimulatedPopulation draw_population(const SimulatedStudy& study, int draws, std::uint64_t seed);

struct CoverageCount {
  int below = 0;  ///< the whole interval lies below the truth
  int held = 0;
  int above = 0;

  int all() const { return below + held + above; }
  double share() const { return static_cast<double>(held) / all(); }
};
/// By the kind of interval: "SD of all cuts, chi-squared".
using CoverageCounts = std::map<std::string, CoverageCount>;

void count_coverage(const SimulatedStudy& study, const SimulatedPopulation& population,
                    const DrawnStudy& drawn, const StudyReport& report, CoverageCounts& counts);

}  // namespace osteomill::study
