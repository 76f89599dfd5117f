// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <chrono>

#include "command.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/cl_file.hpp"
#include "osteomill/io/gcode_writer.hpp"
#include "osteomill/io/mesh_file.hpp"
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

/// What is left: as meshes, and in the report.
void write_finish(const io::SimulatedRun& run, io::RunDirectory& output, io::ReportData& report) {
  const std::string& name = run.input.name;
  const io::Finish& finish = *run.finish;
  geometry::Mesh in_mm = finish.mesh;
  for (float& value : in_mm.values) value /= static_cast<float>(units::mm);
  io::write_mesh(in_mm, output.file(name + "_finish.ply"),
                 io::ValueColours{io::ColourMap::deviation, -finish.scale, finish.scale});
  io::write_mesh(in_mm, output.file(name + "_finish.stl"));
  io::ReportSection section;
  section.heading = "What is left: " + name;
  section.blocks.emplace_back(io::ReportParagraph{io::finish_sentence(name, finish) + "."});
  const auto add = [&](const char* suffix, const char* caption, const auto& draw_to) {
    const std::filesystem::path file = output.file(name + suffix);
    draw_to(file);
    section.blocks.emplace_back(io::ReportPicture{caption, io::read_text_file(file)});
  };
  add("_finish.png", "deviation from the plan on the bone that is left", [&](const auto& file) {
    io::draw(io::finish_picture(finish, name + ": deviation from the plan", run.no_go), file);
  });
  add("_finish_map.png", "deviation from the plan, seen against its normal", [&](const auto& file) {
    io::draw(io::finish_map(finish, name + ": deviation from the plan"), file);
  });
  add("_finish_profiles.png", "the longest profile along the feed and across it",
      [&](const auto& file) {
        io::draw(io::finish_profiles(finish, name + ": profiles of the finished surface"), file);
      });
  report.sections.push_back(std::move(section));
}

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
    if (runs[i].finish) write_finish(runs[i], output, report);
  }
  io::add_scene(report, runs, std::move(surfaces));
  io::write_signals(io::signals_of(runs), output.file("signals.h5"));
  io::write_report(output.file("report.html"), report);
  output.commit();
}

/// Where and how often the state is kept.
struct KeepArguments {
  std::filesystem::path folder;  ///< empty: not at all
  double every = 60.0;           ///< s
  bool resume = false;
};

io::RunOptions options_of(const KeepArguments& keep) {
  io::RunOptions options;
  options.warn = warn;
  if (keep.folder.empty()) {
    if (keep.resume)
      throw InvalidInput(Fault{"--resume", "without --checkpoint", "needs the folder to go on from",
                               "give --checkpoint FOLDER too"});
    return options;
  }
  if (!(keep.every >= 0.0))
    throw InvalidInput(
        Fault{"--checkpoint-every", fmt::format("{:g} s", keep.every), "must be 0 or more", ""});
  options.checkpoint = io::CheckpointOptions{
      keep.folder,
      keep.every,
      keep.resume,
      [] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
            .count();
      },
      kProgram,
      warn};
  return options;
}

void run(const CaseArguments& arguments, const KeepArguments& keep) {
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<io::SimulateCase> cases =
      io::read_simulate_cases(io::read_case(arguments.case_file, arguments.overrides));
  // Whether it can be written is found out before the work.
  if (!arguments.directory.empty()) io::RunDirectory(arguments.directory);
  const std::vector<io::SimulatedRun> runs =
      io::run_simulations(cases, console_progress(), options_of(keep));
  const double wall_time =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  const nlohmann::ordered_json document = io::document_of(runs, wall_time);
  print_runs(arguments.format, runs, document);
  if (!arguments.directory.empty()) {
    write_directory(arguments.directory, arguments.case_file.stem().string(), runs, document,
                    wall_time);
  }
  if (interrupted()) throw Interrupted{};
  if (!keep.folder.empty()) {
    for (const io::SimulateCase& one : cases)
      std::filesystem::remove(keep.folder / (one.name + ".checkpoint"));
  }
}

}  // namespace

void print_runs(Format format, const std::vector<io::SimulatedRun>& runs,
                const nlohmann::ordered_json& document, const std::vector<std::string>& more) {
  for (const io::SimulatedRun& run : runs)
    for (const std::string& warning : run.warnings) warn(warning);
  switch (format) {
    case Format::json:
      print_json(document);
      break;
    case Format::csv:
      print_csv(io::table_of(runs, false));
      break;
    case Format::table:
      print_table(io::table_of(runs, true));
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
  auto keep = std::make_shared<KeepArguments>();
  command->add_option("--checkpoint", keep->folder,
                      "folder to keep the state of each run in until all are done");
  command->add_option("--checkpoint-every", keep->every, "seconds between two checkpoints")
      ->capture_default_str();
  command->add_flag("--resume", keep->resume, "go on from the checkpoints that are there");
  command->callback([arguments, keep] { run(*arguments, *keep); });
}

}  // namespace osteomill::cli
