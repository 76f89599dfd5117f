// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/test_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/csv_file.hpp"
#include "osteomill/io/force_record_table.hpp"

namespace osteomill::io {
namespace {

struct Suffix {
  const char* text;
  double factor;
};
const std::vector<Suffix> kLengths{{"_mm", units::mm}, {"_um", units::um}, {"_m", 1.0}};
const std::vector<Suffix> kFeeds{{"_mm_per_min", units::mm_per_min},
                                 {"_mm_per_s", units::mm_per_s}};
const std::vector<Suffix> kSpeeds{{"_rpm", units::rpm}, {"_rad_per_s", 1.0}};
const std::vector<Suffix> kAngles{{"_deg", units::deg}, {"_rad", 1.0}};
const std::vector<Suffix> kForces{
    {"_n", 1.0}, {"_kn", 1e3}, {"_lbf", *unit_factor(UnitKind::force, "lbf")}};
const std::vector<Suffix> kNone{{"", 1.0}};

/// Reads cells of the table by the name of the quantity; gathers what is wrong.
class Cells {
 public:
  explicit Cells(const CsvFile& table) : table_(table) {}

  /// The column of a quantity and its factor; -1 when it is not there. A quantity without its unit,
  /// or with one that it cannot have, is a fault.
  std::pair<int, double> column(const std::string& quantity, const std::vector<Suffix>& suffixes) {
    std::pair<int, double> found{-1, 1.0};
    for (const Suffix& suffix : suffixes) {
      const auto at =
          std::find(table_.columns.begin(), table_.columns.end(), quantity + suffix.text);
      if (at == table_.columns.end()) continue;
      if (found.first >= 0)
        fault(quantity, "", "stands twice, in two units", "take one of them out", 1);
      found = {static_cast<int>(at - table_.columns.begin()), suffix.factor};
    }
    if (found.first >= 0 || suffixes.front().text[0] == '\0') return found;
    for (const std::string& name : table_.columns) {
      const bool begins = name == quantity || name.starts_with(quantity + "_");
      if (!begins || others_.contains(name)) continue;
      std::string allowed;
      for (const Suffix& suffix : suffixes)
        allowed += (allowed.empty() ? "" : ", ") + quantity + suffix.text;
      if (reported_.insert(name).second)
        fault(name, "", "does not say its unit, or one that it cannot have", "name it " + allowed,
              1);
    }
    return found;
  }

  std::optional<double> number(const CsvFile::Row& row, std::pair<int, double> column) {
    if (column.first < 0) return {};
    const std::string& cell = row.cells[static_cast<std::size_t>(column.first)];
    if (cell.empty()) return {};
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value)) {
      fault(name_of(column), cell, "must be a number", "", row.line);
      return {};
    }
    return value * column.second;
  }

  /// A number that must be above zero.
  std::optional<double> positive(const CsvFile::Row& row, std::pair<int, double> column) {
    const auto value = number(row, column);
    if (value && !(*value > 0.0)) {
      fault(name_of(column), row.cells[static_cast<std::size_t>(column.first)], "must be > 0", "",
            row.line);
      return {};
    }
    return value;
  }

  std::string text(const CsvFile::Row& row, const std::string& name) const {
    const auto at = std::find(table_.columns.begin(), table_.columns.end(), name);
    return at == table_.columns.end()
               ? std::string()
               : row.cells[static_cast<std::size_t>(at - table_.columns.begin())];
  }

  void fault(std::string field, std::string value, std::string rule, std::string remedy, int line) {
    faults_.push_back({std::move(field), std::move(value), std::move(rule), std::move(remedy),
                       fmt::format("{}:{}", table_.name, line)});
  }
  /// Names that only begin like a quantity.
  void keep_out(std::set<std::string> names) { others_ = std::move(names); }
  void raise() {
    if (!faults_.empty()) throw InvalidInput(std::move(faults_));
  }

 private:
  const std::string& name_of(std::pair<int, double> column) const {
    return table_.columns[static_cast<std::size_t>(column.first)];
  }

  const CsvFile& table_;
  std::vector<Fault> faults_;
  std::set<std::string> others_, reported_;
};

