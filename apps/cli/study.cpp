// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <functional>

#include "command.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/io/study_case.hpp"
#include "osteomill/io/study_json.hpp"

namespace osteomill::cli {
namespace {

using Rows = std::vector<std::vector<std::string>>;

struct Arguments {
  std::filesystem::path table;
  std::filesystem::path design;
  std::vector<std::string> overrides;
  Format format = Format::table;
  std::filesystem::path directory;
};

std::string p_text(double p) {
  return p < 1e-4 ? fmt::format("{:.1e}", p) : fmt::format("{:.4f}", p);
}

bool is_pairwise(const study::TestRecord& test) { return test.estimate.has_value(); }

Rows test_rows(const study::StudyReport& report,
               const std::function<bool(const study::TestRecord&)>& shown) {
  Rows rows = {{"test", "response", "term", "statistic", "df1", "df2", "p", "corrected p"}};
  for (const study::TestRecord& t : report.tests) {
    if (!shown(t)) continue;
    std::string corrected;
    for (const study::Correction& c : t.corrections) {
      corrected += (corrected.empty() ? "" : ", ") + c.name + " " + p_text(c.p);
    }
    rows.push_back({t.name, t.response, t.term,
                    fmt::format("{} {:.4f}", t.statistic_name, t.statistic),
                    fmt::format("{:.4g}", t.df1), t.df2 ? fmt::format("{:.4g}", *t.df2) : "",
                    p_text(t.p), corrected});
  }
  return rows;
}

Rows variability_rows(const study::StudyReport& report) {
  Rows rows = {{"variability", "response", "group", "cuts", "SD", "95 % interval", "df",
                fmt::format("SD of {} cuts", report.design.cuts_per_alignment)}};
  rows[0][5] = fmt::format("{:g} % interval", 100.0 * report.design.confidence);
  for (const study::VariabilityRecord& v : report.variability) {
    rows.push_back(
        {v.factor, v.response, v.group, fmt::format("{}", v.count), fmt::format("{:.3g}", v.sd),
         fmt::format("{:.3g} ... {:.3g}", v.interval.low, v.interval.high),
         fmt::format("{:g}", v.degrees_of_freedom),
         study::unit_of(v.response) == "deg" ? fmt::format("{:.3g}", v.combined_sd) : ""});
  }
  return rows;
}

Rows assumption_rows(const study::StudyReport& report) {
  Rows rows = {{"assumption", "response", "term", "statistic", "p", "holds"}};
  for (const study::AssumptionRecord& a : report.assumptions) {
    rows.push_back({a.name, a.response, a.term, fmt::format("{:.4g}", a.statistic), p_text(a.p),
                    a.holds ? "yes" : "NO"});
  }
  return rows;
}

Rows component_rows(const study::StudyReport& report) {
  Rows rows = {{"variance component", "response", "SD", "interval", "share, %"}};
  for (const study::ComponentRecord& c : report.components) {
    rows.push_back({c.component.name, c.response, fmt::format("{:.3g}", c.component.sd),
                    fmt::format("{:.3g} ... {:.3g}", c.component.sd_interval.low,
                                c.component.sd_interval.high),
                    fmt::format("{:.0f}", 100.0 * c.component.share)});
  }
  return rows;
}

Rows forecast_rows(const study::StudyReport& report) {
  Rows rows = {{"forecast", "response", "group", "mean", "total SD", "tolerance interval",
                fmt::format("outside {:g} deg, %", report.design.limit_deg), "interval"}};
  for (const study::ForecastRecord& f : report.forecasts) {
    rows.push_back({f.factor, f.response, f.group, fmt::format("{:.2f}", f.mean),
                    fmt::format("{:.2f}", f.total_sd),
                    fmt::format("{:.2f} ... {:.2f}", f.tolerance.low, f.tolerance.high),
                    fmt::format("{:.2g}", 100.0 * f.one_cut.estimate),
                    fmt::format("{:.2g} ... {:.2g}", 100.0 * f.one_cut.interval.low,
                                100.0 * f.one_cut.interval.high)});
  }
  return rows;
}

Rows regression_rows(const study::StudyReport& report) {
  Rows rows = {{"regression on", "response", "group", "cuts", "slope", "intercept", "r2, %",
                "interval", "p"}};
  for (const study::RegressionRecord& g : report.regressions) {
    rows.push_back({g.covariate, g.response, g.group, fmt::format("{}", g.count),
                    fmt::format("{:.3f}", g.slope), fmt::format("{:.3f}", g.intercept),
                    fmt::format("{:.1f}", 100.0 * g.r_squared),
                    g.r_squared_interval
                        ? fmt::format("{:.1f} ... {:.1f}", 100.0 * g.r_squared_interval->low,
                                      100.0 * g.r_squared_interval->high)
                        : "",
                    p_text(g.p)});
  }
  return rows;
}

Rows adjusted_rows(const study::StudyReport& report) {
  Rows rows = {{"adjusted mean", "response", "mean", "standard error", "interval"}};
  for (const study::AdjustedMeanRecord& a : report.adjusted_means) {
    rows.push_back(
        {a.adjusted.level, a.response, fmt::format("{:.5f}", a.adjusted.mean),
         fmt::format("{:.5f}", a.adjusted.standard_error),
         fmt::format("{:.3f} ... {:.3f}", a.adjusted.interval.low, a.adjusted.interval.high)});
  }
  return rows;
}

void print_report(const study::StudyReport& report) {
  bool first = true;
  for (const Rows& rows :
       {test_rows(report, std::not_fn(is_pairwise)), assumption_rows(report),
        variability_rows(report), component_rows(report), forecast_rows(report),
        regression_rows(report), adjusted_rows(report), test_rows(report, is_pairwise)}) {
    if (rows.size() < 2) continue;
    if (!first) fmt::print("\n");
    first = false;
    print_table(rows);
  }
  for (const study::AssumptionRecord& a : report.assumptions) {
    if (!a.holds) {
      fmt::print("\n{}, {}, {}: does not hold (p = {}): {}.\n", a.response, a.term, a.name,
                 p_text(a.p), a.consequence);
    }
  }
}

void warn_of(const study::StudyReport& report) {
  for (const study::Finding& f : report.findings) {
    std::string lines;
    for (size_t i = 0; i < f.lines.size() && i < 12; ++i) {
      lines += fmt::format("{}{}", i == 0 ? " (line " : ", ", f.lines[i]);
    }
    if (!lines.empty()) lines += f.lines.size() > 12 ? ", ...)" : ")";
    warn(f.what + lines + "; " + f.still);
  }
}

void run(const Arguments& arguments) {
  if (arguments.table.empty()) {
    throw InvalidInput(Fault{"table", "", "is missing", "osteomill study CUTS.csv"});
  }
  const study::Table table = io::read_study_table(arguments.table);
  const io::StudyDesign design = io::read_study_design(arguments.design, arguments.overrides);
  const study::StudyReport report = study::analyse_study(table, design.design, console_progress());
  warn_of(report);
  switch (arguments.format) {
    case Format::json:
      print_json(io::study_document(report));
      break;
    case Format::csv:
      print_csv(test_rows(report, [](const study::TestRecord&) { return true; }));
      break;
    case Format::table:
      print_report(report);
      break;
  }
}

void plan(const Arguments& arguments) {
  const io::StudyPlanCase c = io::read_study_plan(arguments.design, arguments.overrides);
  const study::Plan plan = study::plan_study(c.options);
  if (!plan.feasible) throw NoSolution("study plan: " + plan.reason);
  if (arguments.format == Format::json) return print_json(io::plan_document(plan));
  Rows rows = {{"operators", "cuts", "power"}};
  for (const study::PlanPoint& p : plan.curve) {
    rows.push_back({fmt::format("{}", p.operators), fmt::format("{}", p.cuts),
                    fmt::format("{:.4f}", p.power)});
  }
  if (arguments.format == Format::csv) return print_csv(rows);
  fmt::print("{} operators, {} cuts in all: power {:.3f}\n\n", plan.least.operators,
             plan.least.cuts, plan.least.power);
  print_table(rows);
}

}  // namespace

void add_study(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("study", "statistics of cutting errors");
  command->add_option("table", arguments->table, "the cuts, a CSV file with one row a cut");
  command->add_option("--design", arguments->design, "what the columns are, a TOML file");
  command->add_option("--set", arguments->overrides, "replace a key of the design: key=value")
      ->allow_extra_args(false);
  add_format(*command, arguments->format);
  command->add_option("-o,--output", arguments->directory, "write a run directory");

  auto plan_arguments = std::make_shared<Arguments>();
  CLI::App* plan_command = command->add_subcommand("plan", "sample size of a study to be made");
  plan_command->add_option("case", plan_arguments->design,
                           "what the study shall show, a TOML file");
  plan_command->add_option("--set", plan_arguments->overrides, "replace a key: key=value")
      ->allow_extra_args(false);
  add_format(*plan_command, plan_arguments->format);
  plan_command->callback([plan_arguments] { plan(*plan_arguments); });
  command->callback([command, arguments] {
    if (command->get_subcommands().empty()) run(*arguments);
  });
}

}  // namespace osteomill::cli
