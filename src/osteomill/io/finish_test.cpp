// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/finish.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/geometry/mesh_check.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/simulated_run.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using units::mm;

/// A block of 24 × 16 mm, z from -5 to 0, voxels of 0.25 mm.
SimulatedRun run(const std::string& path, const std::string& cutter, const std::string& more) {
  write_text_file(
      scratch("finish_case.toml"),
      "[stock]\nkind = \"block\"\nlower_mm = [0, 0, -5]\nupper_mm = [24, 16, 0]\n"
      "density_kg_per_m3 = 400\nspacing_mm = 0.25\n[path]\nfeed_mm_per_s = 20\n"
      "rapid_mm_per_s = 20\nspindle_speed_rpm = 12000\n" +
          path + "\n[cutter]\nflutes = 2\nhelix_deg = 30\nrake_deg = 10\ncutting_length_mm = 12\n" +
          cutter +
          "[bone]\nuse = \"bovine-cortical-high-speed\"\n[controller]\nkind = \"constant\"\n"
          "[limits]\nmax_feed_mm_per_s = 20\n[finish]\n" +
          more);
  std::vector<SimulatedRun> runs =
      run_simulations(read_simulate_cases(read_case(scratch("finish_case.toml"), {})));
  return std::move(runs.front());
}

const std::string kRaster =
    "kind = \"raster\"\ntop_mm = 0\nbottom_mm = -1.1\naxial_step_mm = 2\nradial_step_mm = 4\n";
const std::string kCylinder = "shape = \"cylindrical\"\ndiameter_mm = 6\n";

TEST(Finish, OfALevelCutIsItsPlaneWhateverTheVoxels) {
  const SimulatedRun done =
      run(kRaster, kCylinder, "[plan]\nkind = \"half-space\"\npoint_mm = [0, 0, -1.1]\n");
  ASSERT_TRUE(done.finish);
  const study::FinishedSurface& s = done.finish->surface;
  // -1.1 mm is 0.4 of a voxel off its faces; occupancy is kept in steps of h/32768.
  EXPECT_NEAR(s.highest, 0.0, 1e-7);
  EXPECT_NEAR(s.lowest, 0.0, 1e-7);
  EXPECT_NEAR(s.fit->flatness, 0.0, 1e-7);
  EXPECT_NEAR(s.area, 24 * 16 * mm * mm, 0.06 * 24 * 16 * mm * mm);  // the rim is left out
  EXPECT_EQ(s.scallops.count, 0U);
  EXPECT_TRUE(geometry::flaws(done.finish->mesh).watertight());
  // Vertices of the cut lie on it, those of the rest have no deviation.
  std::size_t on = 0;
  for (std::size_t v = 0; v < done.finish->mesh.vertices.size(); ++v) {
    if (!std::isfinite(done.finish->mesh.values[v])) continue;
    ++on;
    EXPECT_NEAR(done.finish->mesh.vertices[v].z(), -1.1 * mm, 1e-6);
  }
  EXPECT_GT(on, 4000U);
}

TEST(Finish, OfAPocketIsItsFloorWithoutTheCornersOfItsWalls) {
  const SimulatedRun done =
      run("kind = \"contour\"\noutline = \"rectangle\"\noutline_x_mm = [4, 20]\n"
          "outline_y_mm = [3, 13]\ntop_mm = 0\nbottom_mm = -2.1\naxial_step_mm = 2.1\n"
          "radial_step_mm = 2\n",
          "shape = \"cylindrical\"\ndiameter_mm = 4\n",
          "[plan]\nkind = \"tray\"\nx_mm = [4, 20, 20, 4]\ny_mm = [3, 3, 13, 13]\n"
          "low_mm = -2.1\nhigh_mm = 1\n");
  ASSERT_TRUE(done.finish);
  const study::FinishedSurface& s = done.finish->surface;
  EXPECT_NEAR(s.highest, 0.0, 1e-7);
  EXPECT_NEAR(s.lowest, 0.0, 1e-7);
  EXPECT_GT(s.area, 14 * 8 * mm * mm);
}

TEST(Finish, AgainstATiltedPlanHasItsTwoAngles) {
  // Normal (cos a sin b, -sin a, cos a cos b) up to order: a = 0.8° about x, b = 0.5° about y.
  const double a = 0.8 * units::deg, b = 0.5 * units::deg;
  const SimulatedRun done =
      run(kRaster, kCylinder,
          "entry = [1, 0, 0]\nknee = \"right\"\n[plan]\nkind = \"half-space\"\npoint_mm = [12, 8, "
          "-1.1]\n"
          "normal = [" +
              std::to_string(-std::cos(a) * std::sin(b)) + ", " + std::to_string(std::sin(a)) +
              ", " + std::to_string(std::cos(a) * std::cos(b)) + "]\n");
  ASSERT_TRUE(done.finish);
  const auto& plane = done.finish->report.at("plane");
  // The cut is level, the plan leans: seen from the plan the cut leans the other way. The second
  // order of the angles is a b²/2, 3e-5 deg; the normal is written to 1e-6, 6e-5 deg.
  EXPECT_NEAR(std::abs(plane.at("varus_valgus_deg").get<double>()), 0.8, 2e-4);
  EXPECT_NEAR(std::abs(plane.at("flexion_extension_deg").get<double>()), 0.5, 2e-4);
  EXPECT_LT(plane.at("flatness_mm").get<double>(), 1e-3);
}

TEST(Finish, FindsTheRidgesOfABall) {
  const SimulatedRun done =
      run("kind = \"lines\"\ncount = 9\nstart_mm = [-4, 0, -1.5]\nalong_mm = [32, 0, 0]\n"
          "step_over_mm = [0, 2, 0]\nclearance_mm = 8\n",
          "shape = \"ball\"\ndiameter_mm = 6\n",
          "[plan]\nkind = \"half-space\"\npoint_mm = [0, 0, -1.5]\n");
  ASSERT_TRUE(done.finish);
  const study::FinishedSurface& s = done.finish->surface;
  const double expected = 3 * mm - std::sqrt(9.0 - 1.0) * mm;
  // Points lie within 2 % of a voxel of the grooves, valleys by the lowest cell (h/2)²/2r too high;
  // beside a ridge the voxel's normal is blurred by its neighbours on the other side.
  EXPECT_NEAR(s.scallops.mean, expected, 8e-6);
  EXPECT_NEAR(s.scallops.spacing, 2 * mm, 0.25 * mm);
  EXPECT_NEAR(done.finish->report.at("scallops").at("of_the_ball_um").get<double>(),
              expected / units::um, 1e-6 / units::um);
  // Nothing along the feed but the grain of the voxels.
  EXPECT_LT(s.along.rz, 2e-6);
  // Cells miss the crest by half of their width at most, where it falls by (s/2)/r.
  EXPECT_GT(s.across.rz, expected - 0.125 * mm / 3);
  EXPECT_LT(s.across.rz, expected);
}

TEST(Finish, RefusesToMeasureAgainstNothing) {
  try {
    run(kRaster, kCylinder, "");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("[plan]"));
  }
  EXPECT_THROW(run(kRaster, kCylinder, "[plan]\nkind = \"half-space\"\npoint_mm = [0, 0, -4.5]\n"),
               InvalidInput);
}

}  // namespace
}  // namespace osteomill::io
