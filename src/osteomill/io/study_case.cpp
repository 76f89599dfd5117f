// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/study_case.hpp"

#include "osteomill/io/case_file.hpp"
#include "osteomill/io/csv_file.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

constexpr Quantity kNone{1.0, ""};
constexpr Quantity kDegrees{1.0, "deg"};  // of the table's columns: statistics keep their unit
const Range kOpenShare{0.0, 0.999999, true};

struct DesignCase {
  study::Design design;
  int seed = 1;
  std::optional<double> measurement_varus, measurement_flexion;
  std::filesystem::path table;
};

void bind_design(Section& s, DesignCase& c) {
  using study::SumOfSquares;
  study::Design& d = c.design;
  const Need optional = Need::optional;
  s.file("table", c.table, "the cuts, a CSV file; the command line may name it instead", optional);
  s.texts("between", d.between, "factors that differ between subjects", optional);
  s.texts("within", d.within, "factors that every subject meets at each level", optional);
  s.text("subject", d.subject, "column of who or what was measured again", optional);
  s.texts("blocks", d.blocks, "factors taken out before the others, without interactions",
          optional);
  s.texts("covariates", d.covariates,
          "numbers to adjust for; guide_movement_X goes with response X", optional);
  s.texts("responses", d.responses, "measured columns; default: the two errors, time, removal rate",
          optional);
  s.texts("random", d.random, "further random factors; specimen is taken by itself", optional);
  s.texts("exclusive_means", d.exclusive_means,
          "cells whose means are taken out before SDs are pooled", optional);
  s.choice("sum_of_squares", d.sum_of_squares,
           {{"I", SumOfSquares::kI}, {"II", SumOfSquares::kII}, {"III", SumOfSquares::kIII}},
           "how terms share an unbalanced design: in order, hierarchical, each after all",
           optional);
  s.number("confidence", d.confidence, kNone, kOpenShare, "of every interval", optional);
  s.number("alpha", d.alpha, kNone, kOpenShare, "an assumption with p below it has failed",
           optional);
  s.number("limit_deg", d.limit_deg, kDegrees, positive(), "alignment window, plus and minus",
           optional);
  s.integer("cuts_per_alignment", d.cuts_per_alignment, between(1, 20),
            "cuts that an implant's alignment rests on", optional);
  s.number("tolerance_content", d.tolerance_content, kNone, kOpenShare,
           "share of cuts that a tolerance interval holds", optional);
  s.number("measurement_sd_varus_valgus_deg", c.measurement_varus, kDegrees, non_negative(),
           "SD of repeated placements");
  s.number("measurement_sd_flexion_extension_deg", c.measurement_flexion, kDegrees, non_negative(),
           "SD of repeated placements");
  s.integer("seed", c.seed, between(0, 2147483647), "of everything that is drawn", optional);
  s.integer("bootstrap_draws", d.bootstrap_draws, between(199, 1000000), "draws of the bootstrap",
            optional);
  s.integer("forecast_draws", d.forecast_draws, between(199, 1000000), "draws of the forecasts",
            optional);
  s.integer("component_draws", d.component_draws, between(19, 1000000),
            "simulated studies for each value tried of a variance component's interval", optional);
}

void bind_plan(Section& s, study::PlanOptions& o) {
  using study::PlanQuestion;
  const Need optional = Need::optional;
  s.choice("question", o.question,
           {{"means-paired", PlanQuestion::kMeansPaired},
            {"means-groups", PlanQuestion::kMeansGroups},
            {"sd-ratio", PlanQuestion::kSdRatio},
            {"sd-precision", PlanQuestion::kSdPrecision},
            {"share-outside", PlanQuestion::kShareOutside}},
           "what the study shall show");
  s.number("within_operator_sd_deg", o.within_operator_sd, kDegrees, positive(), "cut to cut");
  s.number("between_operator_sd_deg", o.between_operator_sd, kDegrees, non_negative(),
           "of the operators' means; means-groups, share-outside", optional);
  s.number("operator_by_technique_sd_deg", o.operator_by_technique_sd, kDegrees, non_negative(),
           "of the operators' differences; means-paired", optional);
  s.number("difference_deg", o.difference, kDegrees, any(),
           "least difference of the means worth finding; means-*", optional);
  s.number("sd_ratio", o.sd_ratio, kNone, positive(), "new SD over old; sd-ratio", optional);
  s.number("relative_half_width", o.relative_half_width, kNone, positive(),
           "upper end of the interval over the SD, less 1; sd-precision", optional);
  s.number("limit_deg", o.limit, kDegrees, positive(), "window, plus and minus; share-outside",
           optional);
  s.number("mean_deg", o.mean, kDegrees, any(), "expected bias; share-outside", optional);
  s.number("largest_share", o.largest_share, kNone, kOpenShare,
           "share outside that is not to be passed; share-outside", optional);
  s.integer("cuts_per_operator", o.cuts_per_operator, between(1, 10000), "with each technique",
            optional);
  s.number("alpha", o.alpha, kNone, kOpenShare, "two-sided chance of a false alarm", optional);
  s.number("power", o.power, kNone, kOpenShare, "chance to find what is there", optional);
  s.integer("most_operators", o.most_operators, between(1, 100000), "where the search ends",
            optional);
}

/// A case without a file has its overrides alone.
CaseRun run_of(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  if (!file.empty()) return read_case(file, overrides).front();
  CaseRun run{"run", {}, std::filesystem::current_path()};
  for (const std::string& text : overrides) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw InvalidInput(Fault{"--set", text, "must read key=value", "e.g. --set alpha=0.01"});
    }
    const std::string key = text.substr(0, equals);
    run.tree.values[key] = parse_toml_value(text.substr(equals + 1));
    run.tree.places[key] = "--set";
  }
  return run;
}

}  // namespace

study::Table read_study_table(const std::filesystem::path& file) {
  CsvFile csv = read_csv(file);
  study::Table table{csv.name, std::move(csv.columns), {}};
  for (CsvFile::Row& row : csv.rows) table.rows.push_back({row.line, std::move(row.cells)});
  return table;
}

void bind_study(Section& section) {
  DesignCase design;
  bind_design(section, design);
}

void bind_study_plan(Section& section) {
  study::PlanOptions options;
  bind_plan(section, options);
}

StudyDesign read_study_design(const std::filesystem::path& file,
                              const std::vector<std::string>& overrides) {
  DesignCase c;
  StudyDesign result;
  result.expanded = Section::read(run_of(file, overrides), [&](Section& s) { bind_design(s, c); });
  c.design.seed = static_cast<std::uint64_t>(c.seed);
  if (c.measurement_varus) c.design.measurement_sd["varus_valgus_deg"] = *c.measurement_varus;
  if (c.measurement_flexion) {
    c.design.measurement_sd["flexion_extension_deg"] = *c.measurement_flexion;
  }
  result.table = std::move(c.table);
  result.design = std::move(c.design);
  return result;
}

StudyPlanCase read_study_plan(const std::filesystem::path& file,
                              const std::vector<std::string>& overrides) {
  StudyPlanCase result;
  result.expanded =
      Section::read(run_of(file, overrides), [&](Section& s) { bind_plan(s, result.options); });
  return result;
}

}  // namespace osteomill::io
