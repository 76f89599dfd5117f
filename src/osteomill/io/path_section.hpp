// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "osteomill/workpiece/passes.hpp"

namespace osteomill::io {

class Section;
struct StockCase;

enum class PathKind : std::uint8_t {
  lines,
  zigzag,
  one_way,
  rough_finish,
  raster,
  contour,
  trochoid,
  swing,
  surface,
  points,
  gcode,
  cl
};

/// Where the tool's axis may go, seen from above.
enum class OutlineKind : std::uint8_t { bone, rectangle, circle, polygon };

struct OutlineCase {
  OutlineKind kind = OutlineKind::bone;
  std::vector<double> x, y;    ///< of corners, or of a circle's middle, m
  double radius = 0.0;         ///< of a circle, m
  std::optional<double> grow;  ///< m; none: 0 around bone, minus the cutter's radius in a pocket
  bool avoid_no_go = false;    ///< what the no-go regions forbid is taken out
};

/// [path]: what the cutter is to do.
struct PathCase {
  PathKind kind = PathKind::lines;
  double feed = 0.0;            ///< programmed, m/s
  double spindle_speed = 0.0;   ///< rad/s
  double rapid_feed = 12e-3;    ///< m/s
  double clearance = 5e-3;      ///< m
  bool skip_air = false;        ///< cuts through air become rapids
  double air_clearance = 2e-3;  ///< m
  workpiece::Milling milling = workpiece::Milling::down;
  // lines, zigzag, one-way, rough-finish, trochoid
  int lines = 1;
  std::array<double, 3> start{};      ///< m
  std::array<double, 3> along{};      ///< m
  std::array<double, 3> step_over{};  ///< m
  std::array<double, 3> allowance{};  ///< of the rough pass, m
  double finish_feed = 0.0;           ///< m/s; 0: the feed
  // raster, contour, trochoid, surface
  OutlineCase outline;
  double top = 0.0;           ///< where the bone begins, m
  double bottom = 0.0;        ///< lowest level of the tip, m
  double axial_step = 2e-3;   ///< m
  double radial_step = 1e-3;  ///< m
  double direction = 0.0;     ///< of a raster, rad
  bool to_and_fro = true;
  bool from_outside = true;
  double slot_width = 0.0;  ///< m
  double advance = 0.5e-3;  ///< of a trochoid, m
  // surface
  double scallop = 20e-6;          ///< m
  double surface_allowance = 0.0;  ///< m
  double sample = 0.25e-3;         ///< m
  bool along_y = false;
  // swing
  std::array<double, 3> pivot{};  ///< m
  std::array<double, 3> normal{0, 0, 1};
  std::array<double, 3> forward{1, 0, 0};
  double first_angle = 0.0, last_angle = 0.0;          ///< rad
  double first_insertion = 0.0, last_insertion = 0.0;  ///< m
  double groove = 10e-3;                               ///< advance from swing to swing, m
  bool there_and_back = true;
  // points; gcode, cl
  std::vector<std::array<double, 3>> points;  ///< m
  std::filesystem::path file;

  bool from_file() const { return kind == PathKind::gcode || kind == PathKind::cl; }
};

/// Keys of a line profile that stand in [path] go to the stock's profile.
void bind_path(Section& section, PathCase& path, StockCase& stock);

}  // namespace osteomill::io
