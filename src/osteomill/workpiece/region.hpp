// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "osteomill/workpiece/outline.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::workpiece {

/// A part of space by its signed distance, m: < 0 inside. Where several surfaces meet it is never
/// larger in size than the distance. Called from several threads.
using Region = std::function<double(const Vector3& p_W)>;

/// What lies beyond the plane on the side to which `normal` points.
Region half_space(const Vector3& point, const Vector3& normal);
Region box(const Vector3& lower, const Vector3& upper);
Region ball(const Vector3& centre, double radius);
/// The outline in x and y, between two heights.
Region prism(const Outline& outline, double z_low, double z_high);
/// What any, or what all, of the regions hold. Throws InvalidInput for none.
Region any_of(std::vector<Region> regions);
Region all_of(std::vector<Region> regions);
Region outside(Region region);

/// What a path did to a stock beside what it was to do. The share of a voxel within the plan is
/// that of its occupancy, clamp(1/2 - d/h).
struct PlanResult {
  double planned_volume = 0.0;   ///< bone within the plan before, m³
  double removed_volume = 0.0;   ///< of it, m³
  double uncut_volume = 0.0;     ///< of it, that is left, m³
  double over_cut_volume = 0.0;  ///< removed outside the plan, m³
  double uncut_height = 0.0;     ///< farthest into the plan that bone is left, m
  double over_cut_depth = 0.0;   ///< farthest outside the plan that bone was removed, m
};
/// Both stocks on the same grid. Depths count voxels that have lost or kept half their bone.
PlanResult compare(const Stock& before, const Stock& after, const Region& plan);

}  // namespace osteomill::workpiece
