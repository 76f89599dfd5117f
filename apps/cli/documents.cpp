// SPDX-License-Identifier: BSD-3-Clause
#include "documents.hpp"

#include <fmt/format.h>

#include <chrono>
#include <set>

#include "osteomill/io/report.hpp"
#include "osteomill/io/run_directory.hpp"
#include "osteomill/io/run_record.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;

struct NamedRun {
  std::string name;
  Shown shown;
};

Json document_of(const std::vector<NamedRun>& runs) {
  if (runs.size() == 1) return runs.front().shown.document;
  Json list = Json::array();
  for (const NamedRun& run : runs) {
    Json one = {{"name", run.name}};
    one.update(run.shown.document);
    list.push_back(one);
  }
  return {{"runs", list}};
}

Json case_of(const std::vector<NamedRun>& runs) {
  if (runs.size() == 1) return runs.front().shown.expanded;
  Json list = Json::array();
  for (const NamedRun& run : runs) {
    Json one = {{"name", run.name}};
    one.update(run.shown.expanded);
    list.push_back(one);
  }
  return {{"run", list}};
}

io::ReportTable table_of(const std::vector<std::vector<std::string>>& rows) {
  io::ReportTable table;
  for (const std::string& heading : rows.front()) table.columns.push_back({.name = heading});
  for (std::size_t i = 1; i < rows.size(); ++i) {
    std::vector<io::ReportCell> cells(table.columns.size());
    for (std::size_t k = 0; k < rows[i].size() && k < cells.size(); ++k) {
      if (!rows[i][k].empty()) cells[k] = rows[i][k];
    }
    table.rows.push_back(cells);
  }
  return table;
}

void write_directory(const CaseArguments& arguments, const std::string& command,
                     const std::vector<NamedRun>& runs, const Json& document, double wall_time) {
  io::RunDirectory output(arguments.directory);
  io::ReportData report;
  report.title = fmt::format("osteomill {}: {}", command, arguments.case_file.stem().string());
  report.program = "osteomill " OSTEOMILL_VERSION;
  report.created = io::now_text();
  report.expanded_case = case_of(runs).dump(2);
  std::set<std::string> said;
  for (const NamedRun& run : runs) {
    io::ReportSection section;
    section.heading = runs.size() == 1 ? "Results" : run.name;
    for (const std::string& sentence : run.shown.sentences) {
      section.blocks.emplace_back(io::ReportParagraph{sentence});
    }
    for (const Figure& figure : run.shown.figures) {
      const std::string prefix = runs.size() == 1 ? "" : run.name + "-";
      const auto file = output.file(prefix + figure.name + ".png");
      figure.draw(file);
      section.blocks.emplace_back(io::ReportPicture{figure.caption, io::read_text_file(file)});
    }
    for (const TextFile& file : run.shown.files) {
      const std::string prefix = runs.size() == 1 ? "" : run.name + "-";
      io::write_text_file(output.file(prefix + file.name), file.text);
    }
    for (const WrittenFile& file : run.shown.written) {
      file.write(output.file((runs.size() == 1 ? "" : run.name + "-") + file.name));
    }
    if (run.shown.rows.size() > 1) section.blocks.emplace_back(table_of(run.shown.rows));
    for (const auto& rows : run.shown.tables) section.blocks.emplace_back(table_of(rows));
    report.sections.push_back(std::move(section));
    for (const std::string& warning : run.shown.warnings) {
      if (said.insert(warning).second) {
        report.notes.push_back({.kind = io::ReportNote::Kind::warning, .text = warning});
      }
    }
  }
  io::write_report(output.file("report.html"), report);
  io::write_run_json(output.file("run.json"),
                     {"osteomill " OSTEOMILL_VERSION, command, case_of(runs), document, wall_time});
  output.commit();
}

}  // namespace

void show_runs(const CaseArguments& arguments, const std::string& command,
               const std::function<Shown(const io::CaseRun&)>& solve) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<NamedRun> runs;
  for (const io::CaseRun& one : io::read_case(arguments.case_file, arguments.overrides)) {
    runs.push_back({one.name, solve(one)});
    for (const std::string& warning : runs.back().shown.warnings) warn(warning);
  }
  const double wall_time =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const Json document = document_of(runs);
  if (arguments.format == Format::json) print_json(document);
  for (const NamedRun& run : runs) {
    if (arguments.format == Format::json) break;
    if (arguments.format == Format::csv) {
      print_csv(run.shown.rows);
      continue;
    }
    if (runs.size() > 1) fmt::print("{}\n", run.name);
    print_table(run.shown.rows);
    for (const auto& rows : run.shown.tables) {
      fmt::print("\n");
      print_table(rows);
    }
    if (!run.shown.tables.empty()) fmt::print("\n");
    for (const std::string& sentence : run.shown.sentences) fmt::print("{}\n", sentence);
    if (runs.size() > 1 && &run != &runs.back()) fmt::print("\n");
  }
  if (!arguments.directory.empty()) {
    write_directory(arguments, command, runs, document, wall_time);
  }
}

}  // namespace osteomill::cli
