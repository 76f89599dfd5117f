// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/geometry/mesh_check.hpp"

#include <gtest/gtest.h>

namespace osteomill::geometry {
namespace {

/// A corner of a cube of side 2, far from the origin.
Mesh tetrahedron() {
  const Eigen::Vector3f at(100.0F, -50.0F, 20.0F);
  Mesh mesh;
  mesh.vertices = {at, at + Eigen::Vector3f(2, 0, 0), at + Eigen::Vector3f(0, 2, 0),
                   at + Eigen::Vector3f(0, 0, 2)};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TEST(MeshCheck, ASolidHasItsVolumeAndAreaAndNoFlaws) {
  EXPECT_NEAR(volume(tetrahedron()), 8.0 / 6.0, 1e-12);
  // Three right triangles, and an equilateral one of side 2√2.
  EXPECT_NEAR(area(tetrahedron()), 3 * 2.0 + std::sqrt(3.0) / 4.0 * 8.0, 1e-12);
  EXPECT_TRUE(flaws(tetrahedron()).watertight());
  EXPECT_EQ(flaws(tetrahedron()).flat_triangles, 0u);
}

TEST(MeshCheck, CountsEachKindOfFlaw) {
  Mesh inside_out = tetrahedron();
  for (auto& triangle : inside_out.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_TRUE(flaws(inside_out).watertight());
  EXPECT_LT(volume(inside_out), 0.0);

  Mesh open = tetrahedron();
  open.triangles.pop_back();
  EXPECT_EQ(flaws(open).open_edges, 3u);

  Mesh turned = tetrahedron();
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_EQ(flaws(turned).turned_edges, 3u);

  Mesh crowded = tetrahedron();
  crowded.triangles.push_back({0, 1, 3});
  EXPECT_EQ(flaws(crowded).crowded_edges, 3u);

  Mesh flat = tetrahedron();
  flat.triangles.push_back({0, 1, 1});
  EXPECT_EQ(flaws(flat).flat_triangles, 1u);
  EXPECT_FALSE(flaws(flat).watertight());
}

}  // namespace
}  // namespace osteomill::geometry
