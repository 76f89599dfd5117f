// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace osteomill::io {

class Section;
struct StockCase;

enum class PathKind : std::uint8_t { lines, zigzag, points, gcode };

/// [path]: what the cutter is to do.
struct PathCase {
  PathKind kind = PathKind::lines;
  double feed = 0.0;           ///< programmed, m/s
  double spindle_speed = 0.0;  ///< rad/s
  double rapid_feed = 12e-3;   ///< m/s
  int lines = 1;
  std::array<double, 3> start{};              ///< m
  std::array<double, 3> along{};              ///< m
  std::array<double, 3> step_over{};          ///< m
  double clearance = 5e-3;                    ///< m
  std::vector<std::array<double, 3>> points;  ///< m
  std::filesystem::path file;
};

/// Keys of a line profile that stand in [path] go to the stock's profile.
void bind_path(Section& section, PathCase& path, StockCase& stock);

}  // namespace osteomill::io
