// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "osteomill/base/error.hpp"

namespace osteomill::io {

struct CaseRun;

/// A unit of the case file: value in SI = value in the file × factor. The key carries its name.
struct Quantity {
  double factor = 1.0;
  const char* unit = "";
};

/// What a number may be, in the unit of the file.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  ///< low itself is not allowed

  bool holds(double value) const {
    return (low_open ? value > low : value >= low) && value <= high;
  }
};
inline Range any() { return {}; }
inline Range positive() { return {0.0, std::numeric_limits<double>::infinity(), true}; }
inline Range non_negative() { return {0.0}; }
inline Range between(double low, double high) { return {low, high}; }
/// 0 < value <= high
inline Range up_to(double high) { return {0.0, high, true}; }

enum class Need { required, optional };

/// One line of the schema: a key of a case, as `osteomill schema` prints it.
struct SchemaKey {
  std::string path;  ///< "cutter.diameter_mm"; elements of lists as "run[].name"
  std::string type;  ///< number, integer, text, flag, choice, numbers, file, table, list of tables
  std::string unit;
  std::string allowed;        ///< "> 0", "slot | up | down"
  std::string default_value;  ///< empty when there is none
  Need need = Need::required;
  std::string meaning;
};

/// One table of a case while a `bind_…` function walks over its keys.
///
/// A bind function names each key once, with its unit, range, meaning and the variable it goes to.
/// The same function then serves to read a case (all faults are collected, none is thrown before
/// the end), to write the expanded case (defaults filled in), and to print the schema. In a schema
/// walk nothing is read and `when` is always true, so that every branch is seen.
///
/// A variable that is not std::optional and whose key is Need::optional holds its default before
/// the call.
class Section {
 public:
  Section(const Section&) = delete;
  Section& operator=(const Section&) = delete;

  void number(std::string_view key, double& value, Quantity quantity, Range range,
              std::string_view meaning, Need need = Need::required);
  void number(std::string_view key, std::optional<double>& value, Quantity quantity, Range range,
              std::string_view meaning);
  void integer(std::string_view key, int& value, Range range, std::string_view meaning,
               Need need = Need::required);
  void text(std::string_view key, std::string& value, std::string_view meaning,
            Need need = Need::required);
  void flag(std::string_view key, bool& value, std::string_view meaning);
  void numbers(std::string_view key, std::vector<double>& values, Quantity quantity, Range range,
               std::string_view meaning, Need need = Need::required);
  void texts(std::string_view key, std::vector<std::string>& values, std::string_view meaning,
             Need need = Need::required);
  /// Exactly three numbers.
  void triple(std::string_view key, std::array<double, 3>& values, Quantity quantity, Range range,
              std::string_view meaning, Need need = Need::required);
  void triple(std::string_view key, std::optional<std::array<double, 3>>& values, Quantity quantity,
              Range range, std::string_view meaning);
  /// A file or folder that must exist; relative to the case.
  void file(std::string_view key, std::filesystem::path& value, std::string_view meaning,
            Need need = Need::required);
  /// A list of such files.
  void files(std::string_view key, std::vector<std::filesystem::path>& values,
             std::string_view meaning, Need need = Need::required);

  template <class E>
  void choice(std::string_view key, E& value,
              std::initializer_list<std::pair<const char*, E>> options, std::string_view meaning,
              Need need = Need::required) {
    std::vector<const char*> names;
    int chosen = -1;
    for (const auto& [name, option] : options) {
      if (option == value) chosen = static_cast<int>(names.size());
      names.push_back(name);
    }
    choose(key, chosen, names, meaning, need);
    if (chosen >= 0) value = (options.begin() + chosen)->second;
  }

  /// A table below this one; returns whether it is there. When it is optional and absent, `bind` is
  /// walked over an empty table only in a schema walk.
  bool table(std::string_view key, std::string_view meaning, Need need,
             const std::function<void(Section&)>& bind);
  /// A list of tables; `bind` is called for each with its number.
  void tables(std::string_view key, std::string_view meaning, Need need,
              const std::function<void(Section&, std::size_t)>& bind);
  /// A table whose keys are not ours to know, as the provenance of a catalogue entry.
  void free_table(std::string_view key, std::string_view meaning);

  /// The condition when reading; true in a schema walk.
  bool when(bool condition) const;
  bool has(std::string_view key) const;
  /// A fault unless exactly one of the keys is there.
  void exactly_one_of(std::initializer_list<std::string_view> keys);
  /// Records a fault of a key whose value is known only together with others.
  void fault(std::string_view key, std::string rule, std::string remedy = "");

  /// Runs over the top-level table of a case; throws InvalidInput with all faults, unknown keys
  /// among them. Returns the expanded table: as read, with the defaults filled in.
  static nlohmann::ordered_json read(const CaseRun& run, const std::function<void(Section&)>& bind);
  /// The keys that a bind function knows.
  static std::vector<SchemaKey> schema(const std::function<void(Section&)>& bind);

 private:
  struct Walk;
  Section(Walk& walk, std::string path, const nlohmann::ordered_json* source,
          nlohmann::ordered_json* expanded);

  const nlohmann::ordered_json* find(std::string_view key, std::string_view meaning, Need need,
                                     const char* type, Quantity quantity, std::string allowed,
                                     std::string default_value);
  void choose(std::string_view key, int& chosen, const std::vector<const char*>& names,
              std::string_view meaning, Need need);
  bool check(std::string_view key, const nlohmann::ordered_json& value, Quantity quantity,
             const Range& range);
  void list_fault(std::string_view key, const nlohmann::ordered_json& value, std::string rule);
  bool find_file(std::string_view key, std::filesystem::path& value);
  void expand(std::string_view key, const nlohmann::ordered_json& value);
  void refuse_unknown();
  std::string full(std::string_view key) const;

  Walk& walk_;
  std::string path_;
  const nlohmann::ordered_json* source_;  ///< null in a schema walk
  nlohmann::ordered_json* expanded_;
  std::vector<std::string> known_;
};

}  // namespace osteomill::io
