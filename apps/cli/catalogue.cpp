// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/catalogue.hpp"

#include "command.hpp"
#include "osteomill/base/error.hpp"

namespace osteomill::cli {
namespace {

const std::vector<std::string> kKinds = {"bones", "cutters", "implants", "robots"};

struct Arguments {
  std::string kind;
  std::string name;
  Format format = Format::table;
};

std::string text_of(const nlohmann::ordered_json& tree, const char* table, const char* key) {
  if (!tree.contains(table) || !tree[table].is_object() || !tree[table].contains(key)) return "";
  const auto& value = tree[table][key];
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// "a.b.c", value: one row a leaf of the tree.
void flatten(const nlohmann::ordered_json& tree, const std::string& path,
             std::vector<std::vector<std::string>>& rows) {
  if (!tree.is_object()) {
    rows.push_back({path, tree.is_string() ? tree.get<std::string>() : tree.dump()});
    return;
  }
  for (const auto& [key, value] : tree.items()) {
    flatten(value, path.empty() ? key : path + "." + key, rows);
  }
}

void show(const Arguments& arguments) {
  if (!arguments.kind.empty() &&
      std::find(kKinds.begin(), kKinds.end(), arguments.kind) == kKinds.end()) {
    throw InvalidInput(Fault{"catalogue", arguments.kind, "is no kind of entry",
                             "known: bones, cutters, implants, robots"});
  }
  nlohmann::ordered_json document = nlohmann::ordered_json::object();
  std::vector<std::vector<std::string>> rows = {{"entry", "obtained", "source"}};
  if (!arguments.name.empty()) {
    document = io::catalogue_entry(arguments.kind, arguments.name).values;
    rows = {{"key", "value"}};
    flatten(document, "", rows);
  } else {
    for (const std::string& kind : kKinds) {
      if (!arguments.kind.empty() && arguments.kind != kind) continue;
      for (const std::string& name : io::catalogue_names(kind)) {
        const auto entry = io::catalogue_entry(kind, name).values;
        document[kind][name] = entry;
        rows.push_back({kind + " " + name, text_of(entry, "provenance", "obtained"),
                        text_of(entry, "provenance", "source")});
      }
    }
  }
  if (arguments.format == Format::json) return print_json(document);
  if (arguments.format == Format::csv) return print_csv(rows);
  print_table(rows);
}

}  // namespace

void add_catalogue(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      program.add_subcommand("catalogue", "bones, cutters, ... with their provenance");
  command->add_option("kind", arguments->kind, "bones, cutters, implants, robots");
  command->add_option("name", arguments->name, "show this entry whole");
  add_format(*command, arguments->format);
  command->callback([arguments] { show(*arguments); });
}

}  // namespace osteomill::cli