std::optional<cutting::ImmersionKind> immersion_of(Cells& cells, const CsvFile::Row& row) {
  using cutting::ImmersionKind;
  const std::string text = cells.text(row, "immersion");
  if (text.empty()) return {};
  for (const auto& [name, kind] :
       {std::pair{"slot", ImmersionKind::slot}, std::pair{"up", ImmersionKind::up},
        std::pair{"down", ImmersionKind::down}}) {
    if (text == name) return kind;
  }
  cells.fault("immersion", text, "must be slot, up or down", "", row.line);
  return {};
}

using Triple = std::array<std::pair<int, double>, 3>;

Triple triple(Cells& cells, const std::string& quantity) {
  return {cells.column(quantity + "_x", kForces), cells.column(quantity + "_y", kForces),
          cells.column(quantity + "_z", kForces)};
}

/// All three of a row, or none.
std::optional<geometry::Vector3> vector(Cells& cells, const CsvFile::Row& row,
                                        const Triple& columns, const char* quantity) {
  geometry::Vector3 out;
  int count = 0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (const auto value = cells.number(row, columns[static_cast<std::size_t>(axis)])) {
      out[axis] = *value;
      ++count;
    }
  }
  if (count == 3) return out;
  if (count > 0)
    cells.fault(quantity, fmt::format("{} of x, y, z", count), "must be given for all three axes",
                "leave all three empty where it is not known", row.line);
  return {};
}

}  // namespace

std::vector<TestRow> read_test_table(const std::filesystem::path& file) {
  const CsvFile table = read_csv(file);
  Cells cells(table);
  const auto depth = cells.column("axial_depth", kLengths);
  const auto radial = cells.column("radial_depth", kLengths);
  const auto tooth = cells.column("feed_per_tooth", kLengths);
  const auto rate = cells.column("feed_rate", kFeeds);
  const auto speed = cells.column("spindle_speed", kSpeeds);
  const auto diameter = cells.column("diameter", kLengths);
  const auto fibre = cells.column("fibre_angle", kAngles);
  const auto flutes = cells.column("flutes", kNone);
  const Triple mean = triple(cells, "mean_force"), error = triple(cells, "standard_error");
  std::vector<TestRow> out;
  std::set<std::string> names;
  for (const CsvFile::Row& row : table.rows) {
    TestRow one;
    one.line = row.line;
    one.name = cells.text(row, "name");
    if (one.name.empty()) one.name = cells.text(row, "experiment");
    if (one.name.empty()) one.name = std::to_string(out.size() + 1);
    if (!names.insert(one.name).second)
      cells.fault("name", one.name, "stands twice", "give each experiment its own", row.line);
    one.group = cells.text(row, "group");
    one.cutter = cells.text(row, "cutter");
    one.axial_depth = cells.positive(row, depth);
    one.radial_depth = cells.positive(row, radial);
    one.feed_per_tooth = cells.positive(row, tooth);
    one.feed_rate = cells.positive(row, rate);
    one.spindle_speed = cells.positive(row, speed);
    one.diameter = cells.positive(row, diameter);
    one.fibre_angle = cells.number(row, fibre);
    if (const auto count = cells.positive(row, flutes)) {
      if (*count != std::floor(*count) || *count > 64.0)
        cells.fault("flutes", fmt::format("{:g}", *count), "must be a whole number up to 64", "",
                    row.line);
      one.flutes = static_cast<int>(std::min(64.0, *count));
    }
    one.immersion = immersion_of(cells, row);
    one.mean_force = vector(cells, row, mean, "mean_force");
    one.standard_error = vector(cells, row, error, "standard_error");
    const std::string record = cells.text(row, "record");
    if (!record.empty()) one.record = file.parent_path() / record;
    if (record.empty() == !one.mean_force.has_value())
      cells.fault("record", record,
                  record.empty() ? "neither a record nor mean forces are given"
                                 : "stands beside mean forces",
                  "give one of the two: record, or mean_force_{x,y,z}_n", row.line);
    out.push_back(std::move(one));
  }
  if (out.empty()) cells.fault("rows", "0", "needs one experiment at least", "", 1);
  cells.raise();
  return out;
}

}  // namespace osteomill::io
