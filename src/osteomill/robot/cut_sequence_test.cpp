// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/cut_sequence.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

using units::deg;
using units::mm;

struct Case {
  GuidePositioner robot{.link1 = 60.0 * mm, .link2 = 30.0 * mm};
  Profile profile = profile_of(generic_family(), 4);
  CutOptions cuts;
  BoneOutline bone = generic_bone(profile, cuts.distal_overhang / std::sqrt(2.0));
  Placement placement = place(robot, cut_lines(profile, cuts));

  std::vector<SequenceStep> plan(const SequenceOptions& options = {}) const {
    return plan_sequence(robot, profile, cuts, bone, placement.axis_position, placement.branches,
                         options);
  }
};

TEST(GenericBone, EndsAtTheOverhangOnThePlaneOfTheDistalCut) {
  const Case c;
  const auto at = first_bone(c.bone, cut_lines(c.profile, c.cuts)[0]);
  ASSERT_TRUE(at);
  EXPECT_NEAR(*at, 0.0, 1e-12);
}

TEST(CutSequence, GapsToTheBoneInTheDefaultOrderAreThoseOfThePlacement) {
  const Case c;
  const auto steps = c.plan();
  ASSERT_EQ(steps.size(), 5u);
  for (const SequenceStep& step : steps) {
    EXPECT_TRUE(step.reachable);
    EXPECT_FALSE(step.collides) << step.trouble;
    EXPECT_EQ(step.trouble, "");
    EXPECT_NEAR(step.gap, c.placement.gaps[index(step.cut)], 1e-12) << name(step.cut);
  }
}

TEST(CutSequence, AThickToolLeavesTheSameBoneAndFindsItsWay) {
  Case c;
  c.cuts.tool_thickness = 7.0 * mm;
  c.placement = place(c.robot, cut_lines(c.profile, c.cuts));
  for (const SequenceStep& step : c.plan()) {
    EXPECT_EQ(step.trouble, "");
    EXPECT_NEAR(step.gap, c.placement.gaps[index(step.cut)], 1e-12) << name(step.cut);
  }
}

TEST(CutSequence, PathsKeepClearOfTheBoneThatIsLeft) {
  const Case c;
  const SequenceOptions options{.clearance = 2.0 * mm};
  BoneOutline left = c.bone;
  const auto lines = cut_lines(c.profile, c.cuts);
  const auto steps = c.plan(options);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (i > 0) {
      ASSERT_TRUE(steps[i].path_found) << steps[i].trouble;
      const double keep = std::min(
          {options.clearance, clearance(left, steps[i - 1].pose), clearance(left, steps[i].pose)});
      for (const JointAngles& q : densified(steps[i].path, 0.2 * deg)) {
        // Between two looks a quarter of a step apart the tip, 90 mm out, moves less than 0.8 mm.
        EXPECT_GE(clearance(left, forward(c.robot, c.placement.axis_position, q)),
                  std::max(0.0, keep - 0.8 * mm));
      }
    }
    left = after_cut(left, lines[index(steps[i].cut)]);
  }
  // What is left is the profile.
  EXPECT_NEAR(first_bone(left, lines[index(Cut::posterior)]).value_or(1.0), 0.0, 1e-9);
}

TEST(CutSequence, AGuideThatCutsLaterBoneFirstIsFarther) {
  const Case c;
  SequenceOptions options;
  options.order = {Cut::anterior, Cut::anterior_chamfer, Cut::posterior_chamfer, Cut::posterior,
                   Cut::distal};
  const auto steps = c.plan(options);
  // Before the distal and the chamfer cut there is bone in front of the anterior cut's own entry.
  EXPECT_LT(steps[0].gap, c.placement.gaps[index(Cut::anterior)] - 1.0 * mm);
}

TEST(CutSequence, SaysWhatIsWrong) {
  Case c;
  c.robot.range1 = {-10.0 * deg, 10.0 * deg};
  bool limited = false;
  for (const SequenceStep& step : c.plan()) {
    limited = limited || step.trouble.find("joint limit") != std::string::npos;
  }
  EXPECT_TRUE(limited);
  c.placement.axis_position = {
      0.0, -20.0 * mm};  // so far posterior that the distal cut's guide is in bone
  c.robot.range1 = {};
  bool collides = false;
  for (const SequenceStep& step : c.plan()) collides = collides || step.collides;
  EXPECT_TRUE(collides);
}

TEST(CutSequence, RefusesAnOrderThatIsNone) {
  const Case c;
  SequenceOptions options;
  options.order = {Cut::distal, Cut::distal, Cut::anterior, Cut::posterior, Cut::posterior_chamfer};
  EXPECT_THROW(c.plan(options), InvalidInput);
  options.order = {Cut::distal};
  EXPECT_THROW(c.plan(options), InvalidInput);
  EXPECT_THROW(c.plan({.joint_step = 0.0}), InvalidInput);
  EXPECT_THROW(c.plan({.clearance = -1.0}), InvalidInput);
  EXPECT_THROW(generic_bone(c.profile, -1.0), InvalidInput);
}

TEST(BoneOutline, CutsShortenItAndNeverGrowIt) {
  const Case c;
  const auto area = [](const BoneOutline& bone) {
    double twice = 0.0;
    for (std::size_t i = 0; i < bone.size(); ++i) {
      const Vector2& a = bone[i];
      const Vector2& b = bone[(i + 1) % bone.size()];
      twice += a.x() * b.y() - a.y() * b.x();
    }
    return 0.5 * twice;
  };
  BoneOutline left = c.bone;
  double before = area(left);
  for (const CutLine& line : cut_lines(c.profile, c.cuts)) {
    left = after_cut(left, line);
    EXPECT_LT(area(left), before);
    EXPECT_GT(area(left), 0.0);
    before = area(left);
  }
  const BoneOutline profile(c.profile.corners.rbegin(), c.profile.corners.rend());
  EXPECT_NEAR(before, area(profile),
              0.02 * area(profile));  // ends of the bone are a little oblique
}

}  // namespace
}  // namespace osteomill::robot
