// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/geometry/mesh_repair.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace osteomill::geometry {
namespace {

/// The holes of a cube are as wide as its sides.
const MeshRepairOptions kAnyWidth{.widest_hole = 1.0};

/// A cube of side 2, as an STL file has it: every triangle with corners of its own.
Mesh cube(const Eigen::Vector3f& at = Eigen::Vector3f::Zero(), float side = 2.0F) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const int end : {0, 1}) {
      const auto corner = [&](int u, int v) {
        Eigen::Vector3f p;
        p[axis] = static_cast<float>(end);
        p[(axis + 1) % 3] = static_cast<float>(u);
        p[(axis + 2) % 3] = static_cast<float>(v);
        mesh.vertices.push_back(at + side * p);
        return static_cast<unsigned>(mesh.vertices.size() - 1);
      };
      for (const bool second : {false, true}) {
        std::array<unsigned, 3> t{corner(0, 0), second ? corner(1, 1) : corner(1, 0),
                                  second ? corner(0, 1) : corner(1, 1)};
        if (end == 0) std::swap(t[1], t[2]);
        mesh.triangles.push_back(t);
      }
    }
  return mesh;
}

TEST(MeshRepair, MakesASolidOfLooseTriangles) {
  Mesh mesh = cube();
  const MeshRepair report = repair(mesh);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_EQ(report.merged_vertices, 28u);
  EXPECT_EQ(report.parts, 1u);
  EXPECT_TRUE(report.untouched());
  EXPECT_TRUE(report.left.watertight());
  EXPECT_DOUBLE_EQ(volume(mesh), 8.0);
  EXPECT_EQ(describe(report), "merged 28 equal vertices; 1 part, watertight");
}

TEST(MeshRepair, TurnsTrianglesAndWholeMeshesTheRightWayOut) {
  Mesh some = cube();
  for (const std::size_t t : {1u, 6u, 7u}) std::swap(some.triangles[t][0], some.triangles[t][1]);
  EXPECT_EQ(repair(some).turned_triangles, 3u);
  EXPECT_DOUBLE_EQ(volume(some), 8.0);

  Mesh all = cube();
  for (auto& triangle : all.triangles) std::swap(triangle[0], triangle[1]);
  const MeshRepair report = repair(all);
  EXPECT_TRUE(report.turned_all);
  EXPECT_EQ(report.turned_triangles, 0u);
  EXPECT_DOUBLE_EQ(volume(all), 8.0);
}

TEST(MeshRepair, ACavityStaysACavity) {
  for (const bool inside_out : {false, true}) {
    Mesh mesh = cube();
    Mesh hole = cube(Eigen::Vector3f(0.5F, 0.5F, 0.5F), 1.0F);
    for (auto& triangle : hole.triangles) std::swap(triangle[0], triangle[1]);
    const auto offset = static_cast<unsigned>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), hole.vertices.begin(), hole.vertices.end());
    for (auto triangle : hole.triangles) {
      for (unsigned& corner : triangle) corner += offset;
      mesh.triangles.push_back(triangle);
    }
    if (inside_out)
      for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
    EXPECT_EQ(repair(mesh).parts, 2u);
    EXPECT_DOUBLE_EQ(volume(mesh), 7.0);
  }
}

TEST(MeshRepair, ClosesSmallHolesAndNamesLargeOnes) {
  Mesh mesh = cube();
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2);
  Mesh kept = mesh;
  const MeshRepair report = repair(mesh, kAnyWidth);
  ASSERT_EQ(report.closed_holes.size(), 1u);
  EXPECT_THAT(describe(report), testing::HasSubstr("closed 1 hole: of 4 edges, 2000.00 mm wide, at "
                                                   "(0.0, 1000.0, 1000.0) mm; "));
  EXPECT_TRUE(report.left.watertight());
  EXPECT_DOUBLE_EQ(volume(mesh), 8.0);

  MeshRepairOptions none;
  none.largest_hole = 3;
  const MeshRepair open = repair(kept, none);
  EXPECT_TRUE(open.closed_holes.empty());
  EXPECT_EQ(open.left.open_edges, 4u);
  EXPECT_THAT(describe(open), testing::HasSubstr("not watertight: 4 open edges"));
  EXPECT_THAT(describe(open), testing::HasSubstr("too large to be closed: 1 hole: of 4 edges"));
}

TEST(MeshRepair, DoesNotMakeUpHalfABoneNorASolidOfLooseTriangles) {
  // 2 m of a diagonal of 3.5 m.
  Mesh half = cube();
  half.triangles.erase(half.triangles.begin(), half.triangles.begin() + 2);
  const MeshRepair wide = repair(half);
  EXPECT_TRUE(wide.closed_holes.empty());
  ASSERT_EQ(wide.open_holes.size(), 1u);
  EXPECT_DOUBLE_EQ(wide.open_holes[0].width, 2.0);
  EXPECT_EQ(wide.left.open_edges, 4u);

  Mesh loose = cube();
  for (std::size_t v = 0; v < loose.vertices.size(); ++v)
    loose.vertices[v].x() += 0.01F * static_cast<float>(v / 3);
  const MeshRepair report = repair(loose);
  EXPECT_FALSE(report.left.watertight());
  EXPECT_FALSE(report.turned_all);
  EXPECT_TRUE(report.closed_holes.empty());
}

TEST(MeshRepair, DropsFlatAndDoubleTrianglesAndWeldsWhatIsNear) {
  Mesh mesh = cube();
  mesh.triangles.push_back(mesh.triangles[3]);
  mesh.triangles.push_back({0, 0, 1});
  EXPECT_EQ(repair(mesh).dropped_triangles, 2u);

  Mesh apart = cube();
  for (std::size_t v = 0; v < apart.vertices.size(); ++v)
    apart.vertices[v].x() += 1e-5F * static_cast<float>(v % 3);
  Mesh unwelded = apart;
  EXPECT_FALSE(repair(unwelded, {.largest_hole = 0}).left.watertight());
  EXPECT_TRUE(repair(apart, {.weld = 1e-4, .largest_hole = 0}).left.watertight());
  EXPECT_EQ(apart.vertices.size(), 8u);
}

TEST(MeshRepair, ValuesGoWithTheirVertices) {
  Mesh mesh = cube();
  for (const Eigen::Vector3f& v : mesh.vertices) mesh.values.push_back(v.sum());
  mesh.triangles.pop_back();
  repair(mesh, kAnyWidth);
  ASSERT_EQ(mesh.values.size(), mesh.vertices.size());
  for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(mesh.values[v], mesh.vertices[v].sum());
}

}  // namespace
}  // namespace osteomill::geometry
