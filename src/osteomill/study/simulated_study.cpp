// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/simulated_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace osteomill::study {
namespace {

std::string operator_name(int o) { return fmt::format("o{:02}", o); }
std::string technique_name(int t) { return fmt::format("t{}", t); }

double sum_of_logarithms(Random& random, int of) {
  double sum = 0.0;
  for (int i = 0; i < of; ++i) sum -= std::log(random.uniform());
  return sum;
}

double cut_sd(const SimulatedStudy& study, int technique) {
  return study.cut_sd[std::min(static_cast<size_t>(technique), study.cut_sd.size() - 1)];
}

struct Cut {
  double movement = 0.0;
  double error = 0.0;
};
Cut draw_cut(const SimulatedStudy& study, int technique, Random& random) {
  Cut cut;
  if (study.with_movement) cut.movement = random.normal();
  const double sd = cut_sd(study, technique);
  cut.error = sd * (std::sqrt(study.movement_share) * cut.movement +
                    std::sqrt(1.0 - study.movement_share) * draw_error(random, study.shape));
  return cut;
}

void count(CoverageCounts& counts, const std::string& kind, const Interval& interval,
           double truth) {
  CoverageCount& c = counts[kind];
  (interval.high < truth ? c.below : interval.low > truth ? c.above : c.held) += 1;
}

bool techniques_alike(const SimulatedStudy& study) {
  return std::adjacent_find(study.cut_sd.begin(), study.cut_sd.end(), std::not_equal_to<>()) ==
         study.cut_sd.end();
}

/// Cut-to-cut SD of a group: the techniques in it must be alike, or be one.
std::optional<double> true_sd(const SimulatedStudy& study, const std::string& group) {
  for (int t = 0; t < study.techniques; ++t) {
    const std::string name = technique_name(t);
    if (group == name || group.ends_with(" " + name)) return cut_sd(study, t);
  }
  return techniques_alike(study) ? std::optional(study.cut_sd.front()) : std::nullopt;
}

std::string kind_of_group(const std::string& factor) {
  if (factor == "all") return "all cuts";
  if (factor == "operator") return "one operator";
  if (factor == "operator × technique") return "one operator, one technique";
  return "one " + factor;
}

int index_after(const std::string& text, const std::string& mark) {
  const size_t at = text.rfind(mark);
  return std::stoi(text.substr(at + mark.size()));
}

}  // namespace

const std::vector<NamedShape>& error_shapes() {
  static const std::vector<NamedShape> shapes = {
      {ErrorShape::kNormal, "normal", ShapeRole::kNormal},
      {ErrorShape::kUniform, "uniform", ShapeRole::kDesign},
      {ErrorShape::kLaplace, "Laplace", ShapeRole::kDesign},
      {ErrorShape::kStudent5, "Student's t, 5 df", ShapeRole::kDesign},
      {ErrorShape::kGamma4, "gamma, shape 4", ShapeRole::kDesign},
      {ErrorShape::kExponential, "exponential", ShapeRole::kDesign},
      {ErrorShape::kLognormal, "lognormal, σ 0.5", ShapeRole::kHeldOut},
      {ErrorShape::kWeibull, "Weibull, shape 1.5", ShapeRole::kHeldOut},
      {ErrorShape::kLogistic, "logistic", ShapeRole::kHeldOut},
      {ErrorShape::kContaminated, "normal, 10 % at 3 σ", ShapeRole::kHeldOut},
      {ErrorShape::kTriangular, "triangular", ShapeRole::kHeldOut},
      {ErrorShape::kBeta, "beta(2, 5)", ShapeRole::kHeldOut}};
  return shapes;
}

