// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/fibre_field.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;

geometry::VoxelGrid<float> image(const std::function<double(const Vector3&)>& value) {
  geometry::GridShape shape;
  shape.size = {60, 60, 60};
  shape.spacing = Vector3::Constant(0.5 * mm);
  geometry::VoxelGrid<float> grid(shape);
  for (int z = 0; z < 60; ++z)
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 60; ++x)
        grid.at(x, y, z) = static_cast<float>(value(shape.centre(x, y, z)));
  return grid;
}

/// Rods along a direction, 4 mm apart.
geometry::VoxelGrid<float> rods(const Vector3& along) {
  const Vector3 u = along.unitOrthogonal(), v = along.cross(u);
  return image([&](const Vector3& p) {
    const double k = 2 * M_PI / (4 * mm);
    return 1000.0 + 300.0 * (std::cos(k * u.dot(p)) + std::cos(k * v.dot(p)));
  });
}

TEST(FibreField, FindsTheDirectionOfRods) {
  for (const Vector3& along : {Vector3(0, 0, 1), Vector3(1, 2, -0.5), Vector3(-0.3, 1, 0.8)}) {
    const Vector3 d = along.normalized();
    const FibreField field(rods(d), {});
    const FibreField::Fibre fibre = field.at(Vector3(15, 15, 15) * mm);
    // Central differences over k h = 2 pi / 8 shrink the part of a slope along an axis of the grid
    // by up to (k h)² / 6 = 10 %: directions turn by up to half of that, 2.9°.
    EXPECT_GT(std::abs(fibre.direction_W.dot(d)), std::cos(2.9 * units::deg));
    EXPECT_GT(fibre.anisotropy, 0.9);
    EXPECT_GT(std::abs(field.mean().direction_W.dot(d)), std::cos(2.9 * units::deg));
    EXPECT_EQ(field.share(), 1.0);
  }
}

TEST(FibreField, HasNoDirectionInNoise) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(1000.0, 50.0);
  const FibreField field(image([&](const Vector3&) { return noise(random); }), {});
  // Some 10 000 voxels a cell with its neighbours: eigenvalues alike to a few per cent.
  EXPECT_LT(field.at(Vector3(15, 15, 15) * mm).anisotropy, 0.1);
  EXPECT_EQ(field.share(), 0.0);
}

TEST(FibreField, OfATubeRunsAlongIt) {
  // A cortical tube whose density falls from the middle of its wall to both sides.
  const FibreField field(image([](const Vector3& p) {
                           const double r = std::hypot(p.x() - 15 * mm, p.y() - 15 * mm);
                           const double depth = (r - 10 * mm) / (4 * mm);
                           return 1500.0 * std::exp(-depth * depth);
                         }),
                         {});
  const FibreField::Fibre fibre = field.at(Vector3(15, 25, 15) * mm);
  EXPECT_GT(std::abs(fibre.direction_W.z()), std::cos(1 * units::deg));
}

TEST(FibreField, TakesTheMeanWhereACellHasNoBone) {
  const Vector3 d(0, 0, 1);
  geometry::VoxelGrid<float> half = rods(d);
  for (int z = 0; z < 60; ++z)
    for (int y = 0; y < 60; ++y)
      for (int x = 30; x < 60; ++x) half.at(x, y, z) = -1000.0F;
  const FibreField field(half, {});
  EXPECT_GT(std::abs(field.at(Vector3(28, 15, 15) * mm).direction_W.dot(d)), 0.999);
}

}  // namespace
}  // namespace osteomill::workpiece
