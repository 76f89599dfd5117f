// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/engagement_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/csv_file.hpp"

namespace osteomill::io {
namespace {

constexpr std::array<const char*, 3> kColumns = {"height_mm", "angle_deg", "weight"};

struct Patch {
  std::array<double, 3> values{};  ///< as the columns
  int line = 0;
};

std::vector<Patch> patches_of(const CsvFile& table) {
  std::vector<Fault> faults;
  std::array<std::optional<std::size_t>, 3> places;
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto found = std::find(table.columns.begin(), table.columns.end(), kColumns[i]);
    if (found != table.columns.end()) {
      places[i] = static_cast<std::size_t>(found - table.columns.begin());
    } else {
      faults.push_back(
          {kColumns[i], "", "is missing", "name the column in the heading", table.name});
    }
  }
  std::vector<Patch> patches;
  for (const CsvFile::Row& row : table.rows) {
    Patch patch;
    patch.line = row.line;
    for (std::size_t i = 0; i < kColumns.size(); ++i) {
      if (!places[i]) continue;
      const std::string& cell = row.cells[*places[i]];
      const auto [end, error] =
          std::from_chars(cell.data(), cell.data() + cell.size(), patch.values[i]);
      if (error == std::errc{} && end == cell.data() + cell.size() &&
          std::isfinite(patch.values[i]) && patch.values[i] >= 0.0) {
        continue;
      }
      faults.push_back({kColumns[i], cell, "must be a number >= 0", "",
                        fmt::format("{}:{}", table.name, row.line)});
    }
    if (patch.values[1] >= 360.0) {
      faults.push_back({"angle_deg", fmt::format("{:g} deg", patch.values[1]), "must be < 360", "",
                        fmt::format("{}:{}", table.name, row.line)});
    }
    patches.push_back(patch);
  }
  if (table.rows.empty()) faults.push_back({"engagement", "", "holds no patch", "", table.name});
  if (!faults.empty()) throw InvalidInput(faults);
  return patches;
}

/// The smallest step between different values of a column, 0 when there is one value only.
double step_of(const std::vector<Patch>& patches, std::size_t column) {
  std::vector<double> values;
  for (const Patch& patch : patches) values.push_back(patch.values[column]);
  std::sort(values.begin(), values.end());
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double gap = values[i] - values[i - 1];
    if (gap > 1e-9) step = std::min(step, gap);
  }
  return std::isfinite(step) ? step : 0.0;
}

/// The number of the step that a value is, or a fault: a thousandth of a step is rounding.
std::optional<int> number_of(double value, double step) {
  const double number = std::round(value / step);
  if (std::abs(value / step - number) > 1e-3) return {};
  return static_cast<int>(number);
}

}  // namespace

cutting::Engagement read_engagement(const std::filesystem::path& file, double slice_height,
                                    int angles) {
  const CsvFile table = read_csv(file);
  const std::vector<Patch> patches = patches_of(table);
  const double height = slice_height > 0.0 ? slice_height / units::mm : step_of(patches, 0);
  const double turn = angles > 0 ? 360.0 / angles : step_of(patches, 1);
  if (!(height > 0.0) || !(turn > 0.0)) {
    throw InvalidInput(Fault{"engagement", "one slice or one angle alone",
                             "does not tell the size of a patch",
                             "set engagement.slice_height_mm and engagement.angles", table.name});
  }
  const std::optional<int> around = number_of(360.0, turn);
  if (!around) {
    throw InvalidInput(Fault{"angle_deg", fmt::format("steps of {:g} deg", turn),
                             "must be a whole part of 360 deg", "", table.name});
  }
  std::vector<Fault> faults;
  cutting::Engagement map{0, *around, height * units::mm, {}};
  std::vector<std::array<int, 2>> cells;
  for (const Patch& patch : patches) {
    const auto slice = number_of(patch.values[0], height);
    const auto angle = number_of(patch.values[1], turn);
    if (!slice || !angle) {
      faults.push_back(
          {slice ? "angle_deg" : "height_mm", fmt::format("{:g}", patch.values[slice ? 1 : 0]),
           fmt::format("must be a multiple of {:g}", slice ? turn : height),
           "patches are a regular grid", fmt::format("{}:{}", table.name, patch.line)});
      continue;
    }
    cells.push_back({*slice, *angle});
    map.slices = std::max(map.slices, *slice + 1);
  }
  if (!faults.empty()) throw InvalidInput(faults);
  map.weights.assign(static_cast<std::size_t>(map.slices) * static_cast<std::size_t>(map.angles),
                     0.0);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    map.at(cells[i][0], cells[i][1]) = patches[i].values[2];
  }
  return map;
}

}  // namespace osteomill::io
