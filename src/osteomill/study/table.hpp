// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "osteomill/study/fixed_effects.hpp"

/// The tidy table of a study: one row a cut, cells as text until a design says what they are.
namespace osteomill::study {

struct Table {
  std::string source;  ///< file name, for messages
  std::vector<std::string> columns;
  struct Row {
    int line = 0;
    std::vector<std::string> cells;  ///< as many as columns; empty = missing
  };
  std::vector<Row> rows;

  std::optional<size_t> find(std::string_view column) const;
};

/// Something that the reader of a report must know: what is wrong with the data, where, and what
/// can still be computed.
struct Finding {
  std::string what;
  std::string still;       ///< what was done, or can still be computed
  std::vector<int> lines;  ///< of the table's file
};

/// A cell that stands for a missing value: empty, NA, NaN, "-", "missing".
bool is_missing(std::string_view cell);

/// Numbers of a column, nothing where missing. Throws InvalidInput with every cell that is neither
/// (a decimal comma, a unit in the cell, a word), with its line and what to do.
std::vector<std::optional<double>> numbers(const Table& table, const std::string& column);

/// A column as levels, sorted (as numbers where all are); -1 where missing.
Factor factor(const Table& table, const std::string& column);

/// The unit that stands in a column's name: "deg" of "varus_valgus_deg"; empty where none does.
std::string unit_of(std::string_view column);

/// Rows that have the same cut_id: alike ones are counted once (a Finding), different ones are a
/// fault. Without cut_id, rows alike in every cell are named and kept.
std::vector<Finding> settle_duplicates(Table& table);

/// Mixed units: the same quantity in two columns of different unit, or one operator's angles about
/// 57 times smaller than the others' (radians among degrees). Mirrored frames: a mean varus/valgus
/// error that turns its sign with the side.
std::vector<Finding> suspicious_units(const Table& table, std::span<const std::string> responses,
                                      const std::string& subject);
std::vector<Finding> suspicious_sides(const Table& table, std::span<const std::string> responses);

}  // namespace osteomill::study
