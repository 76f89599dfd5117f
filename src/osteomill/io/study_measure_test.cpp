// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/study_measure.hpp"

#include <gmock/gmock.h>

#include <filesystem>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::io {
namespace {

using ::testing::HasSubstr;
using units::deg;

const char* const kHeading =
    "cut_id,cut_kind,side,guide_nx,guide_ny,guide_nz,guide_ex,guide_ey,guide_ez,cut_nx,cut_ny,cut_"
    "nz\n";

std::string cell(const MeasuredCuts& measured, size_t row, const std::string& column) {
  const auto& names = measured.table.columns;
  const auto at = std::find(names.begin(), names.end(), column) - names.begin();
  return measured.table.rows.at(row).cells.at(static_cast<size_t>(at));
}

TEST(MeasuredCuts, TellVarusAlikeOnBothSides) {
  // Two degrees more removed medially: a right tibia leans to the patient's left, a left one right.
  const std::string text = std::string(kHeading) +
                           "1,proximal-tibia,right,0,0,1,1,0,0,0,0.034899,0.999391\n"
                           "2,proximal-tibia,left,0,0,1,1,0,0,0,-0.034899,0.999391\n";
  const MeasuredCuts measured = measure_cuts(parse_csv(text, "m.csv"), std::nullopt);
  // Four decimals are written; the normals have six.
  EXPECT_NEAR(std::stod(cell(measured, 0, "varus_valgus_deg")), 2.0, 2e-4);
  EXPECT_NEAR(std::stod(cell(measured, 1, "varus_valgus_deg")), 2.0, 2e-4);
  EXPECT_EQ(cell(measured, 0, "guide_movement_varus_valgus_deg"), "");
  EXPECT_EQ(cell(measured, 1, "cut_id"), "2");
}

TEST(MeasuredCuts, ReadQuaternionsAsNormals) {
  // Turned by 3 deg about the y axis: the normal leans to the entry, bone is left at the far edge.
  const std::string text =
      "cut_kind,side,guide_qw,guide_qx,guide_qy,guide_qz,cut_qw,cut_qx,cut_qy,cut_qz\n"
      "distal-femur,left,1,0,0,0,0.99965732,0,0.02617695,0\n";
  const MeasuredCuts measured = measure_cuts(parse_csv(text, "m.csv"), std::nullopt);
  EXPECT_NEAR(std::stod(cell(measured, 0, "flexion_extension_deg")), 3.0, 2e-4);
}

TEST(MeasuredCuts, TakePlanesFromPointsWithFlatnessAndPrecision) {
  const std::filesystem::path folder =
      std::filesystem::path(OSTEOMILL_SOURCE_DIR) / "examples/study";
  const MeasuredCuts measured = measure_cuts(read_csv(folder / "tracker_guides.csv"),
                                             read_csv(folder / "tracker_points.csv"));
  ASSERT_EQ(measured.table.rows.size(), 6u);
  for (size_t r = 0; r < 6; ++r) {
    // synthesise.py: noise of 80 um on 40 points; an SD of 34 degrees of freedom is known to 12 %.
    EXPECT_NEAR(std::stod(cell(measured, r, "roughness_um")), 80.0, 30.0);
    EXPECT_GT(std::stod(cell(measured, r, "flatness_um")), 200.0);
    EXPECT_LT(std::stod(cell(measured, r, "tilt_sd_deg")), 0.1);
  }
}

TEST(MeasuredPrecision, OfThirtySyntheticPlacementsHoldsWhatWasPutIn) {
  const MeasuredPrecision p = measure_precision(read_csv(
      std::filesystem::path(OSTEOMILL_SOURCE_DIR) / "examples/study/tracker_placements.csv"));
  EXPECT_EQ(p.varus_valgus.placements, 30);
  // synthesise.py: 0.075 and 0.125 deg.
  EXPECT_GT(p.varus_valgus.upper, 0.075 * deg);
  EXPECT_GT(p.flexion_extension.upper, 0.125 * deg);
  EXPECT_NEAR(p.varus_valgus.sd / (0.075 * deg), 1.0, 0.4);
}

struct Bad {
  std::string text;
  const char* says;
};

TEST(MeasuredCuts, NameEveryFaultOfEveryRow) {
  const std::string heading = kHeading;
  const std::vector<Bad> table = {
      {heading + "1,tibia,right,0,0,1,1,0,0,0,0,1\n", "m.csv:2: cut_kind = tibia: is no cut"},
      {heading + "1,distal-femur,r,0,0,1,1,0,0,0,0,1\n", "side = r: must be left or right"},
      {heading + "1,distal-femur,left,0,0,1,0,0,2,0,0,1\n", "parallel"},
      {heading + "1,distal-femur,left,0,0,1,1,0,0,0,x,1\n", "cut_ny = x: must be a number"},
      {heading + "1,distal-femur,left,0,0,1,1,0,0,,,\n", "has neither an orientation nor points"},
      {heading + "1,distal-femur,left,0,0,1,1,0,0,0,0,0\n", "zero or not finite"},
      {"cut_kind,side,guide_nx\ndistal-femur,left,0\n", "its orientation is missing"},
      {"side,guide_qw,guide_qx,guide_qy,guide_qz\nleft,1,0,0,0\n", "cut_kind: no such column"},
      {"cut_kind,side,guide_qw,guide_qx,guide_qy,guide_qz,cut_nx,cut_ny,cut_nz\n"
       "distal-femur,left,2,0,0,0,0,0,1\n",
       "length 2.0000"},
  };
  for (const Bad& bad : table) {
    try {
      measure_cuts(parse_csv(bad.text, "m.csv"), std::nullopt);
      ADD_FAILURE() << bad.text;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr(bad.says));
    }
  }
}

TEST(MeasuredCuts, WarnOfATurnedFrame) {
  const std::string text =
      std::string(kHeading) + "1,distal-femur,left,0,0,1,1,0,0,0.9,0,0.43589\n";
  EXPECT_THAT(measure_cuts(parse_csv(text, "m.csv"), std::nullopt).warnings.at(0),
              HasSubstr("turned or mirrored"));
}

}  // namespace
}  // namespace osteomill::io