double draw_error(Random& random, ErrorShape shape) {
  switch (shape) {
    case ErrorShape::kNormal:
      break;
    case ErrorShape::kUniform:
      return (random.uniform() - 0.5) * std::sqrt(12.0);
    case ErrorShape::kLaplace:
      return std::copysign(std::log(random.uniform()) / std::sqrt(2.0), random.uniform() - 0.5);
    case ErrorShape::kStudent5: {
      double chi_squared = 0.0;
      for (int i = 0; i < 5; ++i) chi_squared += std::pow(random.normal(), 2);
      return random.normal() * std::sqrt(3.0 / chi_squared);
    }
    case ErrorShape::kGamma4:
      return 0.5 * (sum_of_logarithms(random, 4) - 4.0);
    case ErrorShape::kExponential:
      return sum_of_logarithms(random, 1) - 1.0;
    case ErrorShape::kLognormal: {
      const double mean = std::exp(0.125), sd = mean * std::sqrt(std::expm1(0.25));
      return (std::exp(0.5 * random.normal()) - mean) / sd;
    }
    case ErrorShape::kWeibull: {
      const double mean = std::tgamma(1.0 + 1.0 / 1.5);
      const double sd = std::sqrt(std::tgamma(1.0 + 2.0 / 1.5) - mean * mean);
      return (std::pow(sum_of_logarithms(random, 1), 1.0 / 1.5) - mean) / sd;
    }
    case ErrorShape::kLogistic: {
      const double u = random.uniform();
      return std::log(u / (1.0 - u)) * std::sqrt(3.0) / std::numbers::pi;
    }
    case ErrorShape::kContaminated:
      return (random.uniform() < 0.1 ? 3.0 : 1.0) * random.normal() / std::sqrt(1.8);
    case ErrorShape::kTriangular:
      return (random.uniform() + random.uniform() - 1.0) * std::sqrt(6.0);
    case ErrorShape::kBeta: {
      const double a = sum_of_logarithms(random, 2), b = sum_of_logarithms(random, 5);
      return (a / (a + b) - 2.0 / 7.0) / std::sqrt(10.0 / (49.0 * 8.0));
    }
  }
  return random.normal();
}

int SimulatedStudy::rows() const {
  int sum = 0;
  for (int k = 0; k < operators * techniques; ++k)
    sum += cuts[static_cast<size_t>(k) % cuts.size()];
  return sum;
}

DrawnStudy draw_study(const SimulatedStudy& study, Random& random) {
  DrawnStudy drawn;
  Table& table = drawn.table;
  table.source = "simulated";
  table.columns = {"operator", study.response};
  if (study.groups > 1) table.columns.emplace_back("group");
  if (study.techniques > 1) table.columns.emplace_back("technique");
  const std::string movement = "guide_movement_" + study.response;
  if (study.with_movement) table.columns.push_back(movement);
  int line = 1;
  for (int o = 0; o < study.operators; ++o) {
    const double of_operator = random.normal(0.0, study.operator_sd);
    drawn.bias.emplace_back();
    for (int t = 0; t < study.techniques; ++t) {
      const double bias = of_operator + random.normal(0.0, study.operator_technique_sd);
      drawn.bias.back().push_back(bias);
      const size_t cell = static_cast<size_t>(o * study.techniques + t);
      for (int i = 0; i < study.cuts[cell % study.cuts.size()]; ++i) {
        const Cut cut = draw_cut(study, t, random);
        std::vector<std::string> cells = {operator_name(o), fmt::format("{}", bias + cut.error)};
        if (study.groups > 1) cells.push_back(fmt::format("g{}", o % study.groups));
        if (study.techniques > 1) cells.push_back(technique_name(t));
        if (study.with_movement) cells.push_back(fmt::format("{}", cut.movement));
        drawn.movement_mean += cut.movement / study.rows();
        table.rows.push_back({++line, std::move(cells)});
      }
    }
  }
  return drawn;
}

double SimulatedPopulation::share_outside(const std::vector<double>& of, double limit) const {
  return 1.0 - content(of, {-limit, limit});
}

double SimulatedPopulation::content(const std::vector<double>& of, const Interval& interval) const {
  const auto low = std::lower_bound(of.begin(), of.end(), interval.low);
  const auto high = std::upper_bound(of.begin(), of.end(), interval.high);
  return static_cast<double>(high - low) / static_cast<double>(of.size());
}

SimulatedPopulation draw_population(const SimulatedStudy& study, int draws, std::uint64_t seed) {
  Random random(seed, 1);
  SimulatedPopulation population;
  const auto draw = [&] {
    return random.normal(0.0, study.operator_sd) +
           random.normal(0.0, study.techniques > 1 ? study.operator_technique_sd : 0.0) +
           draw_cut(study, 0, random).error;
  };
  for (int i = 0; i < draws; ++i) {
    population.one.push_back(draw());
    population.two.push_back(draw() + draw());
  }
  std::sort(population.one.begin(), population.one.end());
  std::sort(population.two.begin(), population.two.end());
  return population;
}

