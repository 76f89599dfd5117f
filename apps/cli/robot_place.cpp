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

struct Result {
  io::Implant implant;
  robot::Placement placement;
  robot::SafeZone zone;
  /// The best place that may be off by the case's error radius, and what it then costs.
  std::optional<robot::Placement> with_error;
  robot::PlacementTolerance tolerance;
};

Json document_of(const Result& result) {
  const robot::Placement& p = result.placement;
  Json document;
  document["feasible"] = p.feasible;
  document["implant"] = {{"name", result.implant.name}, {"obtained", result.implant.obtained}};
  document["limiting_cut"] = robot::name(p.limiting_cut);
  document["reason"] = p.reason;
  if (!p.feasible) return document;
  document["largest_gap_mm"] = p.largest_gap / mm;
  document["axis_position_mm"] = millimetres(p.axis_position);
  for (const robot::Cut cut : robot::kCuttingOrder) {
    document["gaps_mm"][robot::name(cut)] = p.gaps[robot::index(cut)] / mm;
  }
  document["gradient"] = {{"x", p.gradient.x()}, {"y", p.gradient.y()}};
  document["touching_cuts"] = Json::array();
  for (const robot::Cut cut : p.touching) document["touching_cuts"].push_back(robot::name(cut));
  document["required_stroke_mm"] = p.required_stroke / mm;
  document["residual_gap_mm"] = p.residual_gap / mm;
  document["certificate"] = {
      {"converged", p.converged}, {"lower_bound_mm", p.lower_bound / mm}, {"boxes", p.boxes}};
  document["safe_zone"] = {{"centre_mm", millimetres(result.zone.centre)},
                           {"radius_mm", result.zone.radius / mm},
                           {"largest_gap_mm", result.zone.largest_gap / mm}};
  if (result.with_error) {
    Json& safe = document["with_placement_error"];
    safe["feasible"] = result.with_error->feasible;
    safe["reason"] = result.with_error->reason;
    if (result.with_error->feasible) {
      safe["axis_position_mm"] = millimetres(result.with_error->axis_position);
      safe["largest_gap_mm"] = result.with_error->largest_gap / mm;
      safe["worst_gap_within_error_mm"] = result.tolerance.worst_gap / mm;
      safe["limiting_cut"] = robot::name(result.with_error->limiting_cut);
    }
  }
  return document;
}

std::vector<std::vector<std::string>> rows_of(const Result& result) {
  const robot::Placement& p = result.placement;
  std::vector<std::vector<std::string>> rows = {{"implant", result.implant.name}};
  if (!p.feasible) {
    rows.push_back({"feasible", "no"});
    return rows;
  }
  rows.push_back({"largest gap, mm", fixed(p.largest_gap / mm, 3)});
  rows.push_back({"first axis, x distal, mm", fixed(p.axis_position.x() / mm, 3)});
  rows.push_back({"first axis, y anterior, mm", fixed(p.axis_position.y() / mm, 3)});
  rows.push_back({"limiting cut", robot::name(p.limiting_cut)});
  rows.push_back({"change with x, mm/mm", fixed(p.gradient.x(), 3)});
  rows.push_back({"change with y, mm/mm", fixed(p.gradient.y(), 3)});
  for (const robot::Cut cut : robot::kCuttingOrder) {
    rows.push_back({fmt::format("gap of the {} cut, mm", robot::name(cut)),
                    fixed(p.gaps[robot::index(cut)] / mm, 3)});
  }
  rows.push_back({"largest free circle: radius, mm", fixed(result.zone.radius / mm, 2)});
  rows.push_back(
      {"  its centre x, y, mm",
       fmt::format("{:.2f}, {:.2f}", result.zone.centre.x() / mm, result.zone.centre.y() / mm)});
  rows.push_back({"  largest gap there, mm", fixed(result.zone.largest_gap / mm, 2)});
  if (result.with_error && result.with_error->feasible) {
    const robot::Placement& safe = *result.with_error;
    rows.push_back(
        {"with placement error: x, y, mm",
         fmt::format("{:.2f}, {:.2f}", safe.axis_position.x() / mm, safe.axis_position.y() / mm)});
    rows.push_back({"  largest gap there, mm", fixed(safe.largest_gap / mm, 2)});
    rows.push_back(
        {"  largest gap within the error, mm", fixed(result.tolerance.worst_gap / mm, 2)});
  }
  return rows;
}

void draw(const io::RobotPlaceCase& c, const Result& result, const robot::CutOptions& cuts,
          const std::filesystem::path& directory) {
  const auto lines = robot::cut_lines(result.implant.profile, cuts);
  const robot::GapMap map =
      robot::gap_map(c.robot, lines, {c.map_x_low, c.map_y_low}, {c.map_x_high, c.map_y_high},
                     c.map_step, c.options.placement.branch);
  const robot::BoneOutline bone =
      robot::generic_bone(result.implant.profile, cuts.distal_overhang / std::sqrt(2.0));
  const auto steps =
      robot::plan_sequence(c.robot, result.implant.profile, cuts, bone,
                           result.placement.axis_position, result.placement.branches);
  const std::string title = fmt::format("{}, L1 {:g} mm, L2 {:g} mm", result.implant.name,
                                        c.robot.link1 / mm, c.robot.link2 / mm);
  std::optional<io::Circle> mark;
  if (result.with_error && result.with_error->feasible) {
    mark = io::Circle{result.with_error->axis_position, *c.error_radius,
                      fmt::format("best place for an error of {:g} mm", *c.error_radius / mm)};
  }
  for (const char* suffix : {".svg", ".png"}) {
    io::draw_gap_map(map, result.placement, mark, "Largest gap: " + title,
                     directory / (std::string("gap_map") + suffix));
    io::draw_poses(result.implant.profile, cuts, bone, result.placement.axis_position, steps, title,
                   directory / (std::string("poses") + suffix));
  }
}

void bind(io::Section& section) {
  io::RobotPlaceCase c;
  io::bind_robot_place(section, c);
}

void run(const CaseArguments& arguments) {
  for (const io::CaseRun& one : io::read_case(arguments.case_file, arguments.overrides)) {
    io::RobotPlaceCase c;
    io::Section::read(one, [&](io::Section& section) { io::bind_robot_place(section, c); });
    Result result;
    result.implant = io::implant_of(c.implant);
    warn_of_assumed(result.implant.name, result.implant.obtained);
    const robot::CutOptions cuts{c.options.distal_overhang, c.robot.tool_thickness};
    const auto lines = robot::cut_lines(result.implant.profile, cuts);
    result.placement = robot::place(c.robot, lines, c.options.placement);
    result.zone = robot::safe_zone(c.robot, lines);
    if (result.placement.feasible && c.error_radius) {
      robot::PlacementOptions options = c.options.placement;
      options.margin = *c.error_radius;
      result.with_error = robot::place(c.robot, lines, options);
      if (result.with_error->feasible) {
        result.tolerance = robot::placement_tolerance(
            c.robot, lines, result.with_error->axis_position, *c.error_radius);
      } else {
        warn(result.with_error->reason);
      }
    }
    print_result(arguments, document_of(result), rows_of(result));
    if (!result.placement.feasible || !result.placement.converged) {
      throw NoSolution(result.placement.reason);
    }
    if (!arguments.directory.empty()) draw(c, result, cuts, arguments.directory);
  }
}

}  // namespace

void add_robot_place(CLI::App& program) {
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = add_robot_command(program, "place", "the best place of the first axis");
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { run(*arguments); });
}

void bind_robot_place(io::Section& section) { bind(section); }

}  // namespace osteomill::cli
