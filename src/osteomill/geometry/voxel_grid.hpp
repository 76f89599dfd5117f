// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <vector>

#include "osteomill/geometry/pose.hpp"

namespace osteomill::geometry {

/// Where the voxels are: counts, distance between centres, centre of voxel (0, 0, 0), all in the
/// grid's own frame G, whose axes are the grid's axes. x runs fastest in memory.
struct GridShape {
  std::array<int, 3> size{0, 0, 0};   ///< voxels along x, y, z
  Vector3 spacing = Vector3::Ones();  ///< m
  Vector3 origin = Vector3::Zero();   ///< centre of voxel (0, 0, 0), m

  std::size_t count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x);
  }
  bool contains(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2];
  }
  Vector3 centre(int x, int y, int z) const {
    return origin + spacing.cwiseProduct(Vector3(x, y, z));
  }
  double voxel_volume() const { return spacing.prod(); }
  /// Outer faces of the first and last voxels.
  Vector3 lower_corner() const { return origin - 0.5 * spacing; }
  Vector3 upper_corner() const {
    return lower_corner() + spacing.cwiseProduct(Vector3(size[0], size[1], size[2]));
  }
};

/// Values on a regular grid.
template <class T>
class VoxelGrid {
 public:
  VoxelGrid() = default;
  explicit VoxelGrid(const GridShape& shape, T value = T{})
      : shape_(shape), values_(shape.count(), value) {}

  const GridShape& shape() const { return shape_; }
  T& at(int x, int y, int z) {
    assert(shape_.contains(x, y, z));
    return values_[shape_.index(x, y, z)];
  }
  const T& at(int x, int y, int z) const {
    assert(shape_.contains(x, y, z));
    return values_[shape_.index(x, y, z)];
  }
  std::vector<T>& values() { return values_; }
  const std::vector<T>& values() const { return values_; }

 private:
  GridShape shape_;
  std::vector<T> values_;
};

/// Trilinear value at a point of the grid's frame; outside the box of the centres the nearest
/// value.
template <class T>
double sample(const VoxelGrid<T>& grid, const Vector3& p_G) {
  const GridShape& shape = grid.shape();
  std::array<int, 3> low{};
  std::array<double, 3> part{};
  for (int axis = 0; axis < 3; ++axis) {
    const double last = shape.size[axis] - 1;
    const double at = std::clamp((p_G[axis] - shape.origin[axis]) / shape.spacing[axis], 0.0, last);
    low[axis] = std::min(static_cast<int>(at), std::max(0, shape.size[axis] - 2));
    part[axis] = at - low[axis];
  }
  double value = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> at = low;
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const bool upper = ((corner >> axis) & 1) != 0;
      weight *= upper ? part[axis] : 1.0 - part[axis];
      if (upper) ++at[axis];
    }
    if (weight > 0.0) value += weight * static_cast<double>(grid.at(at[0], at[1], at[2]));
  }
  return value;
}

}  // namespace osteomill::geometry
