// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "osteomill/base/error.hpp"
#include "osteomill/study/intervals.hpp"

namespace osteomill::study {
namespace {

std::optional<double> parse(std::string_view cell) {
  if (!cell.empty() && cell.front() == '+') cell.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value)) return {};
  return value;
}

std::string remedy_for(std::string_view cell) {
  std::string point(cell);
  if (std::count(point.begin(), point.end(), ',') == 1) {
    std::replace(point.begin(), point.end(), ',', '.');
    if (parse(point)) return "write a decimal point: " + point;
  }
  const size_t digits = cell.find_last_of("0123456789.");
  if (digits != std::string_view::npos && digits + 1 < cell.size() &&
      parse(cell.substr(0, digits + 1))) {
    return "write the number alone; the unit belongs into the column's name";
  }
  return "write a number, or leave the cell empty where it is missing";
}

constexpr std::array kUnits = {"deg", "rad",       "s",        "ms",         "min",
                               "mm",  "um",        "m",        "mm3",        "mm2",
                               "n",   "mm3_per_s", "mm_per_s", "mm_per_min", "percent"};

const std::vector<std::string>& side_names() {
  static const std::vector<std::string> names = {"side", "laterality"};
  return names;
}

/// Values of a response by the level of a factor, missing ones left out.
std::vector<std::vector<double>> by_level(const Factor& by,
                                          const std::vector<std::optional<double>>& values) {
  std::vector<std::vector<double>> parts(by.levels.size());
  for (size_t i = 0; i < values.size(); ++i) {
    if (values[i] && by.level[i] >= 0) parts[by.level[i]].push_back(*values[i]);
  }
  return parts;
}

}  // namespace

std::optional<size_t> Table::find(std::string_view column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) return {};
  return static_cast<size_t>(found - columns.begin());
}

bool is_missing(std::string_view cell) {
  static const std::set<std::string_view> words = {"",    "NA", "N/A",     "na", "NaN", "nan",
                                                   "NAN", "-",  "missing", ".",  "null"};
  return words.contains(cell);
}

