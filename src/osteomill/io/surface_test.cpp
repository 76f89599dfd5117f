// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/geometry/mesh_check.hpp"

namespace osteomill::io {
namespace {

using geometry::GridShape;
using geometry::Vector3;
using geometry::VoxelGrid;
using units::mm;

/// A ball of 5 mm, with the part of the voxels that its surface cuts.
VoxelGrid<float> ball(double spacing) {
  GridShape shape;
  const int half = static_cast<int>(std::ceil(6.0 * mm / spacing));
  shape.size = {2 * half + 1, 2 * half + 1, 2 * half + 1};
  shape.spacing = Vector3::Constant(spacing);
  shape.origin = Vector3(10.0, 20.0, -5.0) * mm - Vector3::Constant(half * spacing);
  VoxelGrid<float> grid(shape);
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x) {
        const double d = (shape.centre(x, y, z) - Vector3(10.0, 20.0, -5.0) * mm).norm() - 5.0 * mm;
        grid.at(x, y, z) = static_cast<float>(std::clamp(0.5 - d / spacing, 0.0, 1.0));
      }
  return grid;
}

double occupied(const VoxelGrid<float>& grid) {
  return std::accumulate(grid.values().begin(), grid.values().end(), 0.0) *
         grid.shape().voxel_volume();
}

TEST(Surface, IsWatertightAndEnclosesTheOccupiedVolume) {
  for (const double simplify : {0.0, 0.1}) {
    const VoxelGrid<float> grid = ball(0.2 * mm);
    const geometry::Mesh mesh = surface_of(grid, {simplify, 1});
    EXPECT_TRUE(geometry::flaws(mesh).watertight());
    // A vertex is the mean of the crossings in its cell of size h and lies h²/2R inside the arc: a
    // share of 3h²/2R² of the volume, 0.24 % here. Simplified, the chords are some voxels long.
    EXPECT_NEAR(geometry::volume(mesh) / occupied(grid), 1.0, simplify > 0.0 ? 0.01 : 0.0025);
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      const double radius = (vertex.cast<double>() - Vector3(10.0, 20.0, -5.0) * mm).norm();
      // The same h²/2R = 0.004 mm and the error of the occupancy; simplified, half a voxel.
      EXPECT_NEAR(radius, 5.0 * mm, simplify > 0.0 ? 0.1 * mm : 0.02 * mm);
    }
  }
}

TEST(Surface, SimplifyingAndCoarseningMakeItSmaller) {
  const VoxelGrid<float> grid = ball(0.2 * mm);
  const std::size_t full = surface_of(grid, {0.0, 1}).triangles.size();
  EXPECT_LT(surface_of(grid, {0.5, 1}).triangles.size(), full / 2);
  const geometry::Mesh coarse = surface_of(grid, {0.0, 2});
  EXPECT_LT(coarse.triangles.size(), full / 3);
  EXPECT_TRUE(geometry::flaws(coarse).watertight());
  // 3h²/2R², as above, with h = 0.4 mm.
  EXPECT_NEAR(geometry::volume(coarse) / occupied(grid), 1.0, 0.01);
}

TEST(Surface, BoneAtTheBorderOfTheGridIsClosedAtTheFacesOfItsVoxels) {
  GridShape shape;
  shape.size = {12, 9, 7};
  shape.spacing = Vector3::Constant(0.5 * mm);
  const VoxelGrid<float> full(shape, 1.0F);
  const geometry::Mesh mesh = surface_of(full, {0.0, 1});
  EXPECT_TRUE(geometry::flaws(mesh).watertight());
  Eigen::Vector3f low = mesh.vertices.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& v : mesh.vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  // Single precision of a few mm.
  EXPECT_LT((low.cast<double>() - shape.lower_corner()).norm(), 1e-8);
  EXPECT_LT((high.cast<double>() - shape.upper_corner()).norm(), 1e-8);
  // Edges and corners are cut off over half a voxel at most.
  EXPECT_NEAR(geometry::volume(mesh) / (shape.voxel_volume() * 12 * 9 * 7), 1.0, 0.05);
}

TEST(Surface, CutOpenIsStillASolid) {
  const VoxelGrid<float> grid = ball(0.2 * mm);
  SurfaceOptions options{0.0, 1};
  options.cut = CutPlane{Vector3(10.0, 20.0, -5.0) * mm, Vector3(1.0, 2.0, 0.5)};
  const geometry::Mesh half = surface_of(grid, options);
  EXPECT_TRUE(geometry::flaws(half).watertight());
  // The plane goes through the centre; what 3h²/2R² takes from the ball and half a voxel's rounding
  // of the new edge, 2 pi R h²/8 of 2/3 pi R³, stay below half a percent.
  EXPECT_NEAR(geometry::volume(half) / occupied(grid), 0.5, 0.005);
}

TEST(Surface, TakesTheColourOfAField) {
  geometry::Mesh mesh = surface_of(ball(0.5 * mm), {});
  GridShape shape;
  shape.size = {2, 2, 2};
  shape.spacing = Vector3::Constant(40.0 * mm);
  shape.origin = Vector3(-10.0, 0.0, -25.0) * mm;
  VoxelGrid<float> field(shape);
  for (int i = 0; i < 8; ++i) {
    const Vector3 p = shape.centre(i & 1, (i >> 1) & 1, i >> 2);
    field.values()[static_cast<std::size_t>(i)] = static_cast<float>(1000.0 * p.x() + p.z());
  }
  colour_by(mesh, field);
  ASSERT_EQ(mesh.values.size(), mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    // 30 in single precision.
    EXPECT_NEAR(mesh.values[v], 1000.0F * mesh.vertices[v].x() + mesh.vertices[v].z(), 1e-4F);
}

TEST(Surface, OfAStockCarriesTheDensityOfTheBoneBelowIt) {
  GridShape shape;
  shape.size = {20, 20, 20};
  shape.spacing = Vector3::Constant(0.5 * mm);
  const workpiece::Stock stock(shape, [](const Vector3& p) {
    return workpiece::BoneSample{(p - Vector3::Constant(5.0 * mm)).norm() - 4.0 * mm,
                                 {p.z() > 5.0 * mm ? 1900.0 : 600.0, 1.0}};
  });
  const geometry::Mesh mesh = surface_of(stock, {0.0, 1});
  EXPECT_TRUE(geometry::flaws(mesh).watertight());
  EXPECT_NEAR(geometry::volume(mesh) / stock.remaining_volume(), 1.0, 0.025);  // 3h²/2R²
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double z = mesh.vertices[v].z();
    if (std::abs(z - 5.0 * mm) < 1.0 * mm) continue;
    EXPECT_NEAR(mesh.values[v], z > 5.0 * mm ? 1900.0 : 600.0, 1e-3);
  }
}

TEST(Surface, OfNothingIsEmptyAndBadOptionsAreNamed) {
  GridShape shape;
  shape.size = {4, 4, 4};
  EXPECT_TRUE(surface_of(VoxelGrid<float>(shape), {}).triangles.empty());
  EXPECT_THROW(surface_of(VoxelGrid<float>(shape), {2.0, 1}), InvalidInput);
  EXPECT_THROW(surface_of(VoxelGrid<float>(shape), {0.0, 0}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::io
