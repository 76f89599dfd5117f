// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

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

  /// A coordinate among the cells (>= 0) that is stepped along a row of voxels, in units of 2^-32.
  static std::int64_t fixed(double coordinate) {
    return static_cast<std::int64_t>(coordinate * 4294967296.0);
  }
  /// Shares of the cells before, at and after `nearest`, which becomes the index of the cell next
  /// to the coordinate. kZeros zeros stand before the three and behind them.
  const float* shares(std::int64_t coordinate, int& nearest) const {
    const std::int64_t from_edge = coordinate + (std::int64_t{1} << 31);
    nearest = static_cast<int>(from_edge >> 32);
    const auto phase = static_cast<std::size_t>((from_edge >> (32 - kPhaseBits)) & (kPhases - 1));
    return table_[phase].data() + kZeros;
  }
  static constexpr int kZeros = 5;
  static constexpr int kPhaseBits = 7;
  static constexpr int kPhases = 1 << kPhaseBits;

  /// The three shares of each phase, kStride apart.
  const float* table() const { return table_[0].data() + kZeros; }
  static constexpr int kStride = 2 * kZeros + 3;

  bool operator==(const VoxelShadow& other) const { return widths_ == other.widths_; }

 private:
  std::array<double, 4> widths_{};  ///< of the boxes, the cell's own first
  int boxes_ = 0;
  double half_width_ = 0.0;
  std::array<std::array<float, kStride>, kPhases> table_{};
};

/// The shares of four neighbouring voxels of a row among eight cells, by the phase of the first.
class FourShadows {
 public:
  /// The coordinate changes by `rate` from voxel to voxel, in units of 2^-32, at most a cell.
  void prepare(const VoxelShadow& shadow, std::int64_t rate);

  /// Eight cells for each voxel, at each of VoxelShadow::kPhases phases.
  const float* table() const { return table_.data(); }
  /// Of the eight cells the first, against the cell next to the first voxel.
  int first_cell() const { return rate_ < 0 ? -4 : -1; }

 private:
  static constexpr int kVoxels = 4, kCells = 8;
  VoxelShadow shadow_;
  std::int64_t rate_ = 0;
  std::vector<float> table_;
};

}  // namespace osteomill::workpiece