void count_coverage(const SimulatedStudy& study, const SimulatedPopulation& population,
                    const DrawnStudy& drawn, const StudyReport& report, CoverageCounts& counts) {
  bool normal = true;
  for (const AssumptionRecord& a : report.assumptions) {
    if (a.name.starts_with("normal residuals")) normal = normal && a.holds;
  }
  for (const VariabilityRecord& v : report.variability) {
    const std::optional<double> truth = true_sd(study, v.group);
    if (!truth) continue;
    const std::string of = "SD, " + kind_of_group(v.factor);
    count(counts, of + ", chi-squared", v.interval, *truth);
    if (v.bootstrap_interval) {
      count(counts, of + ", without normality", *v.bootstrap_interval, *truth);
    }
    // What a reader would have who let the test of normality choose between the two.
    const bool chosen = !normal && v.bootstrap_interval;
    count(counts, of + ", chosen by the test", chosen ? *v.bootstrap_interval : v.interval, *truth);
  }
  for (const TestRecord& t : report.tests) {
    if (!t.interval) continue;
    const bool inside = t.term.find(" | ") != std::string::npos;
    double truth = t.statistic_name == "F" ? 1.0 : 0.0;
    if (t.name == "F-test of variances") {
      const std::string factor = t.term.substr(0, t.term.find(':'));
      if (factor == "technique") {
        truth = std::pow(
            cut_sd(study, index_after(t.term, ": t")) / cut_sd(study, index_after(t.term, "/ t")),
            2.0);
      }
    } else if (inside) {
      const std::vector<double>& bias = drawn.bias[index_after(t.term, "| operator o")];
      truth = bias[index_after(t.term, ": t")] - bias[index_after(t.term, "- t")];
    } else if (t.name == "bias t-test") {
      truth = drawn.bias[index_after(t.term, " o")]
                        [study.techniques > 1 ? index_after(t.term, "× t") : 0];
    }
    count(counts, t.name + (inside ? ", one operator" : ""), *t.interval, truth);
  }
  // What follows has one truth only where the techniques' SDs are alike.
  if (!techniques_alike(study)) return;
  for (const ForecastRecord& f : report.forecasts) {
    const std::string of = ", " + kind_of_group(f.factor);
    count(counts, "share outside, one cut" + of, f.one_cut.outside.interval,
          population.share_outside(population.one, report.design.limit_deg));
    count(counts, "share outside, alignment" + of, f.alignment.outside.interval,
          population.share_outside(population.two, report.design.limit_deg));
    const double wanted = report.design.tolerance_content;
    // Held where the interval has the wanted content or more.
    const auto content = [&](const char* what, const Interval& interval,
                             const std::vector<double>& errors) {
      CoverageCount& c = counts[what + of];
      (population.content(errors, interval) >= wanted ? c.held : c.below) += 1;
    };
    content("tolerance interval, one cut", f.one_cut.tolerance, population.one);
    content("tolerance interval, alignment", f.alignment.tolerance, population.two);
  }
  const double slope = study.cut_sd.front() * std::sqrt(study.movement_share);
  const double total = study.cut_sd.front() * study.cut_sd.front() +
                       study.operator_sd * study.operator_sd +
                       study.operator_technique_sd * study.operator_technique_sd;
  for (const RegressionRecord& r : report.regressions) {
    const std::string of = ", " + kind_of_group(r.factor);
    count(counts, "slope" + of, r.slope_interval, slope);
    if (r.intercept_interval) count(counts, "intercept" + of, *r.intercept_interval, 0.0);
    if (r.r_squared_interval) {
      count(counts, "r²" + of, *r.r_squared_interval, slope * slope / total);
    }
  }
  for (const ComponentRecord& c : report.components) {
    double truth = study.cut_sd.front();
    if (c.component.name == "operator") truth = study.operator_sd;
    if (c.component.name == "operator × technique") truth = study.operator_technique_sd;
    if (study.techniques == 1 && c.component.name == "operator") {
      truth = std::hypot(study.operator_sd, study.operator_technique_sd);
    }
    count(counts, "component " + c.component.name, c.component.sd_interval, truth);
  }
  for (const AdjustedMeanRecord& a : report.adjusted_means) {
    count(counts, "adjusted mean", a.adjusted.interval, slope * drawn.movement_mean);
  }
}

}  // namespace osteomill::study
