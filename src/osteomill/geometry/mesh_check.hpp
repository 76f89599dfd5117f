// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "osteomill/geometry/mesh.hpp"

namespace osteomill::geometry {

/// What the mesh encloses, m³: above 0 when its corners run counter-clockwise seen from outside.
/// Only of use for a closed mesh.
double volume(const Mesh& mesh);

/// m²
double area(const Mesh& mesh);

/// How the triangles hang together. A solid has none of these.
struct MeshFlaws {
  std::size_t open_edges = 0;      ///< of one triangle: the rim of a hole
  std::size_t crowded_edges = 0;   ///< of three triangles or more
  std::size_t turned_edges = 0;    ///< of two triangles that run along it the same way
  std::size_t flat_triangles = 0;  ///< two corners are one vertex, or the area is zero
  bool watertight() const { return open_edges + crowded_edges + turned_edges == 0; }
};

MeshFlaws flaws(const Mesh& mesh);

}  // namespace osteomill::geometry
