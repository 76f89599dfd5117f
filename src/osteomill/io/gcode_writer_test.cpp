// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/gcode_writer.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/cl_file.hpp"
#include "osteomill/io/gcode.hpp"
#include "osteomill/workpiece/area_paths.hpp"
#include "osteomill/workpiece/swing.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using units::mm;
using workpiece::ToolPath;

const workpiece::CutSettings kCut{3e-3, 628.0};

/// The largest distance between two paths at equal arc length; theirs may differ by rounding.
double apart(const ToolPath& a, const ToolPath& b) {
  double largest = std::abs(a.length() - b.length());
  for (int k = 0; k <= 2000; ++k)
    largest = std::max(
        largest,
        (a.at(a.length() * k / 2000).position_W - b.at(b.length() * k / 2000).position_W).norm());
  return largest;
}

long lines_with(const std::string& text, const std::string& word) {
  long count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++count;
  return count;
}

TEST(GcodeWriter, WritesWhatItsReaderReads) {
  const std::string program =
      "G21 G90 G17\nG0 X0 Y0 Z5\nS20000 M3\nF300\nG1 Z-1\nG2 X10 Y0 I5 J0\nG3 X10 Y0 Z-3 I-4 J3\n"
      "G1 X12\nG18\nG2 X16 Z-3 I2 K0\nG19 F120\nG3 Y6 Z-3 J3 K0\nG0 Z5\nM5\nM2\n";
  const ToolPath path = read_gcode(program);
  const std::string written = write_gcode(path);
  // Every arc of the program is one again, in its plane.
  EXPECT_EQ(lines_with(written, "\nG2 X"), 2);
  EXPECT_EQ(lines_with(written, "\nG3 X"), 2);
  EXPECT_EQ(lines_with(written, "G18"), 1);
  EXPECT_EQ(lines_with(written, "G19"), 1);
  // Coordinates are written to 1 nm; radii of centimetres take a few of them into an arc's length.
  EXPECT_LT(apart(read_gcode(written), path), 20e-9);
  EXPECT_EQ(write_gcode(read_gcode(written)), written);
}

TEST(GcodeWriter, KeepsFeedsSpeedsAndRapids) {
  const ToolPath path =
      read_gcode("G0 X0 Y0 Z5\nS6000 M3\nG1 F180 X3\nG0 X9\nS9000\nG1 F60 Y2\nM2\n");
  const ToolPath again = read_gcode(write_gcode(path));
  ASSERT_EQ(again.moves().size(), path.moves().size());
  for (std::size_t m = 0; m < path.moves().size(); ++m) {
    EXPECT_EQ(again.moves()[m].kind, path.moves()[m].kind);
    EXPECT_NEAR(again.moves()[m].feed_rate, path.moves()[m].feed_rate, 1e-12);
    EXPECT_NEAR(again.moves()[m].spindle_speed, path.moves()[m].spindle_speed, 1e-6);
  }
}

TEST(GcodeWriter, TakesCornersForCorners) {
  const ToolPath square = read_gcode("G0 X0 Y0 Z0\nS6000 M3\nG1 F180 X3\nY3\nX0\nY0\nM2\n");
  EXPECT_EQ(lines_with(write_gcode(square), "\nG1 X"), 4);
}

TEST(GcodeWriter, WritesATrochoidAsItIs) {
  workpiece::Trochoid slot;
  slot.slot_width = 8 * mm;
  slot.cutter_radius = 2 * mm;
  slot.levels = {-1 * mm};
  slot.clearance_z = 5 * mm;
  const ToolPath path = workpiece::trochoidal_slot(slot, kCut);
  // Some hundred points of 1 nm.
  EXPECT_LT(apart(read_gcode(write_gcode(path)), path), 1e-6);
}

ToolPath swung() {
  workpiece::Swing swing;
  swing.pivot_W = {-40 * mm, 0, -8 * mm};
  return workpiece::swing_and_advance(swing, kCut);
}

TEST(GcodeWriter, RefusesAnAxisThatTurns) { EXPECT_THROW(write_gcode(swung()), InvalidInput); }

TEST(ClFile, KeepsPlacesAndAxes) {
  const ToolPath path = swung();
  const ToolPath again = read_cl(write_cl(path));
  EXPECT_LT(apart(again, path), 1e-6);
  for (int k = 0; k <= 100; ++k)
    EXPECT_LT((again.at(again.length() * k / 100).axis_W - path.at(path.length() * k / 100).axis_W)
                  .norm(),
              1e-4);
  EXPECT_EQ(write_cl(again), write_cl(path));
}

TEST(ClFile, ReadsUnitsFeedsRapidsAndStaysWithItsAxis) {
  const ToolPath path = read_cl(
      "PARTNO KNEE\nUNITS/INCHES\nSPINDL/6000,RPM,CLW\nFEDRAT/2,IPM\nFROM/0,0,1\nRAPID\n"
      "GOTO/1,0,1\nGOTO/1,0,0,0,0.6,0.8\nGOTO/2,0,0\nFINI\nGOTO/junk\n");
  ASSERT_EQ(path.moves().size(), 3u);
  EXPECT_EQ(path.moves()[0].kind, workpiece::MoveKind::rapid);
  EXPECT_TRUE(path.moves()[0].axes_W.empty());
  EXPECT_NEAR(path.moves()[1].feed_rate, 2 * 25.4 * units::mm_per_min, 1e-12);
  EXPECT_NEAR(path.length(), 3 * 25.4 * mm, 1e-12);
  EXPECT_NEAR(path.moves()[2].axes_W[1].z(), 0.8, 1e-12);
  EXPECT_EQ(path.moves()[2].line, 9);
}

TEST(ClFile, NamesEveryFaultByItsLine) {
  const struct {
    const char* text;
    const char* said;
  } cases[] = {{"GOTO/0,0,0\nGOTO/1,0,0\n", "must be set before a cut"},
               {"GOTO/0,0\n", "must have 3 numbers"},
               {"GOTO/0,0,x\n", "must be a number"},
               {"GOTO/0,0,0,0,0,2\n", "length 1"},
               {"CYCLE/DRILL\n", "is not one of the subset"},
               {"SPINDL/100,CCLW\n", "CLW"},
               {"FEDRAT/-3\n", "must be > 0"},
               {"UNITS/FEET\n", "MM or INCHES"},
               {"FINI\n", "two GOTO"}};
  for (const auto& one : cases) {
    try {
      read_cl(one.text, "a.cl");
      ADD_FAILURE() << one.text;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(one.said)) << one.text;
      EXPECT_THAT(error.what(), testing::HasSubstr("a.cl")) << one.text;
    }
  }
}

}  // namespace
}  // namespace osteomill::io
