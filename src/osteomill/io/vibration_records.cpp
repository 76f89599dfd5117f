// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/vibration_records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/csv_file.hpp"

namespace osteomill::io {
namespace {

/// A column as numbers; nothing when it is not there. All cells that are no number are faults.
std::optional<std::vector<double>> column(const CsvFile& table, const std::string& name) {
  const auto found = std::find(table.columns.begin(), table.columns.end(), name);
  if (found == table.columns.end()) return {};
  const auto place = static_cast<std::size_t>(found - table.columns.begin());
  std::vector<double> values;
  std::vector<Fault> faults;
  for (const CsvFile::Row& row : table.rows) {
    const std::string& cell = row.cells[place];
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value)) {
      faults.push_back(
          {name, cell, "must be a number", "", fmt::format("{}:{}", table.name, row.line)});
    }
    values.push_back(value);
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return values;
}

std::vector<double> needed(const CsvFile& table, const std::string& name) {
  auto values = column(table, name);
  if (!values) {
    throw InvalidInput(Fault{name, "", "is missing", "name the column in the heading", table.name});
  }
  return *values;
}

}  // namespace

vibration::ImpactRecord read_impact_record(const std::filesystem::path& file,
                                           vibration::Response& response) {
  const CsvFile table = read_csv(file);
  const std::vector<double> time = needed(table, "time_s");
  vibration::ImpactRecord record{
      .sample_rate = 0.0, .force = needed(table, "force_n"), .response = {}};
  if (auto displacement = column(table, "displacement_um")) {
    for (double& x : *displacement) x *= units::um;
    record.response = *displacement;
    response = vibration::Response::displacement;
  } else {
    record.response = needed(table, "acceleration_m_per_s2");
    response = vibration::Response::acceleration;
  }
  if (time.size() < 2) {
    throw InvalidInput(Fault{"time_s", "", "needs two rows at least", "", table.name});
  }
  const double step = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  for (std::size_t i = 1; i < time.size(); ++i) {
    // A thousandth of a step is what printing six digits leaves.
    if (!(std::abs(time[i] - time[i - 1] - step) <= 1e-2 * step)) {
      throw InvalidInput(Fault{"time_s", fmt::format("{:g} s", time[i]), "must grow by equal steps",
                               "resample the record",
                               fmt::format("{}:{}", table.name, table.rows[i].line)});
    }
  }
  record.sample_rate = 1.0 / step;
  return record;
}

vibration::MeasuredFrf read_frf(const std::filesystem::path& file) {
  const CsvFile table = read_csv(file);
  vibration::MeasuredFrf frf;
  frf.frequency_hz = needed(table, "frequency_hz");
  const auto real = needed(table, "real_um_per_n"), imaginary = needed(table, "imaginary_um_per_n");
  for (std::size_t i = 0; i < real.size(); ++i) {
    if (i > 0 && !(frf.frequency_hz[i] > frf.frequency_hz[i - 1])) {
      throw InvalidInput(Fault{"frequency_hz", fmt::format("{:g} Hz", frf.frequency_hz[i]),
                               "must grow from line to line", "",
                               fmt::format("{}:{}", table.name, table.rows[i].line)});
    }
    frf.receptance.emplace_back(real[i] * units::um, imaginary[i] * units::um);
  }
  const auto coherence = column(table, "coherence");
  frf.coherence = coherence.value_or(std::vector<double>(real.size(), 1.0));
  // The number of blows behind a file is not known: two make its coherence count as a weight.
  frf.blows = coherence ? 2 : 1;
  return frf;
}

}  // namespace osteomill::io
