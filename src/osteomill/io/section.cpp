// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/section.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "osteomill/io/case_file.hpp"

namespace osteomill::io {

using Json = nlohmann::ordered_json;

namespace {

std::string describe_range(const Range& range) {
  const bool low = std::isfinite(range.low);
  const bool high = std::isfinite(range.high);
  if (low && high && !range.low_open) return fmt::format("{:g} ... {:g}", range.low, range.high);
  std::string text;
  if (low) text = fmt::format("{} {:g}", range.low_open ? ">" : ">=", range.low);
  if (high) text += fmt::format("{}<= {:g}", low ? ", " : "", range.high);
  return text.empty() ? "any number" : text;
}

/// Edits that turn one word into the other (Levenshtein), for "did you mean".
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t corner = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = corner + (a[i - 1] == b[j - 1] ? 0 : 1);
      corner = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string>& words) {
  std::string best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : words) {
    // "diameter" for "diameter_mm": a key without its unit is the likeliest slip.
    const std::size_t distance =
        candidate.rfind(std::string(word) + "_", 0) == 0 ? 1 : edits(word, candidate);
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace

struct Section::Walk {
  const ValueTree* tree = nullptr;
  std::filesystem::path directory;
  std::vector<Fault> faults;
  std::vector<SchemaKey> keys;

  std::string place(const std::string& path) const {
    // A missing key stands where its table does.
    for (std::string at = path; tree != nullptr && !at.empty();) {
      const auto found = tree->places.find(at);
      if (found != tree->places.end()) return found->second;
      const std::size_t dot = at.rfind('.');
      at = dot == std::string::npos ? "" : at.substr(0, dot);
    }
    return "";
  }
};

Section::Section(Walk& walk, std::string path, const Json* source, Json* expanded)
    : walk_(walk), path_(std::move(path)), source_(source), expanded_(expanded) {}

std::string Section::full(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

bool Section::when(bool condition) const { return source_ == nullptr || condition; }

bool Section::has(std::string_view key) const {
  return source_ != nullptr && source_->contains(key);
}

const Json* Section::find(std::string_view key, std::string_view meaning, Need need,
                          const char* type, Quantity quantity, std::string allowed,
                          std::string default_value) {
  known_.emplace_back(key);
  if (source_ == nullptr) {
    walk_.keys.push_back({full(key), type, quantity.unit, std::move(allowed),
                          need == Need::required ? "" : std::move(default_value), need,
                          std::string(meaning)});
    return nullptr;
  }
  const auto found = source_->find(key);
  if (found != source_->end()) return &*found;
  if (need == Need::required) {
    walk_.faults.push_back(
        {full(key), "", "is missing", fmt::format("set it ({})", meaning), walk_.place(full(key))});
  }
  return nullptr;
}

void Section::expand(std::string_view key, const Json& value) {
  if (expanded_ != nullptr) (*expanded_)[std::string(key)] = value;
}

void Section::fault(std::string_view key, std::string rule, std::string remedy) {
  if (source_ == nullptr) return;
  const auto found = source_->find(key);
  walk_.faults.push_back({full(key), found == source_->end() ? "" : found->dump(), std::move(rule),
                          std::move(remedy), walk_.place(full(key))});
}

bool Section::check(std::string_view key, const Json& value, Quantity quantity,
                    const Range& range) {
  const std::string unit = *quantity.unit == '\0' ? "" : fmt::format(" {}", quantity.unit);
  if (!value.is_number()) {
    fault(key, fmt::format("must be a number{}", unit.empty() ? "" : " of" + unit));
    return false;
  }
  const double number = value.get<double>();
  if (!std::isfinite(number) || !range.holds(number)) {
    fault(key, fmt::format("must be {}{}", describe_range(range), unit));
    return false;
  }
  return true;
}

void Section::number(std::string_view key, double& value, Quantity quantity, Range range,
                     std::string_view meaning, Need need) {
  const double in_file = value / quantity.factor;
  const Json* found = find(key, meaning, need, "number", quantity, describe_range(range),
                           fmt::format("{:.10g}", in_file));
  if (found == nullptr) {
    if (source_ == nullptr || need == Need::required) return;
    value = in_file * quantity.factor;  // as it will be read again from the expanded case
    expand(key, in_file);
  } else if (check(key, *found, quantity, range)) {
    value = found->get<double>() * quantity.factor;
    expand(key, *found);
  }
}

void Section::number(std::string_view key, std::optional<double>& value, Quantity quantity,
                     Range range, std::string_view meaning) {
  const Json* found =
      find(key, meaning, Need::optional, "number", quantity, describe_range(range), "");
  if (found != nullptr && check(key, *found, quantity, range)) {
    value = found->get<double>() * quantity.factor;
    expand(key, *found);
  }
}

void Section::integer(std::string_view key, int& value, Range range, std::string_view meaning,
                      Need need) {
  const Json* found =
      find(key, meaning, need, "integer", {}, describe_range(range), std::to_string(value));
  if (found == nullptr) {
    if (source_ != nullptr && need == Need::optional) expand(key, value);
  } else if (!found->is_number_integer()) {
    fault(key, "must be a whole number");
  } else if (check(key, *found, {}, range)) {
    value = found->get<int>();
    expand(key, *found);
  }
}

void Section::text(std::string_view key, std::string& value, std::string_view meaning, Need need) {
  const Json* found = find(key, meaning, need, "text", {}, "any text", value);
  if (found == nullptr) {
    if (source_ != nullptr && need == Need::optional) expand(key, value);
  } else if (!found->is_string()) {
    fault(key, "must be a text in quotes");
  } else {
    value = found->get<std::string>();
    expand(key, *found);
  }
}

void Section::flag(std::string_view key, bool& value, std::string_view meaning) {
  const Json* found =
      find(key, meaning, Need::optional, "flag", {}, "true | false", value ? "true" : "false");
  if (found == nullptr) {
    if (source_ != nullptr) expand(key, value);
  } else if (!found->is_boolean()) {
    fault(key, "must be true or false");
  } else {
    value = found->get<bool>();
    expand(key, *found);
  }
}

void Section::list_fault(std::string_view key, const Json& value, std::string rule) {
  walk_.faults.push_back({full(key), value.dump(), std::move(rule), "", walk_.place(full(key))});
}

void Section::numbers(std::string_view key, std::vector<double>& values, Quantity quantity,
                      Range range, std::string_view meaning, Need need) {
  std::vector<double> in_file;
  for (const double value : values) in_file.push_back(value / quantity.factor);
  const Json* found = find(key, meaning, need, "numbers", quantity, describe_range(range),
                           fmt::format("[{:g}]", fmt::join(in_file, ", ")));
  if (found == nullptr) {
    if (source_ == nullptr || need == Need::required) return;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = in_file[i] * quantity.factor;
    expand(key, in_file);
    return;
  }
  if (!found->is_array()) {
    list_fault(key, *found, "must be a list of numbers: [1, 2, 3]");
    return;
  }
  const bool good = std::all_of(found->begin(), found->end(), [&](const Json& item) {
    return item.is_number() && std::isfinite(item.get<double>()) && range.holds(item.get<double>());
  });
  if (!good) {
    list_fault(
        key, *found,
        fmt::format("must hold numbers that are each {} {}", describe_range(range), quantity.unit));
    return;
  }
  values.clear();
  for (const Json& item : *found) values.push_back(item.get<double>() * quantity.factor);
  expand(key, *found);
}

void Section::triple(std::string_view key, std::array<double, 3>& values, Quantity quantity,
                     Range range, std::string_view meaning, Need need) {
  std::vector<double> list(values.begin(), values.end());
  numbers(key, list, quantity, range, meaning, need);
  if (list.size() == 3) {
    std::copy(list.begin(), list.end(), values.begin());
  } else {
    fault(key, "must hold three numbers");
  }
}

void Section::triple(std::string_view key, std::optional<std::array<double, 3>>& values,
                     Quantity quantity, Range range, std::string_view meaning) {
  if (source_ != nullptr && !has(key)) {
    find(key, meaning, Need::optional, "numbers", quantity, "", "");
    return;
  }
  std::array<double, 3> given{};
  triple(key, given, quantity, range, meaning, Need::optional);
  if (source_ != nullptr) values = given;
}

void Section::texts(std::string_view key, std::vector<std::string>& values,
                    std::string_view meaning, Need need) {
  const Json* found = find(key, meaning, need, "texts", {}, "list of texts",
                           fmt::format("[{}]", fmt::join(values, ", ")));
  if (found == nullptr) {
    if (source_ != nullptr && need == Need::optional) expand(key, values);
    return;
  }
  if (!found->is_array() || !std::all_of(found->begin(), found->end(),
                                         [](const Json& item) { return item.is_string(); })) {
    list_fault(key, *found, "must be a list of texts: [\"a\", \"b\"]");
    return;
  }
  values = found->get<std::vector<std::string>>();
  expand(key, *found);
}

void Section::file(std::string_view key, std::filesystem::path& value, std::string_view meaning,
                   Need need) {
  const Json* found = find(key, meaning, need, "file", {}, "existing file", value.string());
  if (found == nullptr) {
    if (source_ == nullptr || need == Need::required || value.empty()) return;
  } else if (!found->is_string()) {
    fault(key, "must be a file name in quotes");
    return;
  } else {
    value = found->get<std::string>();
  }
  if (find_file(key, value)) expand(key, value.string());
}

void Section::files(std::string_view key, std::vector<std::filesystem::path>& values,
                    std::string_view meaning, Need need) {
  const Json* found = find(key, meaning, need, "files", {}, "list of existing files", "");
  if (found == nullptr) return;
  if (!found->is_array() || !std::all_of(found->begin(), found->end(),
                                         [](const Json& item) { return item.is_string(); })) {
    list_fault(key, *found, "must be a list of file names: [\"a.csv\", \"b.csv\"]");
    return;
  }
  values.clear();
  std::vector<std::string> names;
  for (const Json& item : *found) {
    values.emplace_back(item.get<std::string>());
    if (find_file(key, values.back())) names.push_back(values.back().string());
  }
  expand(key, names);
}

bool Section::find_file(std::string_view key, std::filesystem::path& value) {
  if (value.is_relative()) value = walk_.directory / value;
  value = value.lexically_normal();
  if (std::filesystem::exists(value)) return true;
  fault(key, fmt::format("there is no such file: {}", value.string()),
        "check the name; it is relative to the case");
  return false;
}

void Section::choose(std::string_view key, int& chosen, const std::vector<const char*>& names,
                     std::string_view meaning, Need need) {
  const std::string all = fmt::format("{}", fmt::join(names, " | "));
  const char* const by_default = chosen < 0 ? "" : names[static_cast<std::size_t>(chosen)];
  const Json* found = find(key, meaning, need, "choice", {}, all, by_default);
  if (found == nullptr) {
    if (source_ != nullptr && need == Need::optional) expand(key, by_default);
    return;
  }
  const auto named = std::find_if(names.begin(), names.end(), [&](const char* name) {
    return found->is_string() && found->get<std::string>() == name;
  });
  if (named == names.end()) {
    fault(key, "must be one of " + all);
    return;
  }
  chosen = static_cast<int>(named - names.begin());
  expand(key, *named);
}

bool Section::table(std::string_view key, std::string_view meaning, Need need,
                    const std::function<void(Section&)>& bind) {
  const Json* found = find(key, meaning, need, "table", {}, "", "");
  if (source_ == nullptr) {
    Section below(walk_, full(key), nullptr, nullptr);
    bind(below);
    return true;
  }
  if (found == nullptr) return false;
  if (!found->is_object()) {
    fault(key, fmt::format("must be a table: [{}]", full(key)));
    return false;
  }
  Json expanded = Json::object();
  Section below(walk_, full(key), found, &expanded);
  bind(below);
  below.refuse_unknown();
  expand(key, expanded);
  return true;
}

void Section::tables(std::string_view key, std::string_view meaning, Need need,
                     const std::function<void(Section&, std::size_t)>& bind) {
  const Json* found = find(key, meaning, need, "list of tables", {}, "", "");
  if (source_ == nullptr) {
    Section below(walk_, full(key) + "[]", nullptr, nullptr);
    bind(below, 0);
    return;
  }
  if (found == nullptr) return;
  if (!found->is_array() || !std::all_of(found->begin(), found->end(),
                                         [](const Json& item) { return item.is_object(); })) {
    list_fault(key, *found, fmt::format("must be a list of tables: [[{}]]", full(key)));
    return;
  }
  if (found->empty() && need == Need::required) fault(key, "must hold at least one table");
  Json expanded = Json::array();
  for (std::size_t i = 0; i < found->size(); ++i) {
    Json item = Json::object();
    Section below(walk_, fmt::format("{}.{}", full(key), i), &(*found)[i], &item);
    bind(below, i);
    below.refuse_unknown();
    expanded.push_back(std::move(item));
  }
  expand(key, expanded);
}

void Section::free_table(std::string_view key, std::string_view meaning) {
  const Json* found = find(key, meaning, Need::optional, "table", {}, "any keys", "");
  if (found == nullptr) return;
  if (!found->is_object()) {
    fault(key, fmt::format("must be a table: [{}]", full(key)));
    return;
  }
  expand(key, *found);
}

void Section::exactly_one_of(std::initializer_list<std::string_view> keys) {
  if (source_ == nullptr) return;
  const auto count = std::count_if(keys.begin(), keys.end(), [&](auto key) { return has(key); });
  if (count == 1) return;
  const std::string names = fmt::format("{}", fmt::join(keys, ", "));
  walk_.faults.push_back({path_.empty() ? names : path_, "",
                          count == 0 ? "needs one of " + names : "takes only one of " + names,
                          count == 0 ? "" : "remove the others", walk_.place(path_)});
}

void Section::refuse_unknown() {
  for (const auto& [key, value] : source_->items()) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    const std::string close = nearest(key, known_);
    walk_.faults.push_back({full(key), value.is_structured() ? "" : value.dump(),
                            "is no known key here",
                            close.empty() ? fmt::format("known: {}", fmt::join(known_, ", "))
                                          : fmt::format("did you mean {}?", close),
                            walk_.place(full(key))});
  }
}

Json Section::read(const CaseRun& run, const std::function<void(Section&)>& bind) {
  Walk walk;
  walk.tree = &run.tree;
  walk.directory = run.directory;
  Json expanded = Json::object();
  Section top(walk, "", &run.tree.values, &expanded);
  bind(top);
  top.refuse_unknown();
  if (!walk.faults.empty()) throw InvalidInput(walk.faults);
  return expanded;
}

std::vector<SchemaKey> Section::schema(const std::function<void(Section&)>& bind) {
  Walk walk;
  Section top(walk, "", nullptr, nullptr);
  bind(top);
  // A key that two branches know is listed once.
  std::vector<SchemaKey> keys;
  for (SchemaKey& key : walk.keys) {
    const bool seen = std::any_of(keys.begin(), keys.end(),
                                  [&](const SchemaKey& other) { return other.path == key.path; });
    if (!seen) keys.push_back(std::move(key));
  }
  return keys;
}

}  // namespace osteomill::io
