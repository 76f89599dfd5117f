// SPDX-License-Identifier: BSD-3-Clause
#include "command.hpp"
#include "osteomill/base/error.hpp"

namespace osteomill::cli {
namespace {

struct Arguments {
  std::string command;
  Format format = Format::table;
};

void show(const Arguments& arguments) {
  nlohmann::ordered_json document = nlohmann::ordered_json::object();
  std::vector<std::vector<std::string>> rows = {
      {"key", "type", "unit", "allowed", "default", "meaning"}};
  std::string known;
  for (const Command& command : commands()) {
    if (!command.bind) continue;
    known += known.empty() ? command.name : std::string(", ") + command.name;
    if (!arguments.command.empty() && arguments.command != command.name) continue;
    auto& list = document[command.name] = nlohmann::ordered_json::array();
    if (arguments.command.empty()) rows.push_back({std::string("# ") + command.name});
    for (const io::SchemaKey& key : io::Section::schema(command.bind)) {
      const bool required = key.need == io::Need::required;
      list.push_back({{"key", key.path},
                      {"type", key.type},
                      {"unit", key.unit},
                      {"allowed", key.allowed},
                      {"required", required},
                      {"default", key.default_value},
                      {"meaning", key.meaning}});
      rows.push_back({key.path, key.type, key.unit, key.allowed,
                      required ? "(required)" : key.default_value, key.meaning});
    }
  }
  if (document.empty()) {
    throw InvalidInput(
        Fault{"schema", arguments.command, "is no command that reads a case", "known: " + known});
  }
  if (arguments.format == Format::json) return print_json(document);
  if (arguments.format == Format::csv) return print_csv(rows);
  for (auto& row : rows) {
    if (row.size() > 1) row.back() = " " + row.back();
  }
  print_table(rows);
}

}  // namespace

void add_schema(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("schema", "every key that a case may have");
  command->add_option("command", arguments->command, "only the keys of this command's cases");
  add_format(*command, arguments->format);
  command->callback([arguments] { show(*arguments); });
}

}  // namespace osteomill::cli
