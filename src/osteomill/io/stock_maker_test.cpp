// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/stock_maker.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/solid.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;
using geometry::Vector3;
using units::mm;

/// A ball of triangles: an octahedron with each face in n² parts, pushed out to the radius.
geometry::Mesh ball(double radius, int n) {
  geometry::Mesh mesh;
  for (int face = 0; face < 8; ++face) {
    const Vector3 sign((face & 1) != 0 ? -1 : 1, (face & 2) != 0 ? -1 : 1,
                       (face & 4) != 0 ? -1 : 1);
    const bool flipped = sign.prod() < 0.0;
    const auto corner = [&](int i, int j) {
      const Vector3 p = Vector3(n - i - j, i, j).cwiseProduct(sign).normalized() * radius;
      mesh.vertices.push_back(p.cast<float>());
      return static_cast<unsigned>(mesh.vertices.size() - 1);
    };
    const auto add = [&](std::array<int, 6> at) {
      unsigned a = corner(at[0], at[1]), b = corner(at[2], at[3]), c = corner(at[4], at[5]);
      if (flipped) std::swap(b, c);
      mesh.triangles.push_back({a, b, c});
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        add({i, j, i + 1, j, i, j + 1});
        if (i + j + 1 < n) add({i + 1, j, i + 1, j + 1, i, j + 1});
      }
  }
  return mesh;
}

constexpr double kRadius = 15.0 * mm;

StockCase mesh_case(const fs::path& file) {
  StockCase stock;
  stock.kind = StockKind::mesh;
  stock.file = file;
  stock.spacing = 0.75 * mm;  // 20 voxels a radius
  return stock;
}

fs::path ball_file() {
  const fs::path file = scratch("ball.stl");
  write_mesh(ball(kRadius, 24), file);
  return file;
}

std::string faults_of(const StockCase& stock) {
  try {
    make_stock(stock, {});
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(MeshStock, EnclosesTheVolumeOfItsSurface) {
  const double volume = geometry::volume(read_solid(ball_file()).mesh);
  const MadeStock made = make_stock(mesh_case(ball_file()), {});
  // At 20 voxels a radius the occupancy of a sphere is h²/4R² = 6e-4 too large (removal.md), and
  // trilinear values of its distance on half the spacing are h²/8R² = 3e-4 too small.
  EXPECT_NEAR(made.stock->initial_volume() / volume, 1.0, 1e-3);
  EXPECT_THAT(made.report.at("repair"), testing::HasSubstr("watertight"));
  EXPECT_THAT(made.report.at("unit").get<std::string>(), testing::HasSubstr("mm"));
}

TEST(MeshStock, IsTheSameBoneWhenItsFrameIsTurned) {
  StockCase stock = mesh_case(ball_file());
  const double upright = make_stock(stock, {}).stock->initial_volume();
  stock.z_axis = {0.3, -0.2, 0.9};
  stock.origin = {3 * mm, -2 * mm, 1 * mm};
  // Both are within the 1e-3 of the sphere's volume.
  EXPECT_NEAR(make_stock(stock, {}).stock->initial_volume() / upright, 1.0, 1e-3);
}

TEST(MeshStock, IsPaintedByDepthAndByDistanceFromTheJoint) {
  StockCase stock = mesh_case(ball_file());
  stock.painted.marrow_from = 20 * mm;
  stock.mesh.shaft = 20 * mm;
  stock.painted.shell_shaft = 3 * mm;
  const MadeStock made = make_stock(stock, {});
  const auto density = [&](double x, double z) {
    const geometry::GridShape& shape = made.stock->shape();
    const Vector3 at = (Vector3(x * mm, 0.0, z * mm) - shape.origin) / shape.spacing.x();
    return made.stock
        ->material(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())),
                   static_cast<int>(std::lround(at.z())))
        .density;
  };
  const workpiece::EpiphysisBone& bone = stock.painted;
  EXPECT_EQ(density(0, 14), bone.subchondral) << "faces the joint";
  EXPECT_LT(density(0, 11), bone.cancellous_joint);
  EXPECT_GT(density(0, 11), density(0, 2)) << "thins out away from the joint";
  EXPECT_EQ(density(0, -8), bone.marrow);
  EXPECT_EQ(density(0, -13.5), bone.cortical) << "faces away from the joint";
  EXPECT_EQ(density(14.5, 0), bone.cortical);
}

TEST(MeshStock, RefusesAnOpenSurface) {
  geometry::Mesh open = ball(kRadius, 24);
  // An eighth: a rim of 72 edges, more than are mended.
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 576);
  write_mesh(open, scratch("open.stl"));
  const std::string said = faults_of(mesh_case(scratch("open.stl")));
  EXPECT_THAT(said, testing::HasSubstr("must enclose a solid"));
  EXPECT_THAT(said, testing::HasSubstr("mesh editor"));
}

TEST(MeshStock, RefusesAnInsideOutSurfaceUnlessToldToTurnIt) {
  geometry::Mesh turned = ball(kRadius, 24);
  for (auto& triangle : turned.triangles) std::swap(triangle[1], triangle[2]);
  write_mesh(turned, scratch("turned.stl"));
  StockCase stock = mesh_case(scratch("turned.stl"));
  const std::string said = faults_of(stock);
  EXPECT_THAT(said, testing::HasSubstr("inside out"));
  EXPECT_THAT(said, testing::HasSubstr("turn_inside_out"));
  stock.mesh.turn_inside_out = true;
  EXPECT_GT(make_stock(stock, {}).stock->initial_volume(), 0.0);
}

