// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/robot_case.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/calibrate/simulated_tracker.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/catalogue.hpp"
#include "osteomill/io/profile_drawing.hpp"
#include "osteomill/io/robot_calibration_case.hpp"
#include "osteomill/io/robot_drawing.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using units::mm;

TEST(ImplantCatalogue, HoldsTheGenericFamilyOfTheLibraryAndTenShapes) {
  const robot::ImplantFamily ours = implant_family("generic");
  const robot::ImplantFamily library = robot::generic_family();
  ASSERT_EQ(ours.anteroposterior.size(), 7u);
  for (int size = 1; size <= 7; ++size) {
    const auto a = robot::profile_of(ours, size).corners;
    const auto b = robot::profile_of(library, size).corners;
    // Sizes stand in the file with nine decimals of a millimetre.
    for (std::size_t i = 0; i < 6; ++i) EXPECT_LT((a[i] - b[i]).norm(), 1e-11);
  }
  for (const std::string& name : catalogue_names("implants")) {
    const robot::ImplantFamily family = implant_family(name);
    for (std::size_t size = 1; size <= family.anteroposterior.size(); ++size) {
      EXPECT_NO_THROW(robot::profile_of(family, static_cast<int>(size))) << name;
    }
  }
}

std::string points_of(const robot::Profile& profile, const char* between, double flip) {
  std::string text;
  for (const auto& p : profile.corners) {
    text += fmt::format("{:.6f}{}{:.6f} ", p.x() / mm, between, flip * p.y() / mm);
  }
  return text;
}

TEST(ProfileDrawing, ReadsTheSameProfileFromDxfAndSvg) {
  const robot::Profile profile = robot::profile_of(robot::generic_family(), 3);
  const auto same = [&](const std::filesystem::path& file) {
    const robot::Profile read = robot::make_profile(read_polyline(file, mm));
    for (std::size_t i = 0; i < 6; ++i) {
      // Six decimals of a millimetre.
      EXPECT_LT((read.corners[i] - profile.corners[i]).norm(), 1e-8) << file;
    }
  };
  std::string dxf = "0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\n0\n90\n6\n70\n0\n";
  for (const auto& p : profile.corners) {
    dxf += fmt::format("10\n{:.6f}\n20\n{:.6f}\n", p.x() / mm, p.y() / mm);
  }
  dxf += "0\nENDSEC\n0\nEOF\n";
  write_text_file(scratch("a.dxf"), dxf);
  same(scratch("a.dxf"));
  write_text_file(scratch("a.svg"),
                  "<svg xmlns='http://www.w3.org/2000/svg'><g><polyline points='" +
                      points_of(profile, ",", -1.0) + "'/></g></svg>");
  same(scratch("a.svg"));
  write_text_file(scratch("b.svg"),
                  "<svg><path d='M " + points_of(profile, " ", -1.0) + "'/></svg>");
  same(scratch("b.svg"));
}

