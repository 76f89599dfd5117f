// SPDX-License-Identifier: BSD-3-Clause
// How often the intervals of a study's report hold the truth, in simulated studies: the tables of
// docs/theory/study.md.
//   ./run coverage
//   normal|normal-held-out|components|forecasts|sd|sd-held-out|shapes|shapes-held-out
//       [STUDIES [SEED]]
#include <fmt/format.h>
#include <oneapi/tbb/combinable.h>
#include <oneapi/tbb/parallel_for.h>

#include <cstdlib>
#include <string>

#include "osteomill/study/component_intervals.hpp"
#include "osteomill/study/forecast.hpp"
#include "osteomill/study/simulated_study.hpp"

namespace {

using namespace osteomill;
using namespace osteomill::study;

CoverageCounts combined(oneapi::tbb::combinable<CoverageCounts>& parts) {
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

CoverageCounts repeat(const SimulatedStudy& study, int repetitions, std::uint64_t seed) {
  const SimulatedPopulation population =
      draw_population(study, study.response.ends_with("_deg") ? 1000000 : 1, seed);
  Design design;
  design.responses = {study.response};
  design.bootstrap_draws = 499;
  design.component_draws = 39;  // the level does not depend on it
  oneapi::tbb::combinable<CoverageCounts> parts;
  oneapi::tbb::parallel_for(0, repetitions, [&](int r) {
    Random random(seed, static_cast<std::uint64_t>(r) + 2);
    const DrawnStudy drawn = draw_study(study, random);
    Design own = design;
    own.seed = static_cast<std::uint64_t>(r);
    const StudyReport report = analyse_study(drawn.table, own);
    count_coverage(study, population, drawn, report, parts.local());
  });
  return combined(parts);
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

/// The model that the report fits to such a study.
MixedModelData mixed_model_data(const SimulatedStudy& s, Random& random) {
  const DrawnStudy drawn = draw_study(s, random);
  MixedModelData data;
  const int rows = s.rows();
  data.y.resize(rows);
  data.x = Eigen::MatrixXd::Zero(rows, s.groups * s.techniques);
  Factor who{"operator", {}, {}}, crossed{"operator × technique", {}, {}};
  int row = 0;
  for (int o = 0; o < s.operators; ++o) {
    who.levels.push_back(fmt::format("{}", o));
    for (int t = 0; t < s.techniques; ++t) {
      const int cell = o * s.techniques + t;
      crossed.levels.push_back(fmt::format("{}", cell));
      for (int i = 0; i < s.cuts[static_cast<size_t>(cell) % s.cuts.size()]; ++i, ++row) {
        data.y(row) = std::stod(drawn.table.rows[static_cast<size_t>(row)].cells[1]);
        data.x(row, (o % s.groups) * s.techniques + t) = 1.0;
        who.level.push_back(o);
        crossed.level.push_back(cell);
      }
    }
  }
  data.random = {who, crossed};
  return data;
}

/// The columns of normal errors.
struct NamedStudy {
  std::string name;
  SimulatedStudy study;
};
std::vector<NamedStudy> normal_studies() {
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
  return {{"equal cells", balanced}, {"unequal cells", unequal}, {"4 operators", few},
          {"16 operators", many},    {"operators alike", alike}, {"SDs 1 and 0.5", spread}};
}

/// Named before any of their results was seen: other numbers of operators, groups and techniques,
/// components of nothing, components larger than those of the cuts.
std::vector<NamedStudy> held_out_studies() {
  const auto study = [](int operators, int groups, int techniques, std::vector<int> cuts,
                        double operator_sd, double operator_technique_sd) {
    SimulatedStudy s = base();
    s.operators = operators;
    s.groups = groups;
    s.techniques = techniques;
    s.cuts = std::move(cuts);
    s.operator_sd = operator_sd;
    s.operator_technique_sd = operator_technique_sd;
    return s;
  };
  return {{"6 operators, 3 techniques, no interaction", study(6, 1, 3, {4, 4, 5, 3, 6}, 0.7, 0.0)},
          {"5 operators, no components", study(5, 1, 2, {6, 2, 5, 3, 4, 7}, 0.0, 0.0)},
          {"10 operators, 1.2 and 0.25", study(10, 2, 2, {4}, 1.2, 0.25)},
          {"3 operators", study(3, 1, 2, {8, 6, 10, 7}, 0.6, 0.4)},
          {"12 operators, 3 groups, 1 technique", study(12, 3, 1, {3, 6, 4, 5, 8}, 0.4, 0.0)},
          {"2 operators", study(2, 1, 2, {10, 8, 9, 7}, 0.5, 0.3)}};
}

/// Only the components: at nothing, near it and far from it, with few and with many operators.
void components(int repetitions, std::uint64_t seed) {
  const std::vector<std::pair<double, double>> truths = {
      {0.0, 0.0}, {0.0, 0.5}, {0.5, 0.0}, {0.2, 0.1}, {0.5, 0.3}, {0.8, 0.6}, {2.0, 1.0}};
  for (const int operators : {2, 4, 6, 8, 12}) {
    std::vector<CoverageCounts> columns;
    std::vector<std::string> names;
    for (const auto& [operator_sd, operator_technique_sd] : truths) {
      SimulatedStudy s = base();
      s.operators = operators;
      s.groups = operators < 4 ? 1 : 2;
      s.cuts = {5, 7, 3, 6, 8, 4, 4, 3, 6, 5};
      s.with_movement = false;
      s.movement_share = 0.0;
      s.operator_sd = operator_sd;
      s.operator_technique_sd = operator_technique_sd;
      oneapi::tbb::combinable<CoverageCounts> parts;
      oneapi::tbb::parallel_for(0, repetitions, [&](int r) {
        Random random(seed, static_cast<std::uint64_t>(r));
        const std::vector<double> sd = {operator_sd, operator_technique_sd, s.cut_sd.front()};
        const std::vector<bool> hold = component_intervals_hold(
            mixed_model_data(s, random), sd, {.seed = static_cast<std::uint64_t>(r), .draws = 99});
        const char* kinds[] = {"operator", "operator × technique", "cut (residual)"};
        for (size_t k = 0; k < sd.size(); ++k) {
          CoverageCount& c = parts.local()[kinds[k]];
          (hold[k] ? c.held : c.below) += 1;
        }
      });
      columns.push_back(combined(parts));
      names.push_back(fmt::format("{}, {}", operator_sd, operator_technique_sd));
    }
    print(fmt::format("{} operators, {} studies each; SD of operators, of operator × technique",
                      operators, repetitions),
          names, columns);
  }
}

void normal(const std::vector<NamedStudy>& studies, int repetitions, std::uint64_t seed) {
  std::vector<CoverageCounts> columns;
  std::vector<std::string> names;
  for (const NamedStudy& s : studies) {
    columns.push_back(repeat(s.study, repetitions, seed));
    names.push_back(s.name);
  }
  print(fmt::format("Normal errors, {} studies each", repetitions), names, columns);
}

/// Only what a report foretells of other operators, where it knows them by their number.
CoverageCounts repeat_forecasts(const SimulatedStudy& study, int repetitions, std::uint64_t seed) {
  const SimulatedPopulation population = draw_population(study, 1000000, seed);
  const Design design;
  struct Part {
    std::vector<double> y;
    std::vector<int> who;
  };
  oneapi::tbb::combinable<CoverageCounts> parts;
  oneapi::tbb::parallel_for(0, repetitions, [&](int r) {
    Random random(seed, static_cast<std::uint64_t>(r) + 2);
    const DrawnStudy drawn = draw_study(study, random);
    std::map<std::string, Part> groups;
    std::map<std::string, int> numbers;
    for (const auto& row : drawn.table.rows) {
      const auto& cell = row.cells;  // operator, response, group, technique
      const int who = numbers.try_emplace(cell[0], static_cast<int>(numbers.size())).first->second;
      for (const std::string& key :
           {std::string("all cuts"), "group " + cell[2], "technique " + cell[3],
            "group, technique " + cell[2] + cell[3]}) {
        groups[key].y.push_back(std::stod(cell[1]));
        groups[key].who.push_back(who);
      }
    }
    for (const auto& [key, part] : groups) {
      const Population of = estimate_population(part.y, part.who);
      for (const int cuts : {1, 2}) {
        const Interval interval =
            forecast(of, cuts, {.seed = static_cast<std::uint64_t>(r), .draws = 2000})
                .outside.interval;
        const double truth =
            population.share_outside(cuts == 1 ? population.one : population.two, design.limit_deg);
        CoverageCount& c =
            parts.local()[fmt::format("{}, {}, {} operators", cuts == 1 ? "one cut" : "alignment",
                                      key.substr(0, key.rfind(' ')), of.operators)];
        (interval.high < truth ? c.below : interval.low > truth ? c.above : c.held) += 1;
      }
    }
  });
  return combined(parts);
}

void forecasts(int repetitions, std::uint64_t seed) {
  for (const NamedStudy& s : normal_studies()) {
    if (s.study.cut_sd.size() > 1) continue;  // no one truth
    print(fmt::format("Share outside, {} studies", repetitions), {s.name},
          {repeat_forecasts(s.study, repetitions, seed)});
  }
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
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 20020;
  if (repetitions > 0 && what == "normal") {
    normal(normal_studies(), repetitions, seed);
  } else if (repetitions > 0 && what == "normal-held-out") {
    normal(held_out_studies(), repetitions, seed);
  } else if (repetitions > 0 && what == "components") {
    components(repetitions, seed);
  } else if (repetitions > 0 && what == "forecasts") {
    forecasts(repetitions, seed);
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
               "./run coverage normal | normal-held-out | components | forecasts [STUDIES [SEED]], "
               "sd | sd-held-out | shapes | shapes-held-out [STUDIES]\n");
    return 2;
  }
  return 0;
}
