// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "osteomill/geometry/mesh.hpp"
#include "osteomill/geometry/voxel_grid.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::io {

/// What lies on the side of the plane to which `away` points is left out, to look inside.
struct CutPlane {
  geometry::Vector3 point = geometry::Vector3::Zero();
  geometry::Vector3 away = geometry::Vector3::UnitZ();
};

struct SurfaceOptions {
  /// 0: every voxel of the surface keeps its corner; up to 1: flat parts become large triangles.
  double simplify = 0.02;
  /// Blocks of this many voxels a side are taken together first, to keep reports small.
  int coarsen = 1;
  std::optional<CutPlane> cut{};
};

/// The closed surface at which the occupancy crosses one half; outside the grid there is nothing,
/// so the outer faces of its voxels close it. Vertices in the frame of the grid, m.
geometry::Mesh surface_of(const geometry::VoxelGrid<float>& occupancy,
                          const SurfaceOptions& options = {});

/// The surface of the bone that is left, with its density at each vertex, kg/m³.
geometry::Mesh surface_of(const workpiece::Stock& stock, const SurfaceOptions& options = {});

/// Gives each vertex the value of the field there (trilinear).
void colour_by(geometry::Mesh& mesh, const geometry::VoxelGrid<float>& field);

}  // namespace osteomill::io
