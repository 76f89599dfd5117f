// SPDX-License-Identifier: BSD-3-Clause
#include "robot.hpp"

#include "osteomill/io/text_file.hpp"

namespace osteomill::cli {

CLI::App* add_robot_command(CLI::App& program, const char* name, const char* about) {
  // The first of the commands makes the group.
  const auto groups = program.get_subcommands(
      [](const CLI::App* command) { return command->get_name() == "robot"; });
  CLI::App* group = groups.empty()
                        ? program.add_subcommand("robot", "place, size and position the knee robot")
                        : groups.front();
  group->require_subcommand(1);
  return group->add_subcommand(name, about);
}

void print_result(const CaseArguments& arguments, const nlohmann::ordered_json& document,
                  const std::vector<std::vector<std::string>>& rows) {
  if (!arguments.directory.empty()) {
    std::filesystem::create_directories(arguments.directory);
    io::write_text_file(arguments.directory / "result.json", document.dump(2) + "\n");
  }
  if (arguments.format == Format::json) return print_json(document);
  if (arguments.format == Format::csv) return print_csv(rows);
  print_table(rows);
}

void warn_of_assumed(const std::string& name, const std::string& obtained) {
  if (obtained == "assumed") {
    warn(fmt::format("implant {}: its dimensions are assumed, it stands for no product", name));
  }
}

}  // namespace osteomill::cli
