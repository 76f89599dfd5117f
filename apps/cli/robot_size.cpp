// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/base/error.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/robot_case.hpp"
#include "osteomill/io/robot_drawing.hpp"
#include "robot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using units::mm;

Json choice(const robot::LinkChoice& best, const char* value) {
  if (!best.exists) return nullptr;
  return {{"l1_mm", best.l1 / mm},
          {"l2_mm", best.l2 / mm},
          {value, best.value / mm},
          {"change_with_l1", best.slope_l1},
          {"change_with_l2", best.slope_l2}};
}

Json surface(const std::vector<std::optional<double>>& values) {
  Json list = Json::array();
  for (const auto& value : values) list.push_back(value ? Json(*value / mm) : Json(nullptr));
  return list;
}

Json document_of(const io::RobotSizeCase& c, const robot::SizeStudy& study) {
  Json document;
  document["best_largest"] = choice(study.best_largest, "largest_gap_mm");
  document["best_mean"] = choice(study.best_mean, "mean_of_largest_gaps_mm");
  document["most_compact"] = choice(study.most_compact, "required_stroke_mm");
  document["families"] = Json::array();
  for (std::size_t f = 0; f < c.families.size(); ++f) {
    Json one = choice(study.best_per_family[f], "largest_gap_mm");
    document["families"].push_back(
        {{"name", c.families[f]}, {"best", one}, {"largest_gap_mm", surface(study.per_family[f])}});
  }
  document["l1_mm"] = Json::array();
  document["l2_mm"] = Json::array();
  for (const double l1 : study.l1) document["l1_mm"].push_back(l1 / mm);
  for (const double l2 : study.l2) document["l2_mm"].push_back(l2 / mm);
  document["largest_gap_mm"] = surface(study.largest);
  document["mean_gap_mm"] = surface(study.mean);
  document["placements"] = study.placements;
  return document;
}

std::vector<std::string> row(const std::string& name, const robot::LinkChoice& best) {
  if (!best.exists) return {name, "none"};
  return {name,
          fixed(best.l1 / mm, 1),
          fixed(best.l2 / mm, 1),
          fixed(best.value / mm, 2),
          fixed(best.slope_l1, 2),
          fixed(best.slope_l2, 2)};
}

std::vector<std::vector<std::string>> rows_of(const io::RobotSizeCase& c,
                                              const robot::SizeStudy& study) {
  std::vector<std::vector<std::string>> rows = {
      {"best for", "L1, mm", "L2, mm", "gap, mm", "per mm L1", "per mm L2"}};
  for (std::size_t f = 0; f < c.families.size(); ++f) {
    rows.push_back(row(c.families[f], study.best_per_family[f]));
  }
  rows.push_back(row("largest of all", study.best_largest));
  rows.push_back(row("mean of all", study.best_mean));
  if (c.study.slide_stroke > 0.0) rows.push_back(row("shortest L1 with slide", study.most_compact));
  return rows;
}

void run(const CaseArguments& arguments) {
  for (const io::CaseRun& one : io::read_case(arguments.case_file, arguments.overrides)) {
    io::RobotSizeCase c;
    io::Section::read(one, [&](io::Section& section) { io::bind_robot_size(section, c); });
    std::vector<robot::ImplantFamily> families;
    for (const std::string& name : c.families) {
      const io::Implant sample = io::implant_of({.family = name});
      warn_of_assumed(name, sample.obtained);
      families.push_back(io::implant_family(name));
    }
    const robot::SizeStudy study = robot::study_sizes(families, c.study, console_progress());
    if (study.stopped) throw Interrupted{};
    print_result(arguments, document_of(c, study), rows_of(c, study));
    if (!study.best_largest.exists) {
      throw NoSolution(
          "no pair of link lengths serves every size of every family; widen "
          "size.l1_mm and size.l2_mm");
    }
    if (arguments.directory.empty()) continue;
    for (const char* suffix : {".svg", ".png"}) {
      io::draw_size_study(study, study.largest, study.best_largest,
                          "Largest gap over all families and sizes",
                          arguments.directory / (std::string("largest_gap") + suffix));
      io::draw_size_study(study, study.mean, study.best_mean,
                          "Mean over the families of their largest gap",
                          arguments.directory / (std::string("mean_gap") + suffix));
    }
  }
}

}  // namespace

void add_robot_size(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = add_robot_command(program, "size", "link lengths over implants and sizes");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { run(*arguments); });
}

void bind_robot_size(io::Section& section) {
  io::RobotSizeCase c;
  io::bind_robot_size(section, c);
}

}  // namespace osteomill::cli
