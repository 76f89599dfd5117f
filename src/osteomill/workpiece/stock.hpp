// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "osteomill/base/large_vector.hpp"
#include "osteomill/bone/density.hpp"
#include "osteomill/geometry/voxel_grid.hpp"

namespace osteomill::workpiece {

using geometry::Vector3;

/// What a voxel is made of.
struct BoneMaterial {
  double density = 0.0;      ///< apparent density of the bone, kg/m³
  double force_scale = 0.0;  ///< strength relative to the bone that the force law was measured on
};

/// The material at a point, and how far the point is from the surface of the bone.
struct BoneSample {
  double signed_distance = 0.0;  ///< to the bone's surface, m; < 0 inside the bone
  BoneMaterial material;
};

/// The bone that is left, on a regular grid of cubes in the work frame W (axes of the grid = axes
/// of W).
///
/// Each voxel holds the share of it that is bone, its occupancy, in steps of 1/kFull: a voxel that
/// the surface cuts holds clamp(1/2 - d/spacing), d the signed distance of its centre. Integers
/// make the balance of volume exact. Density and force scale are indices into a palette.
///
/// Voxels are stored in tiles of kTile³ where there is bone at first; air costs four bytes a tile.
/// What lies together in space lies together in memory, whatever the size of the stock.
class Stock {
 public:
  using Occupancy = std::uint16_t;
  static constexpr Occupancy kFull = 1u << 15;

  /// Bone by a function of the point in W. Throws InvalidInput when no voxel has bone, when the
  /// grid is not of cubes, or when there are more than 65 535 different materials. The function
  /// is called from several threads.
  Stock(const geometry::GridShape& shape,
        const std::function<BoneSample(const Vector3& p_W)>& bone);

  const geometry::GridShape& shape() const { return shape_; }
  double spacing() const { return shape_.spacing.x(); }

  /// Share of the voxel that is bone, 0...1; 0 outside the grid.
  double occupancy(int x, int y, int z) const;
  /// Material of the bone in the voxel; all zero where there is none.
  BoneMaterial material(int x, int y, int z) const;

  double initial_volume() const;    ///< m³
  double remaining_volume() const;  ///< m³; initial minus removed to the last unit
  double remaining_mass() const;    ///< kg, summed anew
  std::int64_t remaining_units() const;
  std::int64_t initial_units() const { return initial_units_; }
  double unit_volume() const { return shape_.voxel_volume() / kFull; }  ///< m³ in one unit

  /// Smallest box of voxels with bone left, first and last index on each axis.
  struct Box {
    std::array<int, 3> first{0, 0, 0};
    std::array<int, 3> last{-1, -1, -1};  ///< below first when there is no bone left
  };
  Box bone_box() const;

  /// Voxels of all tiles that are stored.
  std::size_t stored_voxels() const;

  /// What milling changes; see base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    for (Slab& slab : slabs_) a(slab.occupancy, slab.row_units);
    a(layer_units_);
  }

 private:
  friend class Remover;  // walks tiles

  /// Edge of a tile, voxels: a row of it is eight lanes (lanes.hpp).
  static constexpr int kTile = 8;
  static constexpr int kTileLayer = kTile * kTile;
  static constexpr int kTileVoxels = kTileLayer * kTile;

  /// kTile layers. In a tile x runs fastest, then y.
  struct Slab {
    std::vector<std::uint32_t> tiles;  ///< the tile's number at (x, y), x fastest; 0: the empty one
    LargeVector<Occupancy> occupancy;
    LargeVector<std::uint16_t> material;  ///< index into palette_
    std::vector<std::int64_t> row_units;  ///< bone left in each row of tiles along x
  };
  static Slab build_slab(const geometry::GridShape& shape, int first_layer,
                         const std::function<BoneSample(const Vector3&)>& bone,
                         std::vector<BoneMaterial>& materials, std::int64_t* layer_units);

  /// Place of a voxel of the grid in its slab.
  std::size_t place(const Slab& slab, int x, int y, int z) const {
    const auto at = static_cast<std::size_t>((y / kTile) * tiles_along_x_ + x / kTile);
    return std::size_t{slab.tiles[at]} * kTileVoxels +
           static_cast<std::size_t>((z % kTile) * kTileLayer + (y % kTile) * kTile + x % kTile);
  }
  const Slab& slab(int z) const { return slabs_[static_cast<std::size_t>(z / kTile)]; }

  geometry::GridShape shape_;
  int tiles_along_x_ = 0;
  std::vector<Slab> slabs_;
  std::vector<std::int64_t> layer_units_;  ///< bone left in each z-layer
  std::vector<BoneMaterial> palette_;
  std::int64_t initial_units_ = 0;
};

/// How Hounsfield units become bone.
struct BoneFromCt {
  double threshold_hu = 300.0;  ///< bone from here; its iso-surface is the bone's surface
  bone::DensityFromCt density;  ///< HU to apparent density, not below that of the threshold
  bone::ForceDensityLaw force;  ///< density to force scale: an assumption, see there
};

/// The stock of cubes of this spacing from Hounsfield units on any regular grid in W (interpolated
/// linearly). A voxel holds clamp(1/2 + (HU - threshold) / (|grad HU| spacing)), which puts the
/// surface between voxels where the iso-surface is. Voxels in which bone and soft tissue mix take
/// the density of the bone beside them (within one voxel of the CT), so that the mixing isn't
/// counted twice. Throws InvalidInput when nothing reaches the threshold.
Stock stock_from_hounsfield(const geometry::VoxelGrid<float>& hu_W, double spacing,
                            const BoneFromCt& options);

/// The grid of cubes that covers the box from lower to upper with whole voxels, faces on `lower`.
geometry::GridShape cubes_over(const Vector3& lower, const Vector3& upper, double spacing);

}  // namespace osteomill::workpiece
