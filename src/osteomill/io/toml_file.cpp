// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/toml_file.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include "osteomill/base/error.hpp"

namespace osteomill::io {
namespace {

using Json = nlohmann::ordered_json;

class Converter {
 public:
  Converter(const std::string& name, ValueTree& tree) : name_(name), tree_(tree) {}

  Json table(const toml::table& table, const std::string& path) {
    Json object = Json::object();
    for (const auto& [key, node] : table) {
      object[std::string(key.str())] =
          value(node, path.empty() ? std::string(key.str()) : path + "." + std::string(key.str()));
    }
    return object;
  }

 private:
  Json value(const toml::node& node, const std::string& path) {
    const std::string place = fmt::format("{}:{}", name_, node.source().begin.line);
    tree_.places[path] = place;
    if (const auto* sub = node.as_table()) return table(*sub, path);
    if (const auto* array = node.as_array()) {
      Json list = Json::array();
      for (std::size_t i = 0; i < array->size(); ++i) {
        list.push_back(value((*array)[i], fmt::format("{}.{}", path, i)));
      }
      return list;
    }
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* integer = node.as_integer()) return integer->get();
    if (const auto* number = node.as_floating_point()) return number->get();
    if (const auto* flag = node.as_boolean()) return flag->get();
    throw InvalidInput(Fault{path, "a date or time", "is no kind of value that a case has",
                             "write a number, a text in quotes, true or false", place});
  }

  const std::string& name_;
  ValueTree& tree_;
};

}  // namespace

ValueTree parse_toml(std::string_view text, const std::string& name) {
  toml::table parsed;
  try {
    parsed = toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    throw InvalidInput(Fault{"TOML", "", std::string(error.description()), "",
                             fmt::format("{}:{}", name, error.source().begin.line)});
  }
  ValueTree tree;
  tree.values = Converter(name, tree).table(parsed, "");
  return tree;
}

Json parse_toml_value(const std::string& text) {
  try {
    return parse_toml("value = " + text, "--set").values["value"];
  } catch (const InvalidInput&) {
    return text;
  }
}

}  // namespace osteomill::io
