// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace osteomill::io {

/// The points of the one polyline of a drawing, in metres: a DXF file in text form with one
/// LWPOLYLINE or POLYLINE, or an SVG file with one polyline, polygon, or path of straight pieces
/// (M L H V and their small letters). SVG's y axis points down and is turned up. Curved pieces, no
/// or several polylines are InvalidInput that says what was found.
std::vector<Eigen::Vector2d> read_polyline(const std::filesystem::path& file, double unit);

}  // namespace osteomill::io
