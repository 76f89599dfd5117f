// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "osteomill/geometry/pose.hpp"

namespace osteomill::workpiece {

/// How a voxel's volume is shared between the cells of a line of cells, all of unit width.
///
/// A unit cube projects on a direction n to the convolution of boxes of widths |n_x|, |n_y|, |n_z|;
/// a cell takes its integral over its own width. Cubes tile space, so a lattice of full voxels
/// fills all cells evenly whatever the direction, which sharing between the two nearest cells does
/// not (up to 9 % ripple near 45°). The share is never wider than the nearest cell and its two
/// neighbours: (1 + sqrt 3)/2 < 3/2.
class VoxelShadow {
 public:
  VoxelShadow() : VoxelShadow(geometry::Vector3::UnitX()) {}
  explicit VoxelShadow(const geometry::Vector3& direction);

  /// Density of the share at this distance between voxel and cell; integrates to 1.
  double at(double distance) const;
  double half_width() const { return half_width_; }

  /// Shares of the cells before, at and after `nearest`, which becomes the index of the cell next
  /// to the coordinate (>= 0).
  const std::array<float, 3>& shares(double coordinate, int& nearest) const {
    nearest = static_cast<int>(coordinate + 0.5);
    return table_[static_cast<std::size_t>((coordinate - nearest + 0.5) * kPhases)];
  }

 private:
  static constexpr int kPhases = 128;
  std::array<double, 4> widths_{};  ///< of the boxes, the cell's own first
  int boxes_ = 0;
  double half_width_ = 0.0;
  std::array<std::array<float, 3>, kPhases + 1> table_{};
};

}  // namespace osteomill::workpiece
