// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/geometry/voxel_grid.hpp"

namespace osteomill::workpiece {

using geometry::Vector3;

struct FibreOptions {
  double cell = 4e-3;             ///< edge of the cells that have one direction each, m
  double threshold = 300.0;       ///< voxels from here count, in the unit of the image
  double least_anisotropy = 0.2;  ///< below, a cell has no direction of its own
};

/// The direction along which an image of bone changes least, cell by cell: that of osteons and
/// trabeculae as far as a CT shows them, along the shaft in a cortical tube.
///
/// Structure tensor J = sum of grad I grad Iᵀ over the voxels of a cell and its 26 neighbours that
/// are bone; the direction is the eigenvector of its least eigenvalue l3, the anisotropy
/// (l2 - l3) / (l2 + l3): 1 for fibres, 0 where two directions are alike. The cutting laws take the
/// angle to the fibres only, so the direction has no sense.
class FibreField {
 public:
  FibreField(const geometry::VoxelGrid<float>& image_W, const FibreOptions& options);

  struct Fibre {
    Vector3 direction_W = Vector3::UnitX();
    double anisotropy = 0.0;  ///< 0 where there is no bone
  };
  /// Of the cell that the point lies in; the mean direction where the cell has none of its own.
  Fibre at(const Vector3& p_W) const;
  /// Over all cells with a direction, weighted by their voxels.
  const Fibre& mean() const { return mean_; }
  /// Share of the cells with bone that have a direction of their own.
  double share() const { return share_; }

 private:
  geometry::VoxelGrid<Fibre> cells_;
  Fibre mean_;
  double share_ = 0.0;
  double least_anisotropy_ = 0.0;
};

}  // namespace osteomill::workpiece
