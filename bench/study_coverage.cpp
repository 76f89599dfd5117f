// SPDX-License-Identifier: BSD-3-Clause
// How often the intervals of a study's report hold the truth, in simulated studies: the tables of
// docs/theory/study.md.
//   ./run coverage normal | sd | sd-held-out | shapes | shapes-held-out [STUDIES]
#include <fmt/format.h>
#include <oneapi/tbb/combinable.h>
#include <oneapi/tbb/parallel_for.h>

#include <cstdlib>
#include <string>

#include "osteomill/study/simulated_study.hpp"

namespace {

using namespace osteomill;
using namespace osteomill::study;

CoverageCounts repeat(const SimulatedStudy& study, int repetitions, std::uint64_t seed) {
  const SimulatedPopulation population =
      draw_population(study, study.response.ends_with("_deg") ? 1000000 : 1, seed);
  Design design;
  design.responses = {study.response};
  design.bootstrap_draws = 499;
  oneapi::tbb::combinable<CoverageCounts> parts;
  oneapi::tbb::parallel_for(0, repetitions, [&](int r) {
    Random random(seed, static_cast<std::uint64_t>(r) + 2);
    const DrawnStudy drawn = draw_study(study, random);
    Design own = design;
    own.seed = static_cast<std::uint64_t>(r);
    const StudyReport report = analyse_study(drawn.table, own);
    count_coverage(study, population, drawn, report, parts.local());
  });
  CoverageCounts sum;
  parts.combine_each([&](const CoverageCounts& part) {
    for (const auto& [kind, c] : part) {
      CoverageCount& to = sum[kind];
      to.below += c.below;
      to.held += c.held;
      to.above += c.above;
    }
  });
  return sum;
}

void print(const std::string& heading, const std::vector<std::string>& names,
           const std::vector<CoverageCounts>& columns, const std::string& only = "") {
  fmt::print("\n{}\n\n| interval |", heading);
  for (const std::string& name : names) fmt::print(" {} |", name);
  fmt::print("\n|---|");
  for (size_t i = 0; i < names.size(); ++i) fmt::print("---|");
  fmt::print("\n");
  std::map<std::string, bool> kinds;
  for (const CoverageCounts& column : columns) {
    for (const auto& [kind, c] : column) kinds[kind] = true;
  }
  for (const auto& [kind, unused] : kinds) {
    if (kind.find(only) == std::string::npos) continue;
    fmt::print("| {} |", kind);
    for (const CoverageCounts& column : columns) {
      const auto found = column.find(kind);
      if (found == column.end()) {
        fmt::print(" – |");
      } else {
        fmt::print(" {:.1f} |", 100.0 * found->second.share());
      }
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
}

SimulatedStudy base() {
  SimulatedStudy s;
  s.groups = 2;
  s.with_movement = true;
  s.movement_share = 0.2;
  return s;
}

void normal(int repetitions) {
  SimulatedStudy balanced = base();
  balanced.operator_sd = 0.8;
  balanced.operator_technique_sd = 0.6;
  SimulatedStudy unequal = balanced;
  unequal.cuts = {5, 7, 3, 6, 8, 4, 4, 3, 6, 5};
  SimulatedStudy few = unequal, many = unequal, alike = unequal, spread = unequal;
  few.operators = 4;
  many.operators = 16;
  alike.operator_sd = 0.5;
  alike.operator_technique_sd = 0.3;
  spread.cut_sd = {1.0, 0.5};
  std::vector<CoverageCounts> columns;
  for (const SimulatedStudy& s : {balanced, unequal, few, many, alike, spread}) {
    columns.push_back(repeat(s, repetitions, 20020));
  }
  print(fmt::format("Normal errors, {} studies each", repetitions),
        {"equal cells", "unequal cells", "4 operators", "16 operators", "operators alike",
         "SDs 1 and 0.5"},
        columns);
}

/// Three operators, one technique, cells of unequal size: what remains of the report are SDs.
void sd(ShapeRole role, int repetitions) {
  for (const NamedShape& shape : error_shapes()) {
    if (shape.role != role && shape.role != ShapeRole::kNormal) continue;
    std::vector<CoverageCounts> columns;
    const std::vector<std::vector<int>> cells = {
        {5, 3, 2}, {9, 6, 5}, {14, 9, 7}, {26, 19, 15}, {42, 32, 25}};
    for (const auto& cuts : cells) {
      SimulatedStudy s;
      s.operators = 3;
      s.techniques = 1;
      s.response = "error_mm";
      s.cuts = cuts;
      s.shape = shape.shape;
      columns.push_back(repeat(s, repetitions, 20021));
    }
    print(shape.name, {"10", "20", "30", "60", "99"}, columns, "SD, all cuts");
  }
}

void shapes(ShapeRole role, int repetitions) {
  std::vector<CoverageCounts> columns;
  std::vector<std::string> names;
  for (const NamedShape& shape : error_shapes()) {
    if (shape.role != role) continue;
    SimulatedStudy s = base();
    s.cuts = {5, 7, 3, 6, 8, 4, 4, 3, 6, 5};
    s.movement_share = 0.0;
    s.shape = shape.shape;
    names.emplace_back(shape.name);
    columns.push_back(repeat(s, repetitions, 20022));
  }
  print(fmt::format("{} studies each", repetitions), names, columns);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  const int repetitions = argc > 2 ? std::atoi(argv[2]) : 2000;
  if (repetitions > 0 && what == "normal") {
    normal(repetitions);
  } else if (repetitions > 0 && what == "sd") {
    sd(ShapeRole::kDesign, repetitions);
  } else if (repetitions > 0 && what == "sd-held-out") {
    sd(ShapeRole::kHeldOut, repetitions);
  } else if (repetitions > 0 && what == "shapes") {
    shapes(ShapeRole::kDesign, repetitions);
  } else if (repetitions > 0 && what == "shapes-held-out") {
    shapes(ShapeRole::kHeldOut, repetitions);
  } else {
    fmt::print(stderr,
               "./run coverage normal | sd | sd-held-out | shapes | shapes-held-out [STUDIES]\n");
    return 2;
  }
  return 0;
}
