// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/toml_text.hpp"

#include <nlohmann/json.hpp>

namespace osteomill::io {
namespace {

using Json = nlohmann::ordered_json;

/// A key as it stands: plain where TOML allows it, quoted otherwise.
std::string key_text(const std::string& key) {
  const bool plain =
      key.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
      std::string::npos;
  return plain && !key.empty() ? key : Json(key).dump();
}

std::string value_text(const Json& value) {
  if (value.is_object()) {
    std::string text;
    for (const auto& [key, below] : value.items()) {
      if (below.is_null()) continue;
      text += (text.empty() ? "" : ", ") + key_text(key) + " = " + value_text(below);
    }
    return "{ " + text + " }";
  }
  if (value.is_array()) {
    std::string text;
    for (const Json& one : value) text += (text.empty() ? "" : ", ") + value_text(one);
    return "[" + text + "]";
  }
  return value.dump();  // strings, numbers and flags are written alike in both languages
}

void add_table(std::string& text, const Json& table, const std::string& path) {
  for (const auto& [key, value] : table.items()) {
    if (!value.is_object() && !value.is_null()) {
      text += key_text(key) + " = " + value_text(value) + "\n";
    }
  }
  for (const auto& [key, value] : table.items()) {
    if (!value.is_object()) continue;
    const std::string below = (path.empty() ? "" : path + ".") + key_text(key);
    text += (text.empty() ? "[" : "\n[") + below + "]\n";
    add_table(text, value, below);
  }
}

}  // namespace

std::string toml_text(const Json& table) {
  std::string text;
  add_table(text, table, "");
  return text;
}

}  // namespace osteomill::io
