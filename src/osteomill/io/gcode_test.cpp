// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/gcode.hpp"

#include <gmock/gmock.h>

#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using workpiece::MoveKind;
using workpiece::ToolPath;
constexpr double mm = units::mm;

const std::string kHead = "G21 G90 G17\nM3 S6000 F300\nG0 X0 Y0 Z5\n";

TEST(Gcode, ReadsModalMotionUnitsAndNumbersLines) {
  const ToolPath path = read_gcode(
      "%\n"
      "(a slot) N10 G21 G90\n"
      "n20 m3 s6000 f 300 ; spindle\n"
      "G0 X0 Y0\n"
      "Z5\n"
      "G1 Z-1.5\n"
      "X10.\n"
      "G91 Y+2 F600\n"
      "G90 G20 X1\n"
      "M5\nM30\nX99 nonsense after the end\n");
  ASSERT_EQ(path.moves().size(), 4u);
  EXPECT_EQ(path.moves()[0].line, 6);
  EXPECT_EQ(path.moves()[0].kind, MoveKind::cut);
  EXPECT_EQ(path.moves()[0].points_W[0], Vector3(0.0, 0.0, 5 * mm));
  EXPECT_DOUBLE_EQ(path.moves()[0].feed_rate, 5 * mm);
  EXPECT_DOUBLE_EQ(path.moves()[0].spindle_speed, 6000 * units::rpm);
  EXPECT_DOUBLE_EQ(path.moves()[2].feed_rate, 10 * mm);
  // Sums of a few decimal fractions: rounding only.
  EXPECT_LT((path.moves()[2].points_W[1] - Vector3(10 * mm, 2 * mm, -1.5 * mm)).norm(), 1e-15);
  EXPECT_LT((path.moves()[3].points_W[1] - Vector3(25.4 * mm, 2 * mm, -1.5 * mm)).norm(), 1e-15);
  EXPECT_NEAR(path.length(), (6.5 + 10 + 2 + 15.4) * mm, 1e-12);
}

TEST(Gcode, ARapidBetweenCutsIsARapid) {
  const ToolPath path = read_gcode(kHead + "G1 Z0\nG0 Z5\nG0 X3\nG1 Z0\n");
  ASSERT_EQ(path.moves().size(), 4u);
  EXPECT_EQ(path.moves()[1].kind, MoveKind::rapid);
  EXPECT_EQ(path.moves()[2].kind, MoveKind::rapid);
  EXPECT_EQ(path.moves()[3].kind, MoveKind::cut);
}

struct ArcCase {
  const char* name;
  std::string program;
  double length_mm;
  Vector3 a_point_mm;  ///< on the arc, at half its length
};

class GcodeArc : public testing::TestWithParam<ArcCase> {};

TEST_P(GcodeArc, HasItsLengthAndRunsTheRightWayRound) {
  GcodeOptions options;
  options.chord_error = 0.01 * units::um;
  const ToolPath path = read_gcode(kHead + GetParam().program, options);
  // Chords within 0.01 um of radii of 1 mm and more: shorter than the arc by 4/3 of the sagitta
  // over the radius, 1.3e-5.
  EXPECT_NEAR(path.length() / mm, GetParam().length_mm, 2e-5 * GetParam().length_mm);
  const Vector3 half = path.at(0.5 * path.length()).position_W / mm;
  EXPECT_LT((half - GetParam().a_point_mm).norm(), 1e-4) << half.transpose();
}

const double kPi = std::numbers::pi;
const double kHalf = std::sqrt(0.5);
INSTANTIATE_TEST_SUITE_P(
    Table, GcodeArc,
    testing::Values(
        ArcCase{"quarter_ccw", "G3 X-1 Y1 I-1 J0\n", kPi / 2, {-1 + kHalf, kHalf, 5}},
        ArcCase{"three_quarters_cw", "G2 X-1 Y1 I-1 J0\n", 1.5 * kPi, {-1 - kHalf, -kHalf, 5}},
        ArcCase{"full_circle", "G2 I2\n", 4 * kPi, {4, 0, 5}},
        ArcCase{"radius_short", "G3 X-1 Y1 R1\n", kPi / 2, {-1 + kHalf, kHalf, 5}},
        ArcCase{"radius_long", "G3 X-1 Y1 R-1\n", 1.5 * kPi, {kHalf, 1 + kHalf, 5}},
        ArcCase{"radius_cw", "G2 X-1 Y1 R1\n", kPi / 2, {-kHalf, 1 - kHalf, 5}},
        ArcCase{"xz_plane_cw", "G18 G2 X2 Z5 I1 K0\n", kPi, {1, 0, 4}},
        ArcCase{"xz_plane_ccw", "G18 G3 X2 Z5 I1 K0\n", kPi, {1, 0, 6}},
        ArcCase{"yz_plane", "G19 G2 Y2 Z5 J1 K0\n", kPi, {0, 1, 6}},
        ArcCase{
            "inch", "G20 G3 X-1 Y1 I-1\n", 25.4 * kPi / 2, {25.4 * (-1 + kHalf), 25.4 * kHalf, 5}},
        ArcCase{"helix", "G2 X0 Y0 Z3 I1 J0\n", std::hypot(2 * kPi, 2.0), {2, 0, 4}}),
    [](const auto& of) { return of.param.name; });

