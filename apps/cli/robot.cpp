// SPDX-License-Identifier: BSD-3-Clause
#include "robot.hpp"

#include "osteomill/base/error.hpp"

namespace osteomill::cli {

void add_robot_command(
    CLI::App& program, const char* name, const char* about,
    const std::function<Shown(const io::CaseRun&, std::string& no_solution)>& solve) {
  // The first of the commands makes the group.
  const auto groups = program.get_subcommands(
      [](const CLI::App* command) { return command->get_name() == "robot"; });
  CLI::App* group = groups.empty()
                        ? program.add_subcommand("robot", "place, calibrate and reach with a robot")
                        : groups.front();
  group->require_subcommand(1);
  auto arguments = std::make_shared<CaseArguments>();
  CLI::App* command = group->add_subcommand(name, about);
  add_case_arguments(*command, *arguments);
  command->callback([arguments, solve, title = std::string("robot ") + name] {
    std::string no_solution;
    show_runs(*arguments, title, [&](const io::CaseRun& run) { return solve(run, no_solution); });
    if (!no_solution.empty()) throw NoSolution(no_solution);
  });
}

void warn_of_assumed(const std::string& name, const std::string& obtained, Shown& shown) {
  if (obtained == "assumed") {
    shown.warnings.push_back(
        fmt::format("implant {}: its dimensions are assumed, it stands for no product", name));
  }
}

}  // namespace osteomill::cli