TEST(ProfileDrawing, SaysWhatItCannotUse) {
  const auto complaint = [&](const std::string& name, const std::string& text) -> std::string {
    write_text_file(scratch(name), text);
    try {
      read_polyline(scratch(name), mm);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(complaint("a.svg", "<svg><path d='M 0 0 C 1 1 2 2 3 3'/></svg>"),
              testing::HasSubstr("straight pieces"));
  EXPECT_THAT(complaint("b.svg", "<svg></svg>"), testing::HasSubstr("it holds 0"));
  EXPECT_THAT(complaint("c.svg", "<svg"), testing::HasSubstr("is no SVG"));
  EXPECT_THAT(complaint("d.svg", "<svg><polyline points='1 2 3'/></svg>"),
              testing::HasSubstr("odd number"));
  EXPECT_THAT(complaint("e.dxf", "hello\nworld\n"), testing::HasSubstr("group code"));
  EXPECT_THAT(complaint("f.dxf", "0\nLWPOLYLINE\n10\n1\n20\n1\n42\n0.5\n"),
              testing::HasSubstr("arcs"));
  EXPECT_THAT(complaint("g.step", ""), testing::HasSubstr(".dxf or .svg"));
}

TEST(RobotCases, OfTheExamplesAreRead) {
  const std::filesystem::path examples = OSTEOMILL_SOURCE_DIR "/examples";
  RobotPlaceCase place;
  Section::read(read_case(examples / "robot_place.toml", {}).at(0),
                [&](Section& section) { bind_robot_place(section, place); });
  EXPECT_NEAR(place.robot.link1, 60.0 * mm, 1e-15);
  EXPECT_EQ(implant_of(place.implant).obtained, "assumed");
  RobotPositionCase position;
  Section::read(read_case(examples / "robot_position.toml", {}).at(0),
                [&](Section& section) { bind_robot_position(section, position); });
  EXPECT_EQ(position.sequence.order.size(), 5u);
}

TEST(RobotCases, OfTwoPlusNAxesServeEveryCutWithEachCriterion) {
  const std::filesystem::path examples = OSTEOMILL_SOURCE_DIR "/examples";
  double least = 0.0;
  for (const char* redundancy : {"stiffest", "joint-centre", "smallest-displacement"}) {
    RobotPositionCase c;
    Section::read(read_case(examples / "robot_chain.toml",
                            {fmt::format("chain.redundancy=\"{}\"", redundancy)})
                      .at(0),
                  [&](Section& section) { bind_robot_position(section, c); });
    ASSERT_TRUE(c.chain);
    ASSERT_EQ(c.further.size(), 2u);
    const Implant implant = implant_of(c.implant);
    const robot::CutOptions cuts{c.options.distal_overhang, c.robot.tool_thickness};
    const auto steps = robot::plan_chain_sequence(
        robot::chain_of(c.robot, c.further), implant.profile, cuts,
        robot::generic_bone(implant.profile, 7.0 * mm), {*c.axis_x, *c.axis_y}, c.redundancy);
    double compliance = 0.0;
    for (const robot::ChainStep& step : steps) {
      EXPECT_EQ(step.trouble, "") << robot::name(step.cut) << ", " << redundancy;
      EXPECT_NEAR(step.solution.gap, 0.0, 2e-7);
      compliance += step.solution.normal_compliance;
    }
    if (least == 0.0) least = compliance;
    EXPECT_LE(least, compliance);  // the stiffest comes first
  }
}

TEST(RobotCases, OfSizesTakeErrorsWithTheirSeed) {
  write_text_file(scratch("size.toml"),
                  "[size]\nfamilies = [\"generic\"]\nl1_mm = [60, 75]\nl2_mm = [20, 40]\n"
                  "[errors]\nposition_sd_mm = 1\nseed = 9\nkept_share = 0.9\n");
  RobotSizeCase c;
  Section::read(read_case(scratch("size.toml"), {}).at(0),
                [&](Section& section) { bind_robot_size(section, c); });
  ASSERT_TRUE(c.errors);
  EXPECT_EQ(c.errors->seed, 9u);
  EXPECT_NEAR(c.errors->position, 1.0 * mm, 1e-15);
  EXPECT_EQ(c.kept_share, 0.9);
}

TEST(RobotCases, NameEveryFaultAtOnce) {
  write_text_file(scratch("bad.toml"),
                  "[implant]\nfamily = \"generic\"\nsize = 0\n[robot]\nl1_mm = -1\nl2_mm = 30\n"
                  "[sequence]\norder = [\"distal\", \"sideways\"]\n");
  RobotPositionCase c;
  try {
    Section::read(read_case(scratch("bad.toml"), {}).at(0),
                  [&](Section& section) { bind_robot_position(section, c); });
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("implant.size"),
                               testing::HasSubstr("robot.l1_mm"), testing::HasSubstr("sideways")));
  }
}

TEST(RobotDrawings, AreWrittenAsSvg) {
  const robot::GuidePositioner positioner{.link1 = 60.0 * mm, .link2 = 30.0 * mm};
  const robot::Profile profile = robot::profile_of(robot::generic_family(), 4);
  const auto lines = robot::cut_lines(profile);
  const robot::Placement best = robot::place(positioner, lines);
  const robot::BoneOutline bone = robot::generic_bone(profile, 7.0 * mm);
  const auto steps =
      robot::plan_sequence(positioner, profile, {}, bone, best.axis_position, best.branches);
  draw_poses(profile, {}, bone, best.axis_position, steps, "poses", scratch("poses.svg"));
  draw_sensitivity(positioner, lines, best, "sensitivity", scratch("sensitivity.svg"));
  draw_gap_map(robot::gap_map(positioner, lines, {-0.05, -0.02}, {0.0, 0.02}, 2.0 * mm), best,
               Circle{best.axis_position, 2.0 * mm, "circle"}, "map", scratch("map.svg"));
  for (const char* name : {"poses.svg", "sensitivity.svg", "map.svg"}) {
    EXPECT_THAT(read_text_file(scratch(name)), testing::HasSubstr("</svg>")) << name;
  }
  EXPECT_THAT(read_text_file(scratch("poses.svg")), testing::HasSubstr("posterior chamfer"));
}

TEST(GuideRecord, ComesBackFromItsFile) {
  Random random(1);
  const calibrate::GuideRecord record =
      calibrate::play_procedure(calibrate::simulated_robot(), random);
  write_guide_record(scratch("poses.csv"), record);
  const calibrate::GuideRecord read = read_guide_record(scratch("poses.csv"));
  ASSERT_EQ(read.sweep1.size(), record.sweep1.size());
  ASSERT_EQ(read.sweep2.size(), record.sweep2.size());
  const auto& a = record.sweep2[4];
  const auto& b = read.sweep2[4];
  EXPECT_EQ(a.name, b.name);
  EXPECT_LT((a.halls - b.halls).norm(), 1e-5);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  EXPECT_LT((a.samples[7].X_FG.matrix() - b.samples[7].X_FG.matrix()).norm(), 1e-5);
  write_text_file(scratch("bad.csv"), "stop,phase\nP1,P\n");
  EXPECT_THROW(read_guide_record(scratch("bad.csv")), InvalidInput);
}

}  // namespace
}  // namespace osteomill::io
