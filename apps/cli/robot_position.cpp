// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/base/error.hpp"
#include "osteomill/io/robot_case.hpp"
#include "osteomill/io/robot_drawing.hpp"
#include "robot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using units::deg;
using units::mm;

/// What the Hall sensor reads at a joint angle: [plaskos2006] eq. 4.1 solved for C.
double hall(double joint, double gear, double zero) { return zero + gear * joint; }

Json angles(const robot::JointAngles& joints) {
  return {{"theta1_deg", joints.theta1 / deg}, {"theta2_deg", joints.theta2 / deg}};
}

Json document_of(const io::RobotPositionCase& c, const robot::Vector2& axis,
                 const std::vector<robot::SequenceStep>& steps) {
  Json document;
  document["axis_position_mm"] = millimetres(axis);
  document["cuts"] = Json::array();
  bool all = true;
  for (const robot::SequenceStep& step : steps) {
    Json one;
    one["cut"] = robot::name(step.cut);
    one["reachable"] = step.reachable;
    one["joints"] = angles(step.joints);
    one["hall_deg"] = {{"h1", hall(step.joints.theta1, c.gear1, c.zero1) / deg},
                       {"h2", hall(step.joints.theta2, c.gear2, c.zero2) / deg}};
    one["second_axis_mm"] = millimetres(step.pose.X1);
    one["guide_tip_mm"] = millimetres(step.pose.X2);
    one["gap_mm"] = step.gap / mm;
    one["slide_mm"] = std::min(std::max(0.0, step.gap), c.robot.slide_stroke) / mm;
    one["collides"] = step.collides;
    const robot::GuidePlay play = robot::guide_play(c.robot, step.joints, c.play1, c.play2);
    one["play"] = {{"angle_deg", play.angle / deg}, {"normal_mm", play.normal / mm}};
    one["singularity_distance"] =
        std::abs(robot::plane_determinant(c.robot, step.joints)) / c.robot.link1;
    one["path_found"] = step.path_found;
    one["path"] = Json::array();
    for (const robot::JointAngles& point : step.path) one["path"].push_back(angles(point));
    one["trouble"] = step.trouble;
    all = all && step.trouble.empty();
    document["cuts"].push_back(one);
  }
  document["feasible"] = all;
  return document;
}

std::vector<std::vector<std::string>> rows_of(const io::RobotPositionCase& c,
                                              const std::vector<robot::SequenceStep>& steps) {
  std::vector<std::vector<std::string>> rows = {{"cut", "theta1, deg", "theta2, deg", "H1, deg",
                                                 "H2, deg", "gap, mm", "play, deg", "play, mm",
                                                 "way points", "trouble"}};
  for (const robot::SequenceStep& step : steps) {
    const robot::GuidePlay play = robot::guide_play(c.robot, step.joints, c.play1, c.play2);
    rows.push_back({robot::name(step.cut), fixed(step.joints.theta1 / deg, 2),
                    fixed(step.joints.theta2 / deg, 2),
                    fixed(hall(step.joints.theta1, c.gear1, c.zero1) / deg, 0),
                    fixed(hall(step.joints.theta2, c.gear2, c.zero2) / deg, 0),
                    fixed(step.gap / mm, 2), fixed(play.angle / deg, 2), fixed(play.normal / mm, 2),
                    fmt::format("{}", step.path.size()),
                    step.trouble.empty() ? "-" : step.trouble});
  }
  return rows;
}

robot::PlanarChain chain_of(const io::RobotPositionCase& c) {
  robot::PlanarChain chain = robot::chain_of(c.robot, c.further);
  chain.axes[0].stiffness = c.stiffness1;
  chain.axes[1].stiffness = c.stiffness2;
  if (c.robot.slide_stroke > 0.0) chain.axes.back().stiffness = c.slide_stiffness;
  return chain;
}

/// "theta1_deg", ..., "slide3_mm" and the value in that unit.
std::vector<std::pair<std::string, double>> named_joints(const robot::PlanarChain& chain,
                                                         const Eigen::VectorXd& joints) {
  std::vector<std::pair<std::string, double>> named;
  for (std::size_t i = 0; i < chain.axes.size(); ++i) {
    const double q = joints(static_cast<Eigen::Index>(i));
    if (chain.axes[i].kind == robot::AxisKind::revolute) {
      named.emplace_back(fmt::format("theta{}_deg", i + 1), q / deg);
    } else {
      named.emplace_back(fmt::format("slide{}_mm", i + 1), q / mm);
    }
  }
  return named;
}

Json joints_json(const robot::PlanarChain& chain, const Eigen::VectorXd& joints) {
  Json json;
  for (const auto& [name, value] : named_joints(chain, joints)) json[name] = value;
  return json;
}

