// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/case_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "osteomill/base/error.hpp"
#include "osteomill/io/catalogue.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

std::string join(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

/// Places of everything below `from`, moved to below `to`.
void copy_places(const ValueTree& source, const std::string& from, ValueTree& target,
                 const std::string& to) {
  for (auto at = source.places.lower_bound(from);
       at != source.places.end() && at->first.compare(0, from.size(), from) == 0; ++at) {
    const std::string rest = at->first.substr(from.size());
    if (rest.empty() || rest[0] == '.') target.places[to + rest] = at->second;
  }
}

/// Merges `over` (found at `over_path` of `source`) onto `base` (at `path` of `target`): tables key
/// by key, the rest whole.
void merge(Json& base, ValueTree& target, const std::string& path, const Json& over,
           const ValueTree& source, const std::string& over_path) {
  for (const auto& [key, value] : over.items()) {
    const std::string at = join(path, key);
    const std::string from = join(over_path, key);
    if (value.is_object() && base.contains(key) && base[key].is_object()) {
      merge(base[key], target, at, value, source, from);
    } else {
      base[key] = value;
      copy_places(source, from, target, at);
    }
  }
}

struct Override {
  std::string path;
  Json value;
};

Override parse_override(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw InvalidInput(
        Fault{"--set", text, "must read section.key=value", "e.g. --set cut.axial_depth_mm=5"});
  }
  const std::string path = text.substr(0, equals);
  if (path.front() == '.' || path.back() == '.' || path.find("..") != std::string::npos) {
    throw InvalidInput(Fault{"--set", text, "has an empty key", "write section.key=value"});
  }
  return {path, parse_toml_value(text.substr(equals + 1))};
}

/// The element that a key names in a table or, as a number, in an array.
Json& step(Json& node, const std::string& key, const std::string& path) {
  if (node.is_array()) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
    if (error == std::errc{} && end == key.data() + key.size() && index < node.size()) {
      return node[index];
    }
    throw InvalidInput(Fault{path, "", fmt::format("the array has {} elements", node.size()),
                             "name one by its number, from 0", "--set"});
  }
  if (node.is_null()) node = Json::object();
  if (!node.is_object()) {
    throw InvalidInput(Fault{path, node.dump(), "is a value, not a table", "", "--set"});
  }
  return node[key];
}

void apply(ValueTree& tree, const Override& change) {
  Json* node = &tree.values;
  std::size_t begin = 0;
  while (begin <= change.path.size()) {
    const std::size_t end = std::min(change.path.find('.', begin), change.path.size());
    node = &step(*node, change.path.substr(begin, end - begin), change.path);
    begin = end + 1;
  }
  *node = change.value;
  tree.places[change.path] = "--set";
}

/// The entry that `use` names: of the catalogue, or of a file of one's own, beside the case.
ValueTree entry_of(const std::string& kind, const std::string& name, const fs::path& directory) {
  if (!name.ends_with(".toml")) return catalogue_entry(kind, name);
  if (!fs::is_regular_file(directory / name)) {
    throw InvalidInput(
        Fault{"use", '"' + name + '"', "is no such file", "the path is relative to the case"});
  }
  return parse_toml(read_text_file(directory / name), name);
}

/// Puts the entry that a table `use`s below the table's own keys.
void resolve_use(Json& table, const std::string& path, const std::string& kind,
                 const fs::path& directory, ValueTree& tree, std::vector<Fault>& faults) {
  if (!table.is_object() || !table.contains("use")) return;
  const std::string place = tree.places[path + ".use"];
  if (!table["use"].is_string()) {
    faults.push_back({path + ".use", table["use"].dump(), "must be a name in quotes", "", place});
    return;
  }
  try {
    const ValueTree entry = entry_of(kind, table["use"].get<std::string>(), directory);
    Json whole = entry.values;
    ValueTree merged;
    for (const auto& [key, where] : entry.places) merged.places[join(path, key)] = where;
    merge(whole, merged, path, table, tree, path);
    whole.erase("use");
    table = std::move(whole);
    for (const auto& [key, where] : merged.places) tree.places[key] = where;
  } catch (const InvalidInput& error) {
    for (Fault fault : error.faults()) {
      if (fault.location.empty())
        fault = {path + ".use", fault.value, fault.rule, fault.remedy, place};
      faults.push_back(fault);
    }
  }
}

