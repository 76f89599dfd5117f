// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/plot.hpp"
#include "osteomill/io/robot_calibration_case.hpp"
#include "robot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using units::deg;
using units::mm;

/// The slot of the simulated guide: it holds A2's direction and points posteriorly at P1.
calibrate::GuideFrame simulated_guide(const calibrate::GuideModel& truth) {
  const calibrate::Pose X_GF = truth.X_FG0.inverse();
  const calibrate::Vector3 axis = truth.A2_F.direction;
  const calibrate::Vector3 along = (-calibrate::Vector3::UnitY() + axis * axis.y()).normalized();
  const calibrate::Vector3 tip = truth.A2_F.point + 30.0 * mm * along;
  return calibrate::guide_frame_from_cones({X_GF * (tip - 25.0 * mm * along),
                                            X_GF * (tip + 25.0 * mm * (along + axis)),
                                            X_GF * (tip + 25.0 * mm * (along - axis))});
}

Json axis_of(const calibrate::Axis& axis) {
  return {{"point_mm", xyz(axis.point, mm)}, {"direction", xyz(axis.direction, 1.0)}};
}

Json error_of(const calibrate::PlaneError& error) {
  return {{"flexion_deg", error.flexion / deg},
          {"tilt_deg", error.tilt / deg},
          {"offset_mm", error.offset / mm}};
}

struct Result {
  calibrate::GuideCalibration calibration;
  calibrate::SensorConstants constants;
  calibrate::ImplantTurn turn;
  std::vector<calibrate::CutTarget> targets;
  std::vector<calibrate::BudgetLine> budget;
};

Json document_of(const Result& result) {
  const calibrate::GuideCalibration& found = result.calibration;
  Json document;
  document["usable"] = found.usable;
  document["faults"] = Json::array();
  for (const auto& fault : found.faults) {
    document["faults"].push_back({{"stop", fault.stop}, {"text", fault.text}});
  }
  document["axis_1_f"] = axis_of(found.fit.model.A1_F);
  document["axis_2_f"] = axis_of(found.fit.model.A2_F);
  const auto sd = [&](int first, double unit) {
    return std::sqrt(found.fit.covariance.block<2, 2>(first, first).trace() / 2.0) / unit;
  };
  document["axis_1_sd"] = {{"position_mm", sd(0, mm)}, {"direction_deg", sd(2, deg)}};
  document["axis_2_sd"] = {{"position_mm", sd(4, mm)}, {"direction_deg", sd(6, deg)}};
  document["l1_mm"] = found.link1 / mm;
  document["axes_from_parallel_deg"] = found.skew / deg;
  document["residuals"] = {{"position_rms_mm", found.fit.position_rms / mm},
                           {"rotation_rms_deg", found.fit.rotation_rms / deg},
                           {"chi_squared", found.fit.chi_squared},
                           {"degrees_of_freedom", found.fit.freedom},
                           {"probability", found.fit.probability}};
  document["hall_constants_deg"] = {{"c1", result.constants.mean[0] / deg},
                                    {"c2", result.constants.mean[1] / deg},
                                    {"c1_spread", result.constants.spread[0] / deg},
                                    {"c2_spread", result.constants.spread[1] / deg}};
  document["implant_turn_deg"] = {{"angle", result.turn.angle / deg},
                                  {"varus_valgus", result.turn.varus_valgus / deg},
                                  {"internal_external", result.turn.internal_external / deg}};
  document["cuts"] = Json::array();
  for (const auto& target : result.targets) {
    Json one = {{"cut", robot::name(target.cut)}, {"reachable", target.reachable}};
    if (target.reachable) {
      one["hall_deg"] = {{"h1", target.halls[0] / deg}, {"h2", target.halls[1] / deg}};
      one["left"] = error_of(target.left);
      one["sd"] = error_of(target.sd);
    }
    document["cuts"].push_back(one);
  }
  document["error_budget"] = Json::array();
  for (const auto& line : result.budget) {
    document["error_budget"].push_back({{"source", line.source},
                                        {"flexion_rms_deg", line.flexion_rms / deg},
                                        {"flexion_mean_absolute_deg", line.mean_absolute / deg},
                                        {"offset_rms_mm", line.offset_rms / mm}});
  }
  return document;
}

