// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/geometry/mesh.hpp"
#include "osteomill/geometry/mesh_check.hpp"

namespace osteomill::geometry {

struct MeshRepairOptions {
  double weld = 0.0;              ///< vertices this near are one, m; 0: only where they are equal
  std::size_t largest_hole = 60;  ///< holes of up to so many edges are closed
  /// ... when they are no wider than this share of the diagonal of what they are in: a fan over
  /// half a bone would make up its shape, and one over a loose triangle a solid without inside.
  double widest_hole = 0.25;
};

struct Hole {
  std::size_t edges = 0;
  double width = 0.0;                                ///< largest extent of its rim, m
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();  ///< m
};

/// What was done to make a mesh a solid.
struct MeshRepair {
  std::size_t merged_vertices = 0;
  std::size_t dropped_triangles = 0;  ///< flat, or there twice
  std::size_t turned_triangles = 0;   ///< ran against their neighbours
  bool turned_all = false;            ///< the mesh was inside out
  std::vector<Hole> closed_holes;
  std::vector<Hole> open_holes;  ///< too large to be closed; those without a simple rim left out
  std::size_t parts = 0;         ///< that hang together
  MeshFlaws left;                ///< what is still wrong

  bool untouched() const {
    return dropped_triangles + turned_triangles + closed_holes.size() == 0 && !turned_all;
  }
};

/// "merged 12 345 equal vertices; closed 2 holes; watertight", for people.
std::string describe(const MeshRepair& repair);

/// Merges equal vertices, drops triangles that are flat or there twice, turns triangles so that
/// neighbours agree and the largest part is the right way out (the others keep their sense to it: a
/// cavity stays one), and closes small holes with a fan. Values go with their vertices.
MeshRepair repair(Mesh& mesh, const MeshRepairOptions& options = {});

}  // namespace osteomill::geometry
