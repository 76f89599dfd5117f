// SPDX-License-Identifier: BSD-3-Clause
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
  robot::PlacementRisk risk;  ///< at the best place
  robot::PlacementRisk risk_with_error;
};

Json risk_of(const robot::PlacementRisk& risk) {
  Json json = {{"share_forbidden", risk.share_forbidden}, {"allowed_samples", risk.allowed}};
  if (risk.allowed > 0) {
    json["mean_largest_gap_mm"] = risk.mean_gap / mm;
    json["largest_gap_95_percent_mm"] = risk.gap_95 / mm;
  }
  for (const robot::Cut cut : robot::kCuttingOrder) {
    json["forbidden_by"][robot::name(cut)] = risk.forbidden_by[robot::index(cut)];
  }
  return json;
}

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
  document["monte_carlo"] = risk_of(result.risk);
  if (result.with_error) {
    Json& safe = document["with_placement_error"];
    safe["feasible"] = result.with_error->feasible;
    safe["reason"] = result.with_error->reason;
    if (result.with_error->feasible) {
      safe["axis_position_mm"] = millimetres(result.with_error->axis_position);
      safe["largest_gap_mm"] = result.with_error->largest_gap / mm;
      safe["worst_gap_within_error_mm"] = result.tolerance.worst_gap / mm;
      safe["limiting_cut"] = robot::name(result.with_error->limiting_cut);
      safe["monte_carlo"] = risk_of(result.risk_with_error);
    }
  }
  return document;
}

std::vector<std::vector<std::string>> rows_of(const Result& result) {
  const robot::Placement& p = result.placement;
  std::vector<std::vector<std::string>> rows = {{"implant", result.implant.name}};
  const auto percent = [](double share) { return fixed(100.0 * share, 1); };
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
  rows.push_back({"out of bounds in the Monte Carlo, %", percent(result.risk.share_forbidden)});
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

std::vector<Figure> figures_of(const io::RobotPlaceCase& c, const Result& result,
                               const robot::CutOptions& cuts) {
  const std::string title = fmt::format("{}, L1 {:g} mm, L2 {:g} mm", result.implant.name,
                                        c.robot.link1 / mm, c.robot.link2 / mm);
  const auto lines = robot::cut_lines(result.implant.profile, cuts);
  std::optional<io::Circle> mark;
  if (result.with_error && result.with_error->feasible) {
    mark = io::Circle{result.with_error->axis_position, *c.error_radius,
                      fmt::format("best place for an error of {:g} mm", *c.error_radius / mm)};
  }
  const auto draw_map = [=](const std::filesystem::path& file) {
    const robot::GapMap map =
        robot::gap_map(c.robot, lines, {c.map_x_low, c.map_y_low}, {c.map_x_high, c.map_y_high},
                       c.map_step, c.options.placement.branch);
    io::draw_gap_map(map, result.placement, mark, "Largest gap: " + title, file);
  };
  const auto draw_poses = [=](const std::filesystem::path& file) {
    const robot::BoneOutline bone =
        robot::generic_bone(result.implant.profile, cuts.distal_overhang / std::sqrt(2.0));
    const auto steps =
        robot::plan_sequence(c.robot, result.implant.profile, cuts, bone,
                             result.placement.axis_position, result.placement.branches);
    io::draw_poses(result.implant.profile, cuts, bone, result.placement.axis_position, steps, title,
                   file);
  };
  return {{"gap_map",
           "Largest gap over the place of the first axis; blank where a cut is out of "
           "reach or the guide would stand in bone",
           draw_map},
          {"poses", "The robot at each cut, in the order of cutting", draw_poses},
          {"sensitivity", "Gap of each cut when the first axis is off its best place",
           [=](const std::filesystem::path& file) {
             io::draw_sensitivity(c.robot, lines, result.placement, "Sensitivity: " + title, file);
           }}};
}

Shown solve(const io::CaseRun& run, std::string& no_solution) {
  io::RobotPlaceCase c;
  Shown shown;
  shown.expanded =
      io::Section::read(run, [&](io::Section& section) { io::bind_robot_place(section, c); });
  Result result;
  result.implant = io::implant_of(c.implant);
  warn_of_assumed(result.implant.name, result.implant.obtained, shown);
  const robot::CutOptions cuts{c.options.distal_overhang, c.robot.tool_thickness};
  const auto lines = robot::cut_lines(result.implant.profile, cuts);
  result.placement = robot::place(c.robot, lines, c.options.placement);
  result.zone = robot::safe_zone(c.robot, lines);
  if (result.placement.feasible) {
    result.risk = robot::placement_risk(c.robot, lines, result.placement.axis_position, c.errors,
                                        c.options.placement.branch);
  }
  if (result.placement.feasible && c.error_radius) {
    robot::PlacementOptions options = c.options.placement;
    options.margin = *c.error_radius;
    result.with_error = robot::place(c.robot, lines, options);
    if (result.with_error->feasible) {
      result.tolerance = robot::placement_tolerance(
          c.robot, lines, result.with_error->axis_position, *c.error_radius);
      result.risk_with_error = robot::placement_risk(
          c.robot, lines, result.with_error->axis_position, c.errors, c.options.placement.branch);
    } else {
      shown.warnings.push_back(result.with_error->reason);
    }
  }
  shown.document = document_of(result);
  shown.rows = rows_of(result);
  if (!result.placement.feasible || !result.placement.converged) {
    no_solution = result.placement.reason;
  } else {
    shown.figures = figures_of(c, result, cuts);
  }
  return shown;
}

}  // namespace

void add_robot_place(CLI::App& program) {
  add_robot_command(program, "place", "the best place of the first axis", solve);
}

}  // namespace osteomill::cli