void show_chain(const robot::PlanarChain& chain, const robot::Vector2& axis,
                const std::vector<robot::ChainStep>& steps, Shown& shown) {
  shown.document["axis_position_mm"] = millimetres(axis);
  shown.document["cuts"] = Json::array();
  std::vector<std::string> heading = {"cut", "branch"};
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(chain.axes.size()));
  for (const auto& [name, value] : named_joints(chain, none)) {
    const std::size_t unit = name.rfind('_');
    heading.push_back(name.substr(0, unit) + ", " + name.substr(unit + 1));
  }
  heading.insert(heading.end(), {"gap, mm", "um/N", "way points", "trouble"});
  shown.rows = {heading};
  bool all = true;
  for (const robot::ChainStep& step : steps) {
    const robot::ChainSolution& s = step.solution;
    const char* branch = s.branch == robot::Branch::outermost ? "outermost" : "innermost";
    Json one = {{"cut", robot::name(step.cut)}, {"reachable", s.found}};
    std::vector<std::string> row = {robot::name(step.cut)};
    if (s.found) {
      one["branch"] = branch;
      one["joints"] = joints_json(chain, s.joints);
      one["guide_tip_mm"] = millimetres(step.pose.tip());
      one["gap_mm"] = step.gap / mm;
      one["criterion"] = s.criterion;
      one["normal_compliance_um_per_n"] = s.normal_compliance * 1e6;
      row.emplace_back(branch);
      for (const auto& [name, value] : named_joints(chain, s.joints)) {
        row.push_back(fixed(value, 2));
      }
      // What is less than the solver's own 0.1 um is no gap.
      row.push_back(fixed(std::abs(step.gap) < 5e-7 ? 0.0 : step.gap / mm, 2));
      row.push_back(fixed(s.normal_compliance * 1e6, 2));
      row.push_back(fmt::format("{}", step.path.size()));
    }
    row.resize(heading.size() - 1);
    row.push_back(step.trouble.empty() ? "-" : step.trouble);
    one["collides"] = step.collides;
    one["path_found"] = step.path_found;
    one["path"] = Json::array();
    for (const Eigen::VectorXd& point : step.path) one["path"].push_back(joints_json(chain, point));
    one["trouble"] = step.trouble;
    all = all && step.trouble.empty();
    shown.document["cuts"].push_back(std::move(one));
    shown.rows.push_back(std::move(row));
  }
  shown.document["feasible"] = all;
}

Shown solve(const io::CaseRun& run, std::string& no_solution) {
  io::RobotPositionCase c;
  Shown shown;
  shown.expanded =
      io::Section::read(run, [&](io::Section& section) { io::bind_robot_position(section, c); });
  const io::Implant implant = io::implant_of(c.implant);
  warn_of_assumed(implant.name, implant.obtained, shown);
  const robot::CutOptions cuts{c.options.distal_overhang, c.robot.tool_thickness};
  const auto lines = robot::cut_lines(implant.profile, cuts);
  robot::Vector2 axis;
  robot::PerCut<robot::Branch> branches;
  if (c.axis_x && c.axis_y) {
    axis = {*c.axis_x, *c.axis_y};
    branches = robot::gaps_at(c.robot, lines, axis, c.options.placement.branch).branches;
  } else {
    const robot::Placement placement = robot::place(c.robot, lines, c.options.placement);
    if (!placement.feasible) throw NoSolution(placement.reason);
    axis = placement.axis_position;
    branches = placement.branches;
  }
  const double cover = c.bone_cover > 0.0 ? c.bone_cover : cuts.distal_overhang / std::sqrt(2.0);
  const robot::BoneOutline bone = robot::generic_bone(implant.profile, cover);
  const std::string title =
      fmt::format("{}, L1 {:g} mm, L2 {:g} mm, tool {:g} mm", implant.name, c.robot.link1 / mm,
                  c.robot.link2 / mm, c.robot.tool_thickness / mm);
  const char* caption = "The robot at each cut, in the order of cutting";
  if (c.chain) {
    const robot::PlanarChain chain = chain_of(c);
    const auto chain_steps = robot::plan_chain_sequence(chain, implant.profile, cuts, bone, axis,
                                                        c.redundancy, c.sequence);
    show_chain(chain, axis, chain_steps, shown);
    std::vector<io::PoseDrawing> drawings;
    for (const robot::ChainStep& step : chain_steps) {
      drawings.push_back({step.cut, step.pose.points, step.gap, !step.trouble.empty()});
      if (no_solution.empty() && !step.trouble.empty()) {
        no_solution = fmt::format("{} cut: {}", robot::name(step.cut), step.trouble);
      }
    }
    shown.figures = {{"poses", caption, [=](const std::filesystem::path& file) {
                        io::draw_poses(implant.profile, cuts, bone, drawings,
                                       fmt::format("{}, {} axes", title, chain.axes.size()), file);
                      }}};
    return shown;
  }
  const auto steps =
      robot::plan_sequence(c.robot, implant.profile, cuts, bone, axis, branches, c.sequence);
  shown.document = document_of(c, axis, steps);
  shown.rows = rows_of(c, steps);
  shown.figures = {{"poses", caption, [=](const std::filesystem::path& file) {
                      io::draw_poses(implant.profile, cuts, bone, axis, steps, title, file);
                    }}};
  for (const robot::SequenceStep& step : steps) {
    if (no_solution.empty() && !step.trouble.empty()) {
      no_solution = fmt::format("{} cut: {}", robot::name(step.cut), step.trouble);
    }
  }
  return shown;
}

}  // namespace

void add_robot_position(CLI::App& program) {
  add_robot_command(program, "position", "joint targets of each cut and the way between them",
                    solve);
}

}  // namespace osteomill::cli
