// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/guide_positioner.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

using units::deg;
using units::mm;

GuidePositioner prototype() { return {.link1 = 60.0 * mm, .link2 = 30.0 * mm}; }

double distance_to_line(const Vector2& p, const CutLine& line) {
  const Vector2 r = p - line.entry;
  return line.direction.x() * r.y() - line.direction.y() * r.x();
}

TEST(GuidePositioner, ReachesTheCutLineThatTheInverseWasAskedFor) {
  Random random(2);
  int reached = 0;
  for (int i = 0; i < 100000; ++i) {
    GuidePositioner robot{.link1 = random.uniform(0.03, 0.08), .link2 = random.uniform(0.0, 0.05)};
    const Vector2 axis{random.uniform(-0.06, 0.02), random.uniform(-0.03, 0.03)};
    const double phi = random.uniform(-std::numbers::pi, std::numbers::pi);
    CutLine line{{random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05)},
                 {-std::sin(phi), std::cos(phi)},
                 0.03};
    for (const Branch branch : {Branch::outermost, Branch::innermost}) {
      const auto joints = inverse(robot, axis, line, branch);
      if (!joints) {
        EXPECT_GT(std::abs(distance_to_line(axis, line)), robot.link1 * (1.0 - 1e-12));
        continue;
      }
      ++reached;
      const GuidePose pose = forward(robot, axis, *joints);
      // Rounding of coordinates of 0.1 m; near tangency the root loses half of the digits.
      ASSERT_NEAR(distance_to_line(pose.X1, line), 0.0, 1e-9);
      ASSERT_NEAR(distance_to_line(pose.X2, line), 0.0, 1e-9);
      ASSERT_NEAR((pose.X2 - pose.X1).dot(line.direction), robot.link2, 1e-12);
      ASSERT_NEAR((pose.X1 - axis).norm(), robot.link1, 1e-9);
    }
  }
  EXPECT_GT(reached, 100000);
}

TEST(GuidePositioner, GivesBackTheJointAnglesItWasDrivenTo) {
  Random random(3);
  const GuidePositioner robot = prototype();
  for (int i = 0; i < 100000; ++i) {
    const JointAngles joints{random.uniform(-3.14, 3.14), random.uniform(-3.14, 3.14)};
    if (std::abs(std::cos(joints.theta2)) < 1e-3) continue;  // singular: branches meet
    const Vector2 axis{random.uniform(-0.06, 0.02), random.uniform(-0.03, 0.03)};
    const GuidePose pose = forward(robot, axis, joints);
    const CutLine line{pose.X2, (pose.X2 - pose.X1).normalized(), 0.0};
    const Branch branch = std::cos(joints.theta2) < 0.0 ? Branch::outermost : Branch::innermost;
    const auto found = inverse(robot, axis, line, branch);
    ASSERT_TRUE(found);
    // Rounding 1e-16 divided by the distance 1e-3 to the singularity, with a margin of 1e4.
    ASSERT_NEAR(wrapped(found->theta1 - joints.theta1), 0.0, 1e-9);
    ASSERT_NEAR(wrapped(found->theta2 - joints.theta2), 0.0, 1e-9);
  }
}

TEST(GuidePositioner, JacobiansAreTheFiniteDifferences) {
  Random random(4);
  const GuidePositioner robot = prototype();
  const double step = 1e-6;
  for (int i = 0; i < 200; ++i) {
    const JointAngles q{random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)};
    const Vector2 axis{random.uniform(-0.06, 0.02), random.uniform(-0.03, 0.03)};
    const auto plane = [&](const JointAngles& joints) {
      const GuidePose pose = forward(robot, axis, joints);
      const Vector2 guide = (pose.X2 - pose.X1).normalized();
      return Vector2(joints.theta1 + joints.theta2, Vector2(-guide.y(), guide.x()).dot(pose.X1));
    };
    for (int j = 0; j < 2; ++j) {
      JointAngles more = q;
      JointAngles less = q;
      (j == 0 ? more.theta1 : more.theta2) += step;
      (j == 0 ? less.theta1 : less.theta2) -= step;
      const Vector2 slope = (plane(more) - plane(less)) / (2.0 * step);
      const Vector2 tip =
          (forward(robot, axis, more).X2 - forward(robot, axis, less).X2) / (2.0 * step);
      // Second order: step^2 / 6 times lengths of 0.1 m, and rounding 1e-17 / step.
      EXPECT_LT((plane_jacobian(robot, axis, q).col(j) - slope).norm(), 1e-9);
      EXPECT_LT((tip_jacobian(robot, q).col(j) - tip).norm(), 1e-9);
    }
    EXPECT_NEAR(plane_jacobian(robot, axis, q).determinant(), plane_determinant(robot, q), 1e-12);
  }
}

TEST(GuidePositioner, IsSingularExactlyWhereTheCutLineTouchesTheCircle) {
  const GuidePositioner robot = prototype();
  const Vector2 axis{-35.0 * mm, 2.0 * mm};
  const CutLine touching{axis + Vector2(robot.link1, 0.01), {0.0, -1.0}, 0.03};
  const auto joints = inverse(robot, axis, touching, Branch::outermost);
  ASSERT_TRUE(joints);
  EXPECT_NEAR(plane_determinant(robot, *joints), 0.0, 1e-9);
  const CutLine beyond{axis + Vector2(robot.link1 + 1e-6, 0.01), {0.0, -1.0}, 0.03};
  EXPECT_FALSE(inverse(robot, axis, beyond, Branch::outermost));
  const CutLine inside{axis + Vector2(0.5 * robot.link1, 0.01), {0.0, -1.0}, 0.03};
  EXPECT_GT(std::abs(plane_determinant(robot, *inverse(robot, axis, inside, Branch::outermost))),
            0.5 * robot.link1);
}

TEST(GuidePositioner, KnowsItsLimitsAcrossAFullTurn) {
  GuidePositioner robot = prototype();
  robot.range1 = {170.0 * deg, 280.0 * deg};
  EXPECT_TRUE(within_limits(robot, {-100.0 * deg, 0.0}));
  EXPECT_TRUE(within_limits(robot, {175.0 * deg, 0.0}));
  EXPECT_FALSE(within_limits(robot, {-70.0 * deg, 0.0}));
}

TEST(GuidePositioner, PlayOfTheGuideIsTheSumOfThePlaysOfTheAxes) {
  const GuidePositioner robot = prototype();
  // Guide folded back over link 1: the lever of axis 1 at the tip is L1 − L2, of axis 2 it is L2.
  const GuidePlay play = guide_play(robot, {0.3, std::numbers::pi}, 0.24 * deg, 0.14 * deg);
  EXPECT_NEAR(play.angle, 0.38 * deg, 1e-12);
  EXPECT_NEAR(play.normal, (30.0 * 0.24 + 30.0 * 0.14) * mm * deg, 1e-12);
}

TEST(GuidePositioner, RefusesWhatIsNoRobot) {
  const auto refuses = [](auto change) {
    GuidePositioner robot = prototype();
    change(robot);
    EXPECT_THROW(check(robot), InvalidInput);
  };
  refuses([](GuidePositioner& r) { r.link1 = 0.0; });
  refuses([](GuidePositioner& r) { r.link1 = std::nan(""); });
  refuses([](GuidePositioner& r) { r.link2 = -0.01; });
  refuses([](GuidePositioner& r) { r.slide_stroke = -0.01; });
  refuses([](GuidePositioner& r) { r.tool_thickness = 0.05; });
  refuses([](GuidePositioner& r) { r.range1 = {1.0, 1.0}; });
}

}  // namespace
}  // namespace osteomill::robot
