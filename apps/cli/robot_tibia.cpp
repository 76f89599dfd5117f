// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/robot_chain_case.hpp"
#include "robot.hpp"

namespace osteomill::cli {
namespace {

using Json = nlohmann::ordered_json;
using units::deg;
using units::mm;

Json shown_of(const robot::TibialDisplay& d) {
  return {{"varus_deg", d.varus / deg}, {"slope_deg", d.slope / deg}, {"depth_mm", d.depth / mm}};
}

Json joints_of(const robot::TibialJoints& j) {
  return {
      {"slide_mm", j.slide / mm}, {"flexion_deg", j.flexion / deg}, {"varus_deg", j.varus / deg}};
}

Shown solve(const io::CaseRun& run, std::string& no_solution) {
  io::RobotTibiaCase c;
  Shown shown;
  shown.expanded =
      io::Section::read(run, [&](io::Section& section) { io::bind_robot_tibia(section, c); });
  const robot::TibialSetting setting = robot::solve(c.guide, c.X_AB, c.target);
  const auto by_screen = robot::adjust_by_screen(c.guide, c.X_AB, c.now, c.target, c.tolerance);
  shown.document = {{"reachable", setting.reachable},
                    {"reason", setting.reason},
                    {"set", joints_of(setting.joints)},
                    {"then_shows", shown_of(robot::display(c.guide, c.X_AB, setting.joints))},
                    {"now_shows", shown_of(robot::display(c.guide, c.X_AB, c.now))}};
  shown.rows = {{"step", "slide, mm", "F/E, deg", "V/V, deg", "shows V/V, deg", "shows slope, deg",
                 "shows depth, mm"}};
  const auto row = [&](const std::string& name, const robot::TibialJoints& joints) {
    const robot::TibialDisplay d = robot::display(c.guide, c.X_AB, joints);
    shown.rows.push_back({name, fixed(joints.slide / mm, 2), fixed(joints.flexion / deg, 2),
                          fixed(joints.varus / deg, 2), fixed(d.varus / deg, 2),
                          fixed(d.slope / deg, 2), fixed(d.depth / mm, 2)});
  };
  row("as it stands", c.now);
  // In this order nothing that was locked is touched again.
  robot::TibialJoints joints = c.now;
  joints.varus = setting.joints.varus;
  row("1. turn V/V to its value, lock", joints);
  joints.flexion = setting.joints.flexion;
  row("2. turn F/E to its value, lock", joints);
  joints.slide = setting.joints.slide;
  row("3. slide P/D, lock", joints);
  shown.document["turns_by_screen"] = by_screen.size() - 1;
  shown.sentences.push_back(
      fmt::format("by the anatomic angles on the screen it takes {} turns to come within {:g} deg: "
                  "each axis moves the other's angle too",
                  by_screen.size() - 1, c.tolerance / deg));
  if (!setting.reachable) no_solution = setting.reason;
  return shown;
}

}  // namespace

void add_robot_tibia(CLI::App& program) {
  add_robot_command(program, "tibia", "joint values of the tibial guide, set without coupling",
                    solve);
}

}  // namespace osteomill::cli