std::vector<std::optional<double>> numbers(const Table& table, const std::string& column) {
  const auto at = table.find(column);
  if (!at) throw InvalidInput(Fault{column, "", "no such column", "", table.source});
  std::vector<std::optional<double>> values;
  std::vector<Fault> faults;
  for (const Table::Row& row : table.rows) {
    const std::string& cell = row.cells[*at];
    if (is_missing(cell)) {
      values.emplace_back();
      continue;
    }
    values.push_back(parse(cell));
    if (!values.back()) {
      faults.push_back(Fault{column, cell, "must be a number", remedy_for(cell),
                             fmt::format("{}:{}", table.source, row.line)});
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return values;
}

Factor factor(const Table& table, const std::string& column) {
  const auto at = table.find(column);
  if (!at) throw InvalidInput(Fault{column, "", "no such column", "", table.source});
  Factor result{column, {}, {}};
  for (const Table::Row& row : table.rows) {
    if (!is_missing(row.cells[*at])) result.levels.push_back(row.cells[*at]);
  }
  std::sort(result.levels.begin(), result.levels.end());
  result.levels.erase(std::unique(result.levels.begin(), result.levels.end()), result.levels.end());
  if (std::all_of(result.levels.begin(), result.levels.end(),
                  [](const std::string& level) { return parse(level).has_value(); })) {
    std::stable_sort(
        result.levels.begin(), result.levels.end(),
        [](const std::string& a, const std::string& b) { return *parse(a) < *parse(b); });
  }
  for (const Table::Row& row : table.rows) {
    const auto found = std::find(result.levels.begin(), result.levels.end(), row.cells[*at]);
    result.level.push_back(
        found == result.levels.end() ? -1 : static_cast<int>(found - result.levels.begin()));
  }
  return result;
}

std::string unit_of(std::string_view column) {
  std::string_view best;
  for (const std::string_view unit : kUnits) {
    if (column.size() > unit.size() + 1 && column.ends_with(unit) &&
        column[column.size() - unit.size() - 1] == '_' && unit.size() > best.size()) {
      best = unit;
    }
  }
  return std::string(best);
}

std::vector<Finding> settle_duplicates(Table& table) {
  std::vector<Finding> findings;
  std::vector<Fault> faults;
  const auto id = table.find("cut_id");
  std::map<std::vector<std::string>, size_t> first;
  std::vector<Table::Row> kept;
  Finding same{.what = "", .still = "", .lines = {}};
  for (Table::Row& row : table.rows) {
    const std::vector<std::string> key = id ? std::vector<std::string>{row.cells[*id]} : row.cells;
    if (id && is_missing(row.cells[*id])) {
      kept.push_back(std::move(row));
      continue;
    }
    const auto [found, fresh] = first.emplace(key, kept.size());
    if (!fresh) {
      const Table::Row& earlier = kept[found->second];
      if (id && earlier.cells != row.cells) {
        faults.push_back(Fault{"cut_id", row.cells[*id],
                               fmt::format("duplicate cut: line {} has the same cut_id and other "
                                           "values",
                                           earlier.line),
                               "give each cut its own cut_id, or leave one of the rows out",
                               fmt::format("{}:{}", table.source, row.line)});
        continue;
      }
      same.lines.push_back(row.line);
      if (id) continue;
    }
    kept.push_back(std::move(row));
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  table.rows = std::move(kept);
  if (!same.lines.empty()) {
    same.what =
        id ? fmt::format("duplicate cuts: {} row(s) repeat an earlier cut_id with the same values",
                         same.lines.size())
           : fmt::format("possible duplicate cuts: {} row(s) equal an earlier row in every cell",
                         same.lines.size());
    same.still = id ? "each cut is counted once"
                    : "all are kept, as equal results may be real; a column cut_id would settle it";
    findings.push_back(std::move(same));
  }
  return findings;
}

std::vector<Finding> suspicious_units(const Table& table, std::span<const std::string> responses,
                                      const std::string& subject) {
  std::vector<Finding> findings;
  std::map<std::string, std::string> stems;
  for (const std::string& column : table.columns) {
    const std::string unit = unit_of(column);
    if (unit.empty()) continue;
    const std::string stem = column.substr(0, column.size() - unit.size());
    const auto [found, fresh] = stems.emplace(stem, column);
    if (!fresh) {
      findings.push_back({fmt::format("mixed units: {} stands beside {}", column, found->second),
                          "each column is taken by itself; leave one of them out",
                          {}});
    }
  }
  if (!table.find(subject)) return findings;
  const Factor operators = factor(table, subject);
  for (const std::string& response : responses) {
    if (unit_of(response) != "deg") continue;
    const auto values = numbers(table, response);
    const auto parts = by_level(operators, values);
    std::vector<double> size(parts.size(), 0.0);
    for (size_t k = 0; k < parts.size(); ++k) {
      for (const double value : parts[k]) size[k] += value * value;
      if (!parts[k].empty()) size[k] = std::sqrt(size[k] / static_cast<double>(parts[k].size()));
    }
    std::vector<double> sorted = size;
    std::sort(sorted.begin(), sorted.end());
    const double median = sorted.empty() ? 0.0 : sorted[sorted.size() / 2];
    for (size_t k = 0; k < parts.size(); ++k) {
      // Radians are 57 times smaller; 20 is far outside the spread of operators (a factor of 3).
      if (parts.size() < 2 || parts[k].size() < 3 || !(size[k] > 0.0)) continue;
      const bool small = size[k]<median / 20.0, large = size[k]> median * 20.0;
      if (!small && !large) continue;
      findings.push_back(
          {fmt::format(
               "mixed units: {} of {} {} has an rms of {:.3g} deg against {:.3g} deg of the "
               "others: {}?",
               response, subject, operators.levels[k], size[k], median,
               small ? "radians among degrees" : "not degrees"),
           "the numbers are used as they stand; bring the column to degrees and run again",
           {}});
    }
    for (size_t i = 0; i < table.rows.size(); ++i) {
      if (values[i] && std::abs(*values[i]) > 45.0) {
        findings.push_back({fmt::format("{} = {:g} deg is no cutting error", response, *values[i]),
                            "it is used as it stands; check the unit and the frame of this cut",
                            {table.rows[i].line}});
      }
    }
  }
  return findings;
}

std::vector<Finding> suspicious_sides(const Table& table, std::span<const std::string> responses) {
  std::vector<Finding> findings;
  for (const std::string& name : side_names()) {
    if (!table.find(name)) continue;
    const Factor side = factor(table, name);
    if (side.levels.size() != 2) continue;
    for (const std::string& response : responses) {
      if (!response.starts_with("varus_valgus")) continue;
      const auto parts = by_level(side, numbers(table, response));
      if (parts[0].size() < 4 || parts[1].size() < 4) continue;
      const Moments a = moments(parts[0]), b = moments(parts[1]);
      if (a.mean * b.mean >= 0.0 || !(a.sd > 0.0) || !(b.sd > 0.0)) continue;
      const double pa = one_sample_t_test(a).p, pb = one_sample_t_test(b).p;
      if (std::max(pa, pb) > 0.01) continue;
      findings.push_back(
          {fmt::format(
               "mirrored frames: the mean of {} is {:.2f} deg for {} {} and {:.2f} deg for {} "
               "(p < 0.01 each)",
               response, a.mean, name, side.levels[0], b.mean, side.levels[1]),
           "the numbers are used as they stand; varus is positive on both sides: change the sign "
           "of "
           "one side if its frame was not mirrored",
           {}});
    }
  }
  return findings;
}

}  // namespace osteomill::study
