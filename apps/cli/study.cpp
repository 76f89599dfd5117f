// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <chrono>
#include <functional>
#include <utility>

#include "command.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/run_directory.hpp"
#include "osteomill/io/run_record.hpp"
#include "osteomill/io/study_case.hpp"
#include "osteomill/io/study_figures.hpp"
#include "osteomill/io/study_json.hpp"
#include "osteomill/io/study_measure.hpp"
#include "osteomill/io/study_report.hpp"
#include "osteomill/io/text_file.hpp"

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

/// Level against level; of the many tests inside single operators those that stand after Holm.
bool is_worth_a_line(const study::TestRecord& test) {
  if (!is_pairwise(test)) return false;
  const bool inside = test.name == "bias t-test" || test.term.find(" | ") != std::string::npos;
  return !inside || (test.corrections.empty() ? test.p : test.corrections.front().p) < 0.05;
}

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
                fmt::format("SD of {} cuts", report.design.cuts_per_alignment), "without normality",
                "held"}};
  rows[0][5] = fmt::format("{:g} % interval", 100.0 * report.design.confidence);
  for (const study::VariabilityRecord& v : report.variability) {
    if (v.factor.starts_with(report.design.subject + " × ")) continue;  // in JSON and the report
    rows.push_back(
        {v.factor, v.response, v.group, fmt::format("{}", v.count), fmt::format("{:.3g}", v.sd),
         fmt::format("{:.3g} ... {:.3g}", v.interval.low, v.interval.high),
         fmt::format("{:g}", v.degrees_of_freedom),
         study::unit_of(v.response) == "deg" ? fmt::format("{:.3g}", v.combined_sd) : "",
         v.bootstrap_interval ? fmt::format("{:.3g} ... {:.3g}", v.bootstrap_interval->low,
                                            v.bootstrap_interval->high)
                              : "",
         v.bootstrap_interval ? io::coverage_words(v.bootstrap_coverage) : ""});
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
    rows.push_back(
        {f.factor, f.response, f.group, fmt::format("{:.2f}", f.one_cut.mean),
         fmt::format("{:.2f}", f.one_cut.sd),
         fmt::format("{:.2f} ... {:.2f}", f.one_cut.tolerance.low, f.one_cut.tolerance.high),
         fmt::format("{:.2g}", 100.0 * f.one_cut.outside.estimate),
         fmt::format("{:.2g} ... {:.2g}", 100.0 * f.one_cut.outside.interval.low,
                     100.0 * f.one_cut.outside.interval.high)});
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
        regression_rows(report), adjusted_rows(report), test_rows(report, is_worth_a_line)}) {
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
  fmt::print("\n{}\n", study::normality_note());
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

void write_directory(const Arguments& arguments, const study::StudyReport& report,
                     const nlohmann::ordered_json& input, const nlohmann::ordered_json& document,
                     double wall_time) {
  const std::string program = "osteomill " OSTEOMILL_VERSION;
  io::RunDirectory output(arguments.directory);
  io::ReportData page = io::study_page(report, arguments.table.stem().string());
  page.program = program;
  page.created = io::now_text();
  page.expanded_case = input.dump(2);
  io::ReportSection figures{"Figures", {}};
  for (const io::StudyFigure& figure : io::study_figures(report)) {
    const auto file = output.file(figure.name + ".png");
    figure.draw(file);
    figures.blocks.emplace_back(io::ReportPicture{figure.caption, io::read_text_file(file)});
  }
  if (!figures.blocks.empty()) page.sections.insert(page.sections.begin(), std::move(figures));
  io::write_report(output.file("report.html"), page);
  io::write_run_json(output.file("run.json"), {program, "study", input, document, wall_time});
  output.commit();
}

/// A design or the run.json of a run may stand in the table's place: they name their table.
bool is_design(const std::filesystem::path& file) {
  return file.extension() == ".json" || file.extension() == ".toml";
}

void run(Arguments arguments) {
  const auto begin = std::chrono::steady_clock::now();
  if (arguments.design.empty() && is_design(arguments.table)) {
    arguments.design = std::exchange(arguments.table, {});
  }
  const io::StudyDesign design = io::read_study_design(arguments.design, arguments.overrides);
  if (arguments.table.empty()) arguments.table = design.table;
  if (arguments.table.empty()) {
    throw InvalidInput(Fault{"table", "", "is missing",
                             "osteomill study CUTS.csv, or table = \"CUTS.csv\" in the design"});
  }
  const study::Table table = io::read_study_table(arguments.table);
  const study::StudyReport report = study::analyse_study(table, design.design, console_progress());
  if (interrupted()) throw Interrupted();
  warn_of(report);
  const nlohmann::ordered_json document = io::study_document(report);
  switch (arguments.format) {
    case Format::json:
      print_json(document);
      break;
    case Format::csv:
      print_csv(test_rows(report, [](const study::TestRecord&) { return true; }));
      break;
    case Format::table:
      print_report(report);
      break;
  }
  if (arguments.directory.empty()) return;
  nlohmann::ordered_json input = design.expanded;
  input["table"] = std::filesystem::absolute(arguments.table).lexically_normal().string();
  const double wall_time =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  write_directory(arguments, report, input, document, wall_time);
}

struct MeasureArguments {
  std::filesystem::path cuts, points, placements;
  Format format = Format::csv;
};

/// The tidy table on standard output, ready for `osteomill study`.
void measure(const MeasureArguments& arguments) {
  if (!arguments.placements.empty()) {
    const io::MeasuredPrecision p = io::measure_precision(io::read_csv(arguments.placements));
    const auto row = [](const char* name, const study::PlacementPrecision& of) {
      return std::vector<std::string>{name, fmt::format("{}", of.placements),
                                      fmt::format("{:.4f}", of.sd / units::deg),
                                      fmt::format("{:.4f}", of.upper / units::deg)};
    };
    const Rows rows = {{"measurement", "placements", "sd_deg", "sd_upper95_deg"},
                       row("varus_valgus", p.varus_valgus),
                       row("flexion_extension", p.flexion_extension)};
    if (arguments.format == Format::json) {
      const auto json = [](const study::PlacementPrecision& of) {
        return nlohmann::ordered_json{{"placements", of.placements},
                                      {"sd_deg", of.sd / units::deg},
                                      {"sd_upper95_deg", of.upper / units::deg}};
      };
      return print_json({{"varus_valgus", json(p.varus_valgus)},
                         {"flexion_extension", json(p.flexion_extension)}});
    }
    return arguments.format == Format::csv ? print_csv(rows) : print_table(rows);
  }
  if (arguments.cuts.empty()) {
    throw InvalidInput(Fault{"cuts", "", "is missing",
                             "osteomill study measure POSES.csv, or --placements REPEATS.csv"});
  }
  std::optional<io::CsvFile> points;
  if (!arguments.points.empty()) points = io::read_csv(arguments.points);
  const io::MeasuredCuts measured = io::measure_cuts(io::read_csv(arguments.cuts), points);
  for (const std::string& warning : measured.warnings) warn(warning);
  Rows rows = {measured.table.columns};
  for (const io::CsvFile::Row& row : measured.table.rows) rows.push_back(row.cells);
  if (arguments.format == Format::table) return print_table(rows);
  if (arguments.format == Format::csv) return print_csv(rows);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (size_t r = 1; r < rows.size(); ++r) {
    nlohmann::ordered_json cut;
    for (size_t c = 0; c < rows[0].size(); ++c) {
      const std::string unit = study::unit_of(rows[0][c]);
      const bool number = !unit.empty() && !study::is_missing(rows[r][c]);
      if (number) {
        cut[rows[0][c]] = std::stod(rows[r][c]);
      } else {
        cut[rows[0][c]] = rows[r][c];
      }
    }
    list.push_back(std::move(cut));
  }
  print_json({{"cuts", list}});
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
  command->add_option("table", arguments->table,
                      "the cuts, a CSV file with one row a cut; or the run.json of a run");
  command->add_option("--design", arguments->design, "what the columns are, a TOML file");
  command->add_option("--set", arguments->overrides, "replace a key of the design: key=value")
      ->allow_extra_args(false);
  add_format(*command, arguments->format);
  command->add_option("-o,--output", arguments->directory, "write a run directory");

  auto measure_arguments = std::make_shared<MeasureArguments>();
  CLI::App* measure_command =
      command->add_subcommand("measure", "tracker exports to the table of cutting errors");
  measure_command->add_option("cuts", measure_arguments->cuts, "guide and cut orientations, CSV");
  measure_command->add_option("--points", measure_arguments->points, "digitised points, CSV");
  measure_command->add_option("--placements", measure_arguments->placements,
                              "repeated placements on one cut: the precision instead");
  add_format(*measure_command, measure_arguments->format);
  measure_command->callback([measure_arguments] { measure(*measure_arguments); });
  command->callback([command, arguments] {
    if (command->get_subcommands().empty()) run(*arguments);
  });
}

void add_study_plan(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      program.get_subcommand("study")->add_subcommand("plan", "sample size of a study to be made");
  command->add_option("case", arguments->design, "what the study shall show, a TOML file");
  command->add_option("--set", arguments->overrides, "replace a key: key=value")
      ->allow_extra_args(false);
  add_format(*command, arguments->format);
  command->callback([arguments] { plan(*arguments); });
}

}  // namespace osteomill::cli
