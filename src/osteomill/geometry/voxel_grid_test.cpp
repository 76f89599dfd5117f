// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/geometry/voxel_grid.hpp"

#include <gtest/gtest.h>

namespace osteomill::geometry {
namespace {

TEST(VoxelGrid, SamplesALinearFieldExactlyAndHoldsTheEdgeOutside) {
  GridShape shape;
  shape.size = {4, 3, 5};
  shape.spacing = Vector3(0.5, 0.25, 1.0);
  shape.origin = Vector3(-1.0, 2.0, 0.0);
  VoxelGrid<float> grid(shape);
  const auto field = [](const Vector3& p) { return 3.0 * p.x() - 2.0 * p.y() + p.z() + 0.5; };
  for (int z = 0; z < 5; ++z)
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 4; ++x)
        grid.at(x, y, z) = static_cast<float>(field(shape.centre(x, y, z)));
  const Vector3 inside(-0.3, 2.4, 2.7);
  // Values up to 10 in single precision: 10 * 2^-24 each, eight of them with weights that sum to
  // one.
  EXPECT_NEAR(sample(grid, inside), field(inside), 1e-6);
  EXPECT_NEAR(sample(grid, Vector3(9.0, 2.0, 4.0)), field(Vector3(0.5, 2.0, 4.0)), 1e-6);
}

TEST(GridShape, CornersEncloseTheVoxels) {
  GridShape shape;
  shape.size = {2, 3, 4};
  shape.spacing = Vector3(1.0, 2.0, 3.0);
  EXPECT_EQ(shape.upper_corner() - shape.lower_corner(), Vector3(2.0, 6.0, 12.0));
  EXPECT_EQ(shape.count(), 24u);
  EXPECT_EQ(shape.index(1, 2, 3), 23u);
}

}  // namespace
}  // namespace osteomill::geometry
