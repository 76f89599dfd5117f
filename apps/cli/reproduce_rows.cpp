// SPDX-License-Identifier: BSD-3-Clause
#include "reproduce_rows.hpp"

#include <fmt/format.h>

#include "osteomill/io/csv_file.hpp"
#include "reproduce.hpp"

namespace osteomill::cli {

using geometry::Vector3;

std::vector<MeanRow> read_mean_rows(const std::string& name) {
  const io::CsvFile table = io::read_csv(reproduce_directory() / name);
  std::vector<MeanRow> rows;
  for (const io::CsvFile::Row& line : table.rows) {
    MeanRow row;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      const std::string& column = table.columns[i];
      const std::string& cell = line.cells[i];
      if (column == "tool") row.tool = cell;
      if (column == "kind") row.kind = cell;
      if (column == "axial_depth_mm") row.depth = std::stod(cell);
      if (column == "feed_rate_mm_per_min") row.feed_rate = std::stod(cell);
      if (column == "feed_per_tooth_mm") row.feed_per_tooth = std::stod(cell);
      if (column == "mean_force_x_n") row.force.x() = std::stod(cell);
      if (column == "mean_force_y_n") row.force.y() = std::stod(cell);
      if (column == "mean_force_z_n") row.force.z() = std::stod(cell);
    }
    rows.push_back(row);
  }
  return rows;
}

Vector3 rms(const std::vector<Vector3>& values) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& value : values) sum += value.cwiseAbs2();
  return (sum / static_cast<double>(values.size())).cwiseSqrt();
}

std::string three(const Vector3& v, int digits) {
  return fmt::format("{:.{}f} / {:.{}f} / {:.{}f}", v.x(), digits, v.y(), digits, v.z(), digits);
}

}  // namespace osteomill::cli
