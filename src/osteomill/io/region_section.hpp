// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/io/mesh_file.hpp"
#include "osteomill/io/robot_case.hpp"

namespace osteomill::io {

class Section;

enum class PlanKind : std::uint8_t { half_space, box, ball, tray, femur, mesh, surface };

/// [plan]: the bone that is to go.
struct PlanCase {
  PlanKind kind = PlanKind::half_space;
  std::array<double, 3> point{}, normal{0, 0, 1};            ///< half-space: what lies beyond goes
  std::array<double, 3> lower{}, upper{};                    ///< box, m
  std::array<double, 3> centre{};                            ///< ball, m
  double radius = 0.0;                                       ///< ball, m
  std::vector<double> x, y;                                  ///< corners of a tray, m
  double low = 0.0, high = 0.0;                              ///< of a tray, m
  ImplantCase implant;                                       ///< femur
  std::array<double, 3> origin{};                            ///< of the implant in W, m
  std::array<double, 3> distal{0, 0, 1}, anterior{0, 1, 0};  ///< directions in W
  std::filesystem::path file;                                ///< mesh, surface
  LengthUnit unit = LengthUnit::guess;
};

enum class NoGoKind : std::uint8_t { mesh, box, ball, half_space };

/// [[no_go]]: what the tool must keep away from.
struct NoGoCase {
  std::string name;
  NoGoKind kind = NoGoKind::mesh;
  double margin = 2e-3;  ///< m
  std::filesystem::path file;
  LengthUnit unit = LengthUnit::guess;
  std::array<double, 3> lower{}, upper{};          ///< m
  std::array<double, 3> centre{};                  ///< m
  double radius = 0.0;                             ///< m
  std::array<double, 3> point{}, normal{0, 0, 1};  ///< half-space: what lies beyond
};

/// [access]: the opening through which an upright tool has to pass.
struct AccessCase {
  double height = 0.0;       ///< z of W, m
  std::vector<double> x, y;  ///< corners, or the middle of a circle, m
  double radius = 0.0;       ///< of a circle, m; 0: corners
};

struct RegionCase {
  std::optional<PlanCase> plan;
  std::vector<NoGoCase> no_go;
  std::optional<AccessCase> access;
};

void bind_regions(Section& section, RegionCase& regions);

}  // namespace osteomill::io
