// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/path_maker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/cl_file.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/simulate_case.hpp"
#include "osteomill/io/simulate_result.hpp"
#include "osteomill/io/simulated_run.hpp"
#include "osteomill/io/text_file.hpp"
#include "osteomill/workpiece/swing.hpp"

namespace osteomill::io {
namespace {

/// A block of 20 × 15 × 6 mm that is to lose 2 mm; `more` is added to the case.
std::string face(const std::string& path, const std::string& more = "") {
  return "[stock]\nkind = \"block\"\nlower_mm = [0, 0, -6]\nupper_mm = [20, 15, 0]\n"
         "density_kg_per_m3 = 400\nspacing_mm = 0.5\n[path]\nfeed_mm_per_s = 10\n"
         "rapid_mm_per_s = 40\nspindle_speed_rpm = 12000\n" +
         path +
         "\n[cutter]\nshape = \"ball\"\ndiameter_mm = 6\nflutes = 2\nhelix_deg = 0\nrake_deg = 10\n"
         "cutting_length_mm = 12\n[bone]\nuse = \"bovine-cortical-high-speed\"\n" +
         "[controller]\nkind = \"constant\"\n[limits]\nforce_n = 30\nmax_feed_mm_per_s = 20\n" +
         more;
}

/// A path from a file has its feed and speed there.
std::string from_file(std::string text) {
  for (const std::string key : {"feed_mm_per_s = 10\n", "spindle_speed_rpm = 12000\n"})
    text.erase(text.find(key), key.size());
  return text;
}

std::string with_cylinder(std::string text) {
  const std::string ball = "shape = \"ball\"";
  return text.replace(text.find(ball), ball.size(), "shape = \"cylindrical\"");
}

nlohmann::ordered_json run(const std::string& text) {
  write_text_file(scratch("path_case.toml"), text);
  return document_of(run_simulations(read_simulate_cases(read_case(scratch("path_case.toml"), {}))),
                     0.0)
      .at("runs")[0];
}

std::string faults_of(const std::string& text) {
  try {
    run(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

const char* const kRaster =
    "kind = \"raster\"\ntop_mm = 0\nbottom_mm = -2\naxial_step_mm = 2\nradial_step_mm = 4\n";
const char* const kPlan = "[plan]\nkind = \"half-space\"\npoint_mm = [0, 0, -2]\n";

TEST(Paths, RasterOfTheBonesOwnShadowTakesThePlanAndNothingElse) {
  const auto result = run(with_cylinder(face(kRaster, kPlan)));
  const auto& plan = result.at("plan");
  EXPECT_NEAR(plan.at("planned_volume_mm3"), 600.0, 0.5);
  EXPECT_NEAR(plan.at("uncut_volume_mm3"), 0.0, 0.5);
  EXPECT_NEAR(plan.at("over_cut_volume_mm3"), 0.0, 0.5);
  EXPECT_EQ(result.at("stock").at("cancellous_mm3"), result.at("stock").at("volume_mm3"));
}

TEST(Paths, SkippedAirSavesTimeAndLeavesTheSameBone) {
  const std::string wide = std::string(kRaster) + "outline_grow_mm = 12\n";
  const auto slow = run(with_cylinder(face(wide, kPlan)));
  const auto fast = run(with_cylinder(face(wide + "skip_air = true\n", kPlan)));
  const double saved = fast.at("path").at("air_time_saved_s");
  EXPECT_GT(saved, 5.0);
  EXPECT_NEAR(slow.at("path").at("programmed_time_s").get<double>() -
                  fast.at("path").at("programmed_time_s").get<double>(),
              0.0, 1e-9)
      << "the time as programmed is that before";
  EXPECT_LT(fast.at("cutting_time_s").get<double>(), slow.at("cutting_time_s").get<double>());
  EXPECT_NEAR(
      fast.at("removed_volume_mm3").get<double>() / slow.at("removed_volume_mm3").get<double>(),
      1.0, 1e-6);
}

TEST(Paths, KeepAwayFromNoGoRegionsWhenTold) {
  const std::string vessel =
      "[[no_go]]\nname = \"vessel\"\nkind = \"ball\"\ncentre_mm = [20, 7, 0]\nradius_mm = 2\n"
      "margin_mm = 1\n";
  EXPECT_THAT(faults_of(with_cylinder(face(kRaster, vessel))), testing::HasSubstr("no_go.vessel"));
  const auto result =
      run(with_cylinder(face(std::string(kRaster) + "avoid_no_go = true\n", kPlan + vessel)));
  EXPECT_GE(result.at("path").at("no_go")[0].at("least_distance_mm").get<double>(), 1.0);
  EXPECT_GT(result.at("plan").at("uncut_volume_mm3").get<double>(), 10.0);
}

TEST(Paths, BallFinishesAFreeSurfaceWithRidgesBelowItsLimit) {
  // A cup of 30 mm radius, 3 mm deep in the block.
  const auto result =
      run(face("kind = \"surface\"\ntop_mm = 1\nbottom_mm = -4\nscallop_um = 100\nsample_mm = 0.5\n"
               "outline_x_mm = [-5, 25]\noutline_y_mm = [-5, 20]\n",
               "[plan]\nkind = \"ball\"\ncentre_mm = [10, 7.5, 27]\nradius_mm = 30\n"));
  const auto& plan = result.at("plan");
  const double planned = plan.at("planned_volume_mm3");
  EXPECT_GT(planned, 200.0);
  // Ridges of a parabola hold two thirds of their height: 0.07 mm on at most 20 × 15 mm.
  EXPECT_LT(plan.at("uncut_volume_mm3").get<double>(), 0.067 * 300.0);
  // The ball stays on its side but for chords of 0.5 mm on a radius of 30 mm: 1 µm, and the
  // shares of voxels on a curved border, h²/12R of their area.
  EXPECT_LT(plan.at("over_cut_volume_mm3").get<double>(), 0.02 * planned);
}

/// A path from CL data of these statements, after a start in air.
std::string cl(const std::string& statements, const char* name = "path.cl") {
  write_text_file(scratch(name),
                  "UNITS/MM\nMULTAX\nSPINDL/12000,RPM\nFEDRAT/600\n"
                  "FROM/-5,7,-2,0,0,1\n" +
                      statements + "FINI\n");
  return "kind = \"cl\"\nfile = \"" + scratch(name).string() + "\"\n";
}

TEST(Paths, OfTheGuideAndOfItsClDataMillTheSame) {
  const auto guide =
      run(face("kind = \"swing\"\npivot_mm = [-30, 7, -3]\nfirst_angle_deg = -10\n"
               "last_angle_deg = 10\nfirst_insertion_mm = 20\nlast_insertion_mm = 40\n"));
  workpiece::Swing swing;
  swing.pivot_W = {-30 * units::mm, 7 * units::mm, -3 * units::mm};
  swing.first_angle = -10 * units::deg;
  swing.last_angle = 10 * units::deg;
  swing.first_insertion = 20 * units::mm;
  swing.last_insertion = 40 * units::mm;
  const std::string text =
      write_cl(workpiece::swing_and_advance(swing, {10e-3, 12000 * units::rpm}));
  const std::string path = cl("");
  write_text_file(scratch("path.cl"), text);
  const auto by_cl = run(from_file(face(path)));
  const double volume = guide.at("removed_volume_mm3");
  EXPECT_GT(volume, 300.0);
  // What is written is rounded to 1 nm and 1e-9.
  EXPECT_NEAR(by_cl.at("removed_volume_mm3").get<double>(), volume, 1e-4 * volume);
  EXPECT_NEAR(by_cl.at("mean_force_n").get<double>(), guide.at("mean_force_n").get<double>(),
              1e-2 * guide.at("mean_force_n").get<double>());
}

TEST(Paths, RefuseWhatCannotBeCut) {
  const struct {
    std::string text;
    const char* said;
  } cases[] = {
      {face("kind = \"points\"\npoints = [{x_mm = 10, y_mm = 7, z_mm = -3}, {x_mm = 15, y_mm = 7, "
            "z_mm = -3}]\n"),
       "must start in air"},
      {face(std::string(kRaster) + "avoid_no_go = true\n",
            "[[no_go]]\nname = \"all\"\nkind = \"box\"\nlower_mm = [-5, -5, -3]\n"
            "upper_mm = [25, 20, 3]\n"),
       "nothing is left"},
      {face("kind = \"raster\"\ntop_mm = -7\nbottom_mm = -9\n"), "the stock has none"},
      {face("kind = \"surface\"\ntop_mm = 1\nbottom_mm = -4\noutline_x_mm = [0, 5]\n"
            "outline_y_mm = [0, 5]\n"),
       "needs a [plan]"},
      {face("kind = \"swing\"\npivot_mm = [5, 7, -3]\nfirst_angle_deg = -10\nlast_angle_deg = 10\n"
            "first_insertion_mm = 2\nlast_insertion_mm = 10\n"),
       "must start in air"},
      {from_file(face(cl("GOTO/25,7,-2,0,0,0\n", "none.cl"))), "0 long"},
      {from_file(face(cl("GOTO/25,7,-2,0,0,-1\n", "flip.cl"))), "flips over by 180.0 deg"},
      {from_file(face(cl("GOTO/25,7,-2\nGOTO/25,7,-2,0,0.6,0.8\n", "turn.cl"))), "in place"},
      {face(kRaster, "[access]\nheight_mm = 5\nx_mm = [10]\ny_mm = [7]\nradius_mm = 8\n"),
       "inside the window"},
      {face(
           "kind = \"raster\"\noutline = \"circle\"\noutline_x_mm = [1, 2]\noutline_y_mm = [1, 2]\n"
           "outline_radius_mm = 3\ntop_mm = 0\nbottom_mm = -1\n"),
       "1 for a circle"},
      {face("kind = \"one-way\"\nstart_mm = [-5, 0, -1]\nalong_mm = [30, 0, 0]\n"
            "step_over_mm = [0, 0, -1]\n"),
       "lead to one side"},
  };
  for (const auto& one : cases)
    EXPECT_THAT(faults_of(one.text), testing::HasSubstr(one.said)) << one.text;
}

}  // namespace
}  // namespace osteomill::io
