// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/accuracy/choose_conditions.hpp"
#include "osteomill/accuracy/error_budget.hpp"
#include "osteomill/accuracy/tool_compliance.hpp"
#include "osteomill/accuracy/tool_deflection.hpp"
#include "osteomill/io/cutting_section.hpp"
#include "osteomill/io/vibration_case.hpp"

/// The cases of `osteomill deflect` and `optimise`.
namespace osteomill::io {

enum class FeedPattern {
  one_way,  ///< across the whole cut in one direction
  outward   ///< from the middle to both sides: the error changes its sign on one of them
};

/// [surface]: the cut that a plate comes to lie on.
struct SurfaceCase {
  double width = 0.0;  ///< medio-lateral, m
  FeedPattern feed = FeedPattern::one_way;
};

/// [budget]: sources of angular error beside the tool's deflection; rad.
struct BudgetCase {
  std::vector<accuracy::ErrorSource> varus_valgus, flexion_extension;
  double half_window = 0.0;
  int samples = 100000;
  int seed = 1;
};

/// `osteomill deflect`
struct DeflectCase {
  cutting::Cutter cutter;
  BoneCase bone;
  cutting::Condition condition;
  cutting::Immersion immersion;
  std::optional<accuracy::ToolCompliance> tool;
  accuracy::DeflectionOptions options;
  bool flexible = false;
  std::optional<StructureCase> structure;
  std::optional<SurfaceCase> surface;
  std::optional<BudgetCase> budget;
  std::vector<std::string> caveats;
  nlohmann::ordered_json expanded;
};
void bind_deflect(Section& section);
DeflectCase read_deflect_case(const CaseRun& run);

/// `osteomill optimise`
struct OptimiseCase {
  accuracy::ChoiceProblem problem;
  std::vector<accuracy::Candidate> candidates;
  std::optional<accuracy::HeatCalibration> heat_fit;  ///< when [heat] has observations
  int pareto_points = 0;
  double removal_rate = 0.0;  ///< of the comparison at equal time, m³/s; 0: none
  double compare_speed = 0.0;
  std::vector<double> compare_depths;
  std::vector<std::string> caveats;
  nlohmann::ordered_json expanded;
};
void bind_optimise(Section& section);
OptimiseCase read_optimise_case(const CaseRun& run);

}  // namespace osteomill::io
