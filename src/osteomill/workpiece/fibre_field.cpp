// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/fibre_field.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

namespace {

using Tensor = Eigen::Matrix3d;

struct Sum {
  Tensor tensor = Tensor::Zero();
  double voxels = 0.0;
};

FibreField::Fibre fibre_of(const Tensor& tensor) {
  const Eigen::SelfAdjointEigenSolver<Tensor> axes(tensor);
  const Vector3 l = axes.eigenvalues();  // rising
  FibreField::Fibre fibre;
  if (!(l[1] + l[0] > 0.0)) return fibre;
  fibre.direction_W = axes.eigenvectors().col(0);
  fibre.anisotropy = (l[1] - std::max(0.0, l[0])) / (l[1] + std::max(0.0, l[0]));
  return fibre;
}

}  // namespace

FibreField::FibreField(const geometry::VoxelGrid<float>& image_W, const FibreOptions& options)
    : least_anisotropy_(options.least_anisotropy) {
  require_positive("stock.fibre_cell_mm", options.cell / units::mm, "mm");
  const geometry::GridShape& shape = image_W.shape();
  geometry::GridShape cells;
  cells.spacing = Vector3::Constant(options.cell);
  const Vector3 extent = shape.upper_corner() - shape.lower_corner();
  for (int axis = 0; axis < 3; ++axis)
    cells.size[static_cast<std::size_t>(axis)] =
        std::max(1, static_cast<int>(std::ceil(extent[axis] / options.cell - 1e-9)));
  cells.origin = shape.lower_corner() + 0.5 * cells.spacing;
  geometry::VoxelGrid<Sum> sums(cells);
  const auto cell_of = [&](const Vector3& p) {
    std::array<int, 3> at{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      at[a] = std::clamp(
          static_cast<int>(std::floor((p[axis] - shape.lower_corner()[axis]) / options.cell)), 0,
          cells.size[a] - 1);
    }
    return at;
  };
  // A voxel counts when all its neighbours are bone: the step at the surface is no texture.
  const auto bone = [&](int x, int y, int z) {
    return static_cast<double>(image_W.at(x, y, z)) >= options.threshold;
  };
  for (int z = 1; z + 1 < shape.size[2]; ++z)
    for (int y = 1; y + 1 < shape.size[1]; ++y)
      for (int x = 1; x + 1 < shape.size[0]; ++x) {
        if (!bone(x, y, z) || !bone(x - 1, y, z) || !bone(x + 1, y, z) || !bone(x, y - 1, z) ||
            !bone(x, y + 1, z) || !bone(x, y, z - 1) || !bone(x, y, z + 1))
          continue;
        const auto difference = [&](int dx, int dy, int dz) {
          return static_cast<double>(image_W.at(x + dx, y + dy, z + dz)) -
                 static_cast<double>(image_W.at(x - dx, y - dy, z - dz));
        };
        const Vector3 gradient =
            Vector3(difference(1, 0, 0), difference(0, 1, 0), difference(0, 0, 1))
                .cwiseQuotient(2.0 * shape.spacing);
        const auto at = cell_of(shape.centre(x, y, z));
        Sum& sum = sums.at(at[0], at[1], at[2]);
        sum.tensor += gradient * gradient.transpose();
        sum.voxels += 1.0;
      }

  cells_ = geometry::VoxelGrid<Fibre>(cells);
  Tensor orientation = Tensor::Zero();  // directions without sense add up as their dyads
  double with_bone = 0.0, directed = 0.0;
  for (int z = 0; z < cells.size[2]; ++z)
    for (int y = 0; y < cells.size[1]; ++y)
      for (int x = 0; x < cells.size[0]; ++x) {
        if (sums.at(x, y, z).voxels == 0.0) continue;
        Tensor tensor = Tensor::Zero();
        for (int dz = -1; dz <= 1; ++dz)
          for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
              if (cells.contains(x + dx, y + dy, z + dz))
                tensor += sums.at(x + dx, y + dy, z + dz).tensor;
        Fibre& fibre = cells_.at(x, y, z);
        fibre = fibre_of(tensor);
        with_bone += 1.0;
        if (fibre.anisotropy < least_anisotropy_) continue;
        directed += 1.0;
        orientation += sums.at(x, y, z).voxels * fibre.direction_W * fibre.direction_W.transpose();
      }
  if (directed == 0.0) return;
  share_ = directed / with_bone;
  const Eigen::SelfAdjointEigenSolver<Tensor> axes(orientation / orientation.trace());
  mean_.direction_W = axes.eigenvectors().col(2);
  // 1 when all cells agree, 0 when they point everywhere.
  mean_.anisotropy = 1.5 * (axes.eigenvalues()[2] - 1.0 / 3.0);
}

FibreField::Fibre FibreField::at(const Vector3& p_W) const {
  const geometry::GridShape& shape = cells_.shape();
  std::array<int, 3> at{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    at[a] = std::clamp(
        static_cast<int>(std::lround((p_W[axis] - shape.origin[axis]) / shape.spacing[axis])), 0,
        shape.size[a] - 1);
  }
  const Fibre& fibre = cells_.at(at[0], at[1], at[2]);
  return fibre.anisotropy >= least_anisotropy_ ? fibre : mean_;
}

}  // namespace osteomill::workpiece
