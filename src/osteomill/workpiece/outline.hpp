// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "osteomill/workpiece/stock.hpp"

namespace osteomill::workpiece {

using Vector2 = Eigen::Vector2d;
using Polygon = std::vector<Vector2>;  ///< corners, m; the last joins the first

/// A part of a plane z = constant of W: borders counter-clockwise, holes clockwise. Coordinates are
/// kept to 10 nm (Clipper works on integers).
struct Outline {
  std::vector<Polygon> polygons;
  bool empty() const { return polygons.empty(); }
};

/// m²
double area(const Outline& outline);

/// The outline from polygons that may overlap and run either way: what any of them encloses.
Outline outline_of(const std::vector<Polygon>& polygons);
Outline rectangle(const Vector2& lower, const Vector2& upper);
/// A polygon within 1 µm of the circle.
Outline circle(const Vector2& centre, double radius);

/// All points within `by` of the outline; for by < 0 what is farther than that from its outside.
/// Corners are rounded to 1 µm.
Outline grown(const Outline& outline, double by);
Outline without(const Outline& outline, const Outline& taken);
Outline united(const Outline& a, const Outline& b);

/// The pieces of a line that lie within the outline, in the order and direction of the line.
std::vector<std::array<Vector2, 2>> within(const Outline& outline, const Vector2& from,
                                           const Vector2& to);

/// Whether the straight way from one point to the other stays within the outline.
bool reaches(const Outline& outline, const Vector2& from, const Vector2& to);

/// The bone between two heights as it is seen from above: columns of voxels with half a voxel of
/// bone or more, smoothed to half a voxel.
Outline shadow(const Stock& stock, double z_low, double z_high);

}  // namespace osteomill::workpiece
