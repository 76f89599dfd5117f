// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "osteomill/geometry/voxel_grid.hpp"

/// Time series of runs as an HDF5 file, for other programs to read: MATLAB, Python, Julia.
///
///   /                     attributes: format = "osteomill-signals", version = 1, and the file's
///   /RUN                  attributes of the run
///   /RUN/NAME             a signal: float64 [samples]; attributes: unit, about
///   /RUN/events/time_s    float64 [events]
///   /RUN/events/text      strings [events]
///   /RUN/grids/NAME       float32 [z][y][x]; attributes: unit, about, spacing_mm, origin_mm
namespace osteomill::io {

/// What a signal is measured in stands in `unit`: the values are in it.
struct Signal {
  std::string name;  ///< "time", "force_x"
  std::string unit;  ///< "s", "N", "mm/s", "1" for a pure number
  std::vector<double> values;
  std::string about{};
};

struct SignalEvent {
  double time_s = 0.0;
  std::string text;
};

struct SignalGrid {
  std::string name;  ///< "density_after"
  std::string unit;
  geometry::VoxelGrid<float> values;
  std::string about{};
};

using SignalAttributes = std::map<std::string, std::variant<double, std::int64_t, std::string>>;

struct SignalRun {
  std::string name;
  std::vector<Signal> signals;  ///< of one length when they share a time
  std::vector<SignalEvent> events{};
  std::vector<SignalGrid> grids{};
  SignalAttributes attributes{};
};

struct SignalsFile {
  std::vector<SignalRun> runs;
  SignalAttributes attributes{};
};

/// Writes the whole file or nothing. WorldError when the disk refuses, InvalidInput for a name that
/// is empty, taken twice or holds a slash.
void write_signals(const SignalsFile& file, const std::filesystem::path& path);

/// InvalidInput when it is missing, truncated, or not such a file.
SignalsFile read_signals(const std::filesystem::path& path);

}  // namespace osteomill::io