std::vector<std::vector<std::string>> rows_of(const Result& result) {
  std::vector<std::vector<std::string>> rows = {
      {"cut", "H1, deg", "H2, deg", "flexion sd, deg", "tilt sd, deg", "offset sd, mm"}};
  for (const auto& target : result.targets) {
    if (!target.reachable) {
      rows.push_back({robot::name(target.cut), "out of reach"});
      continue;
    }
    rows.push_back({robot::name(target.cut), fixed(target.halls[0] / deg, 1),
                    fixed(target.halls[1] / deg, 1), fixed(target.sd.flexion / deg, 3),
                    fixed(target.sd.tilt / deg, 3), fixed(target.sd.offset / mm, 3)});
  }
  return rows;
}

std::vector<std::string> sentences_of(const Result& result) {
  const calibrate::GuideCalibration& found = result.calibration;
  std::vector<std::string> sentences = {
      fmt::format("axes: {:.3f} mm apart, {:.3f} deg from parallel; residuals {:.3f} mm and {:.3f} "
                  "deg over {} stops",
                  found.link1 / mm, found.skew / deg, found.fit.position_rms / mm,
                  found.fit.rotation_rms / deg, found.fit.stop_chi_squared.size()),
      fmt::format("implant turned by {:.2f} deg onto the axes: varus/valgus {:.2f}, "
                  "internal/external {:.2f}",
                  result.turn.angle / deg, result.turn.varus_valgus / deg,
                  result.turn.internal_external / deg)};
  for (const auto& fault : found.faults) sentences.push_back("fault: " + fault.text);
  for (const auto& line : result.budget) {
    sentences.push_back(fmt::format(
        "budget: {}: flexion {:.3f} deg rms ({:.3f} mean absolute), "
        "offset {:.3f} mm rms",
        line.source, line.flexion_rms / deg, line.mean_absolute / deg, line.offset_rms / mm));
  }
  return sentences;
}

Figure budget_figure(const std::vector<calibrate::BudgetLine>& budget) {
  return {"error_budget",
          "What each source does to the angle of the guide, root mean square over "
          "the five cuts",
          [budget](const std::filesystem::path& file) {
            io::BarChart chart;
            chart.title = "Flexion error of the guide";
            chart.y.label = "rms, deg";
            chart.y.low = 0.0;
            chart.width = 900;
            io::Bars bars;
            for (const auto& line : budget) {
              chart.categories.push_back(line.source);
              bars.values.push_back(line.flexion_rms / deg);
            }
            chart.series.push_back(bars);
            io::draw(chart, file);
          }};
}

Shown solve(const io::CaseRun& run, std::string& no_solution) {
  io::RobotCalibrateCase c;
  Shown shown;
  shown.expanded =
      io::Section::read(run, [&](io::Section& section) { io::bind_robot_calibrate(section, c); });
  const io::Implant implant = io::implant_of(c.implant);
  warn_of_assumed(implant.name, implant.obtained, shown);
  calibrate::GuideRecord record;
  if (c.record.empty()) {
    Random random(c.seed);
    record = calibrate::play_procedure(c.robot, random, c.faults);
    shown.warnings.push_back("the readings are simulated");
  } else {
    record = io::read_guide_record(c.record);
    if (c.cones_G.empty()) {
      throw InvalidInput(
          Fault{"guide", "", "is needed with a record", "palpate the cones of the planar probe"});
    }
  }
  const calibrate::GuideFrame guide = c.cones_G.empty()
                                          ? simulated_guide(c.robot.truth)
                                          : calibrate::guide_frame_from_cones(c.cones_G);
  Result result;
  result.calibration = calibrate::calibrate_guide(record, c.options);
  const calibrate::GuideModel& model = result.calibration.fit.model;
  result.turn = calibrate::turn_implant(c.X_FI, c.knee_centre_F, model.A1_F);
  const calibrate::Pose X_FI = result.turn.X_FF * c.X_FI;
  result.constants = calibrate::sensor_constants(model, guide, record, X_FI.linear().col(1));
  result.targets = calibrate::cut_targets(
      result.calibration.fit, guide,
      calibrate::planned_cuts(
          robot::cut_lines(implant.profile, {.distal_overhang = c.distal_overhang}), X_FI),
      c.robot.hall_sd);
  if (c.budget) result.budget = calibrate::error_budget(*c.budget, console_progress());
  shown.document = document_of(result);
  shown.rows = rows_of(result);
  shown.sentences = sentences_of(result);
  if (!result.budget.empty()) shown.figures.push_back(budget_figure(result.budget));
  if (!result.calibration.usable) {
    no_solution = result.calibration.faults.empty() ? "the calibration did not converge"
                                                    : result.calibration.faults.front().text;
  }
  return shown;
}

}  // namespace

void add_robot_calibrate(CLI::App& program) {
  add_robot_command(program, "calibrate", "axes, sensor constants and targets from tracked stops",
                    solve);
}

}  // namespace osteomill::cli