void resolve_catalogue(ValueTree& tree, const fs::path& directory, std::vector<Fault>& faults) {
  static const std::vector<std::pair<std::string, std::string>> kinds = {
      {"cutter", "cutters"}, {"bone", "bones"}, {"implant", "implants"}, {"robot", "robots"}};
  for (const auto& [table, kind] : kinds) {
    const auto found = tree.values.find(table);
    if (found == tree.values.end()) continue;
    resolve_use(*found, table, kind, directory, tree, faults);
    if (table != "bone" || !found->is_object()) continue;
    if (found->contains("low_speed")) {
      resolve_use((*found)["low_speed"], "bone.low_speed", kind, directory, tree, faults);
    }
    if (!found->contains("tested") || !(*found)["tested"].is_array()) continue;
    std::size_t number = 0;
    for (Json& one : (*found)["tested"]) {
      resolve_use(one, fmt::format("bone.tested.{}", number++), kind, directory, tree, faults);
    }
  }
}

/// A run.json holds the expanded case under "case"; a bare JSON tree is taken as the case itself.
ValueTree parse_json_case(const std::string& text, const std::string& name) {
  ValueTree tree;
  try {
    tree.values = Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw InvalidInput(Fault{name, "", error.what(), "name a case or the run.json of a run"});
  }
  if (tree.values.is_object() && tree.values.contains("case")) {
    Json inner = tree.values["case"];
    tree.values = std::move(inner);
  }
  if (!tree.values.is_object()) {
    throw InvalidInput(Fault{name, "", "holds no case", "name a case or the run.json of a run"});
  }
  return tree;
}

std::vector<std::string> run_names(const Json& runs, const ValueTree& tree,
                                   std::vector<Fault>& faults) {
  std::vector<std::string> names;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string path = fmt::format("run.{}", i);
    const auto place = tree.places.find(path);
    const std::string where = place == tree.places.end() ? "" : place->second;
    if (!runs[i].is_object() || !runs[i].contains("name") || !runs[i]["name"].is_string()) {
      faults.push_back({path + ".name", "", "is missing", "give each [[run]] a name", where});
      names.emplace_back();
      continue;
    }
    names.push_back(runs[i]["name"].get<std::string>());
    if (names.back().empty() || names.back().find('/') != std::string::npos) {
      faults.push_back({path + ".name", '"' + names.back() + '"',
                        "must not be empty nor have a slash: it names a folder", "", where});
    }
    if (!seen.insert(names.back()).second) {
      faults.push_back({path + ".name", names.back(), "stands twice", "give each its own", where});
    }
  }
  return names;
}

}  // namespace

std::vector<CaseRun> read_case(const fs::path& file, const std::vector<std::string>& overrides) {
  const std::string name = file.filename().string();
  const std::string text = read_text_file(file);
  ValueTree tree =
      file.extension() == ".json" ? parse_json_case(text, name) : parse_toml(text, name);
  std::vector<Override> changes;
  for (const std::string& override_text : overrides)
    changes.push_back(parse_override(override_text));
  for (const Override& change : changes) apply(tree, change);

  std::vector<Fault> faults;
  const fs::path directory = fs::absolute(file).parent_path();
  std::vector<CaseRun> runs;
  if (tree.values.contains("run")) {
    const Json list = tree.values["run"];
    if (!list.is_array() || list.empty()) {
      throw InvalidInput(Fault{"run", list.dump(), "must be a list of tables", "write [[run]]",
                               tree.places["run"]});
    }
    const std::vector<std::string> names = run_names(list, tree, faults);
    ValueTree base = tree;
    base.values.erase("run");
    for (std::size_t i = 0; i < list.size() && list[i].is_object(); ++i) {
      CaseRun run{names[i], base, directory};
      Json over = list[i];
      over.erase("name");
      merge(run.tree.values, run.tree, "", over, tree, fmt::format("run.{}", i));
      for (const Override& change : changes) {
        if (change.path.rfind("run.", 0) != 0) apply(run.tree, change);
      }
      runs.push_back(std::move(run));
    }
  } else {
    runs.push_back({"run", tree, directory});
  }
  for (CaseRun& run : runs) resolve_catalogue(run.tree, run.directory, faults);
  if (!faults.empty()) throw InvalidInput(faults);
  return runs;
}

}  // namespace osteomill::io
