// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <chrono>
#include <set>

#include "command.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/cl_file.hpp"
#include "osteomill/io/gcode_writer.hpp"
#include "osteomill/io/run_directory.hpp"
#include "osteomill/io/run_record.hpp"
#include "osteomill/io/simulate_picture.hpp"
#include "osteomill/io/simulate_report.hpp"
#include "osteomill/io/simulate_result.hpp"
#include "osteomill/io/text_file.hpp"
#include "simulated_runs.hpp"

namespace osteomill::cli {
namespace {

const char* const kProgram = "osteomill " OSTEOMILL_VERSION;

void write_directory(const std::filesystem::path& directory, const std::string& title,
                     const std::vector<io::SimulatedRun>& runs,
                     const nlohmann::ordered_json& summary, double wall_time) {
  io::RunDirectory output(directory);
  io::write_run_json(output.file("run.json"),
                     {kProgram, "simulate", io::case_of(runs), summary, wall_time});
  io::ReportData report = io::report_of(runs, title, kProgram);
  io::RunSurfaces surfaces = io::surfaces_of(runs);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string& name = runs[i].input.name;
    io::draw(io::plot_of(runs[i]), output.file(name + ".png"));
    if (runs[i].path) {
      if (runs[i].path->upright())
        io::write_text_file(output.file(name + ".ngc"), io::write_gcode(*runs[i].path));
      io::write_text_file(output.file(name + ".cl"), io::write_cl(*runs[i].path));
    }
    const auto add = [&](const io::Picture& picture, const char* suffix, const char* caption) {
      const std::filesystem::path file = output.file(name + suffix);
      io::draw(picture, file);
      report.pictures.push_back(
          {name + caption, io::read_text_file(file), report.pictures.empty()});
    };
    add(io::picture_of(runs, surfaces, i), "_bone.png", ": the bone before and after");
    add(io::force_picture_of(runs, surfaces, i), "_force.png", ": mean force along the path");
  }
  io::add_scene(report, runs, std::move(surfaces));
  io::write_signals(io::signals_of(runs), output.file("signals.h5"));
  io::write_report(output.file("report.html"), report);
  output.commit();
}

void run(const CaseArguments& arguments) {
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<io::SimulateCase> cases =
      io::read_simulate_cases(io::read_case(arguments.case_file, arguments.overrides));
  const std::vector<io::SimulatedRun> runs = io::run_simulations(cases, console_progress());
  const double wall_time =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  const nlohmann::ordered_json document = io::document_of(runs, wall_time);
  std::set<std::string> said;  // runs of one bone have the same warnings
  for (const io::SimulatedRun& done : runs) {
    for (const std::string& warning : done.warnings) {
      if (said.insert(warning).second) warn(warning);
    }
  }
  print_runs(arguments.format, runs, document);
  if (!arguments.directory.empty()) {
    write_directory(arguments.directory, arguments.case_file.stem().string(), runs, document,
                    wall_time);
  }
  if (interrupted()) throw Interrupted{};
}

}  // namespace

void print_runs(Format format, const std::vector<io::SimulatedRun>& runs,
                const nlohmann::ordered_json& document, const std::vector<std::string>& more) {
  switch (format) {
    case Format::json:
      print_json(document);
      break;
    case Format::csv:
      print_csv(io::table_of(runs));
      break;
    case Format::table:
      print_table(io::table_of(runs));
      for (const std::string& sentence : io::comparisons_of(runs)) fmt::print("{}\n", sentence);
      for (const std::string& sentence : more) fmt::print("{}\n", sentence);
      break;
  }
}

void add_simulate(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = program.add_subcommand(
      "simulate", "mill a stock along a tool path, at constant feed or under a controller");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace osteomill::cli
