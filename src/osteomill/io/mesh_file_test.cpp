// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/mesh_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;
using units::mm;

/// A wedge of 40 × 30 × 20 mm.
geometry::Mesh wedge() {
  geometry::Mesh mesh;
  for (const auto& [x, y, z] :
       {std::array{0, 0, 0}, {40, 0, 0}, {0, 30, 0}, {0, 0, 20}, {40, 0, 20}, {0, 30, 20}})
    mesh.vertices.push_back(Eigen::Vector3d(x * mm, y * mm, z * mm).cast<float>());
  mesh.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3},
                    {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}};
  return mesh;
}

std::string obj(double scale, bool whole = true) {
  std::string text;
  for (const Eigen::Vector3f& v : wedge().vertices)
    text += fmt::format("v {} {} {}\n", v.x() / mm * scale, v.y() / mm * scale, v.z() / mm * scale);
  // A polygon of four corners among them.
  text += "f 1 3 2\nf 4 5 6\nf 1 2 5 4\nf 2 3 6 5\n";
  return whole ? text + "f 3 1 4 6\n" : text;
}

TEST(MeshFile, ComesBackFromEachFormat) {
  write_text_file(scratch("wedge.obj"), obj(1.0));
  write_mesh(wedge(), scratch("wedge.stl"));
  geometry::Mesh valued = wedge();
  valued.values.assign(valued.vertices.size(), 1.0F);
  write_mesh(valued, scratch("wedge.ply"));
  for (const char* file : {"wedge.obj", "wedge.stl", "wedge.ply"}) {
    SCOPED_TRACE(file);
    const MeshFile read = read_solid(scratch(file));
    EXPECT_EQ(read.mesh.vertices.size(), 6u);
    EXPECT_EQ(read.mesh.triangles.size(), 8u);
    EXPECT_TRUE(read.repair.untouched());
    // Single precision of 0.04 m in three factors.
    EXPECT_NEAR(geometry::volume(read.mesh), 12000.0 * units::mm3, 1e-6 * 12000.0 * units::mm3);
    EXPECT_EQ(read.unit, LengthUnit::millimetre);
    EXPECT_THAT(read.description, testing::HasSubstr("guessed"));
    EXPECT_THAT(read.description, testing::HasSubstr("40.0 × 30.0 × 20.0 mm"));
  }
}

TEST(MeshFile, UnitsAreGuessedFromTheSizeOrGiven) {
  write_text_file(scratch("metres.obj"), obj(1e-3));
  write_text_file(scratch("large.obj"), obj(1e-1));
  write_text_file(scratch("speck.obj"), obj(1e-5));
  EXPECT_EQ(read_mesh(scratch("metres.obj")).unit, LengthUnit::metre);
  EXPECT_NEAR(geometry::volume(read_mesh(scratch("metres.obj")).mesh), 12000.0 * units::mm3, 1e-10);
  MeshOptions centimetres;
  centimetres.unit = LengthUnit::centimetre;
  EXPECT_NEAR(geometry::volume(read_mesh(scratch("large.obj"), centimetres).mesh),
              12000.0 * units::mm3, 1e-10);
  EXPECT_THROW(read_mesh(scratch("speck.obj")), InvalidInput);
  try {
    read_mesh(scratch("large.obj"));
    ADD_FAILURE() << "4 mm is a small bone, 4 cm is a bone";
  } catch (const InvalidInput& fault) {
    EXPECT_THAT(fault.what(), testing::HasSubstr("4 mm or 4 cm across"));
  }
}

TEST(MeshFile, AnOpenSurfaceIsMendedOrRefusedAsASolid) {
  write_text_file(scratch("open.obj"), obj(1.0, false));
  const MeshFile mended = read_solid(scratch("open.obj"), {.widest_hole = 1.0});
  EXPECT_EQ(mended.repair.closed_holes.size(), 1u);
  MeshOptions strict;
  strict.largest_hole = 0;
  EXPECT_FALSE(read_mesh(scratch("open.obj"), strict).repair.left.watertight());
  try {
    read_solid(scratch("open.obj"), strict);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("4 open edges"));
  }
}

TEST(MeshFile, RefusesWhatIsNoMesh) {
  EXPECT_THROW(read_mesh(scratch("absent.stl")), InvalidInput);
  for (const char* name : {"text.stl", "text.ply", "text.obj", "text.txt"}) {
    write_text_file(scratch(name), "not a mesh");
    EXPECT_THROW(read_mesh(scratch(name)), InvalidInput) << name;
  }
  for (const char* name : {"cut.stl", "cut.ply"}) {
    write_mesh(wedge(), scratch(name));
    const std::string bytes = read_text_file(scratch(name));
    for (const double share : {0.1, 0.5, 0.9}) {
      write_text_file(
          scratch(name),
          bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
      EXPECT_THROW(read_mesh(scratch(name)), InvalidInput) << name << share;
    }
  }
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
      "property float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n";
  write_text_file(scratch("ascii.ply"), header + "0 0 0\n9 0 0\n0 9 0\n3 0 1 2");
  EXPECT_EQ(read_mesh(scratch("ascii.ply"), {LengthUnit::millimetre, 0}).mesh.triangles.size(), 1u);
  write_text_file(scratch("ascii.ply"), header + "0 0 0\n9 0 0\n");
  EXPECT_THROW(read_mesh(scratch("ascii.ply")), InvalidInput);
  write_text_file(scratch("nan.obj"), "v 0 0 nan\nv 9 0 0\nv 0 9 0\nf 1 2 3\n");
  EXPECT_THROW(read_mesh(scratch("nan.obj")), InvalidInput);
  write_text_file(scratch("nowhere.obj"), "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 7\n");
  EXPECT_THROW(read_mesh(scratch("nowhere.obj")), InvalidInput);
  EXPECT_THROW(write_mesh(wedge(), scratch("wedge.obj")), InvalidInput);
}

}  // namespace
}  // namespace osteomill::io