TEST(Solid, KnowsItsDistanceWithinABandAndItsSideBeyond) {
  const Solid solid(ball(kRadius, 24), {.spacing = 0.5 * mm, .inside = 5 * mm, .outside = 4 * mm});
  // In the middle of an eighth the edges are sqrt(2)/24 sqrt(3) R = 1.53 mm long: the facets lie up
  // to e²/6R = 26 µm below the sphere; trilinear values of the curved field are h²/4R = 4 µm high.
  for (double r : {11.0, 13.2, 15.0, 17.3})
    EXPECT_NEAR(solid.distance(Vector3(0.48, -0.6, 0.64) * r * mm), (r - 15.0) * mm, 30e-6);
  EXPECT_LE(solid.distance(Vector3::Zero()), -5 * mm);
  EXPECT_GE(solid.distance(Vector3(60, 0, 0) * mm), 4 * mm);
}

TEST(Phantoms, AreStocksOfACase) {
  StockCase stock;
  stock.spacing = 1 * mm;
  stock.kind = StockKind::proximal_tibia;
  const MadeStock tibia = make_stock(stock, {});
  EXPECT_GT(tibia.report.at("cancellous_mm3").get<double>(), 1e4);
  EXPECT_GT(tibia.report.at("cortical_mm3").get<double>(), 1e3);
  stock.kind = StockKind::distal_femur;
  stock.z_axis = {0, 0, -1};
  const MadeStock femur = make_stock(stock, {});
  // The joint looks at the spindle: condyles are at the upper end.
  EXPECT_NEAR(femur.stock->shape().centre(0, 0, femur.stock->bone_box().last[2]).z(), 0.0, 2 * mm);
}

/// A CT of 20 × 20 × 20 mm: soft tissue, with a block of bone and perhaps a screw in it.
fs::path write_ct(const std::string& name, double slice_mm, bool screw) {
  const int slices = static_cast<int>(20.0 / slice_mm);
  std::string raw;
  for (int z = 0; z < slices; ++z)
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 20; ++x) {
        std::int16_t hu = x > 4 && x < 15 ? 1200 : -50;
        if (screw && x == 8 && y == 8) hu = 3071;
        char bytes[2];
        std::memcpy(bytes, &hu, 2);
        raw.append(bytes, 2);
      }
  write_text_file(scratch(name + ".raw"), raw);
  write_text_file(scratch(name + ".mhd"),
                  fmt::format("ObjectType = Image\nNDims = 3\nDimSize = 20 20 {}\n"
                              "ElementSpacing = 1 1 {}\nOffset = 0 0 0\nElementType = MET_SHORT\n"
                              "ElementByteOrderMSB = False\nElementDataFile = {}.raw\n",
                              slices, slice_mm, name));
  return scratch(name + ".mhd");
}

StockCase ct_case(const fs::path& file) {
  StockCase stock;
  stock.kind = StockKind::ct;
  stock.file = file;
  stock.lower = {2 * mm, 2 * mm, 2 * mm};
  stock.upper = {17 * mm, 17 * mm, 12 * mm};
  stock.spacing = 0.5 * mm;
  return stock;
}

TEST(CtStock, RefusesMetalInItsRegionUnlessItIsAccepted) {
  StockCase stock = ct_case(write_ct("screw", 1.0, true));
  EXPECT_THAT(faults_of(stock), testing::HasSubstr("metal"));
  stock.accept = {"metal"};
  EXPECT_EQ(faults_of(stock), "");
  stock.accept.clear();
  stock.lower = {10 * mm, 2 * mm, 2 * mm};
  EXPECT_EQ(faults_of(stock), "") << "the screw is outside the region";
}

TEST(CtStock, TellsItsCalibrationItsFibresAndWhatItsDensityLawIsWorth) {
  StockCase stock = ct_case(write_ct("plain", 1.0, false));
  stock.fibre_from_ct = true;
  const MadeStock made = make_stock(stock, {});
  EXPECT_THAT(made.report.at("density_calibration").get<std::string>(),
              testing::HasSubstr("published default"));
  // A slab of constant values has no texture: no cell has a direction of its own.
  EXPECT_EQ(made.report.at("fibre").at("share_of_cells"), 0.0);
  ASSERT_TRUE(made.fibre_at);
  const auto& law = made.report.at("density_law");
  // 131 + 1.067 · 1200 kg/m³ below 1900: a larger exponent makes it softer.
  EXPECT_LT(law.at("force_scale_with_exponent_2_5").get<double>(),
            law.at("force_scale_at_mean").get<double>());
  EXPECT_GT(law.at("force_scale_with_exponent_1_5").get<double>(),
            law.at("force_scale_at_mean").get<double>());
}

TEST(MeshStock, HasItsFibresAlongTheBoneUnlessTheCaseSaysOtherwise) {
  StockCase stock = mesh_case(ball_file());
  stock.z_axis = {0.0, -0.6, 0.8};
  stock.mesh.joint_axis = {0.0, 0.0, 1.0};
  EXPECT_LT((make_stock(stock, {}).fibre_W - Vector3(0.0, 0.6, 0.8)).norm(), 1e-12);
  stock.fibre = {2.0, 0.0, 0.0};
  EXPECT_LT((make_stock(stock, {}).fibre_W - Vector3::UnitX()).norm(), 1e-12);
}

TEST(CtStock, RefusesSlicesOfFiveMillimetresUnlessTheyAreAccepted) {
  StockCase stock = ct_case(write_ct("thick", 5.0, false));
  EXPECT_THAT(faults_of(stock), testing::HasSubstr("1.00 x 1.00 x 5.00 mm"));
  stock.accept = {"thick-slices"};
  EXPECT_EQ(faults_of(stock), "");
}

}  // namespace
}  // namespace osteomill::io