struct BadLine {
  const char* name;
  std::string program;
  int line;
  const char* says;
};

class GcodeFault : public testing::TestWithParam<BadLine> {};

TEST_P(GcodeFault, NamesTheLineAndTheReason) {
  try {
    read_gcode(GetParam().program);
    FAIL() << "read";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(GetParam().says));
    const int line = GetParam().line;
    const std::string place = line > 0 ? "path.ngc:" + std::to_string(line) : "path.ngc";
    EXPECT_THAT(error.what(), testing::HasSubstr(place));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Table, GcodeFault,
    testing::Values(BadLine{"empty", "", 0, "no move"},
                    BadLine{"only_comments", "(nothing)\n", 0, "no move"},
                    BadLine{"drilling", kHead + "G81 X1 Z-2\n", 4, "G81"},
                    BadLine{"polar", kHead + "G1 A3\n", 4, "A3"},
                    BadLine{"counter_clockwise_spindle", "M4 S100\n", 1, "M4"},
                    BadLine{"open_comment", kHead + "G1 X1 (oops\n", 4, "must end with )"},
                    BadLine{"no_number", kHead + "G1 X\n", 4, "letter with a number"},
                    BadLine{"expression", kHead + "G1 X[1+2]\n", 4, "letter with a number"},
                    BadLine{"infinite", kHead + "G1 Xinf\n", 4, "letter with a number"},
                    BadLine{"twice", kHead + "G1 X1 X2\n", 4, "once in a line"},
                    BadLine{"two_motions", kHead + "G0 G1 X1\n", 4, "another of its group"},
                    BadLine{"no_motion", "X1 Y1 Z1\n", 1, "G0, G1"},
                    BadLine{"unknown_start", "M3 S1 F1\nG1 X1 Y1 Z1\n", 2, "known place"},
                    BadLine{"incremental_from_nowhere", "G91 G0 X1\n", 1, "count from"},
                    BadLine{"no_feed", "M3 S100\nG0 X0 Y0 Z0\nG1 X1\n", 3, "set before a cut"},
                    BadLine{"negative_feed", kHead + "G1 X1 F-3\n", 4, "must be > 0"},
                    BadLine{"no_spindle", "F100\nG0 X0 Y0 Z0\nG1 X1\n", 3, "spindle off"},
                    BadLine{"spindle_stopped", kHead + "M5\nG1 X1\n", 5, "spindle off"},
                    BadLine{"arc_without_centre", kHead + "G2 X1\n", 4, "needs I, J, K or R"},
                    BadLine{"arc_two_radii", kHead + "G2 X1 Y0 I3\n", 4, "one radius"},
                    BadLine{"arc_small_radius", kHead + "G2 X10 R4\n", 4, "half the chord"},
                    BadLine{"arc_circle_by_radius", kHead + "G2 X0 Y0 R4\n", 4, "full circle"},
                    BadLine{"arc_off_plane", kHead + "G2 X1 I0.5 K1\n", 4, "plane of G17"},
                    BadLine{"centre_on_a_line", kHead + "G1 X1 I1\n", 4, "belong to G2"}),
    [](const auto& of) { return of.param.name; });

TEST(Gcode, ReportsAllFaultsAtOnce) {
  try {
    read_gcode(kHead + "G81\nG1 X1\nM8\n");
    FAIL() << "read";
  } catch (const InvalidInput& error) {
    ASSERT_EQ(error.faults().size(), 2u);
    EXPECT_EQ(error.faults()[0].location, "path.ngc:4");
    EXPECT_EQ(error.faults()[1].location, "path.ngc:6");
  }
}

}  // namespace
}  // namespace osteomill::io
