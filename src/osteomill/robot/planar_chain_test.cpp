// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/planar_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/robot/placement.hpp"

namespace osteomill::robot {
namespace {

using units::deg;
using units::mm;

Eigen::VectorXd drawn(const PlanarChain& chain, Random& random) {
  Eigen::VectorXd q(static_cast<Eigen::Index>(chain.axes.size()));
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const JointRange& range = chain.axes[static_cast<std::size_t>(i)].range;
    q(i) = random.uniform(range.low, range.high);
  }
  return q;
}

/// A1, A2, a wrist, a telescope at an angle and a slide.
PlanarChain five_axes() {
  return chain_of({.link1 = 50.0 * mm, .link2 = 20.0 * mm, .slide_stroke = 25.0 * mm},
                  {{.length = 12.0 * mm, .range = {-60.0 * deg, 60.0 * deg}, .stiffness = 900.0},
                   {.kind = AxisKind::prismatic,
                    .direction = 35.0 * deg,
                    .range = {0.0, 15.0 * mm},
                    .stiffness = 4e5}});
}

void expect_on_line(const PlanarChain& chain, const Vector2& base, const CutLine& line,
                    const ChainSolution& solution) {
  const ChainPose pose = forward(chain, base, solution.joints);
  const Vector2 guide(-std::sin(pose.heading), std::cos(pose.heading));
  // The solver's own bound for rounding, 1e-8 rad and m.
  EXPECT_LT((guide - line.direction).norm(), 2e-8);
  const Vector2 off = line.entry - pose.tip();
  EXPECT_LT((off - solution.gap * line.direction).norm(), 2e-8);
  for (Eigen::Index i = 0; i < solution.joints.size(); ++i) {
    const JointRange& range = chain.axes[static_cast<std::size_t>(i)].range;
    EXPECT_GE(solution.joints(i), range.low - 1e-8);
    EXPECT_LE(solution.joints(i), range.high + 1e-8);
  }
}

/// A cut line that the chain reaches: its guide's own, with the entry a little before the tip.
CutLine line_of(const PlanarChain& chain, const Vector2& base, const Eigen::VectorXd& q,
                double gap) {
  const ChainPose pose = forward(chain, base, q);
  const Vector2 guide(-std::sin(pose.heading), std::cos(pose.heading));
  return {pose.tip() + gap * guide, guide, 30.0 * mm};
}

TEST(PlanarChain, ForwardOfTwoAxesIsThatOfTheGuidePositioner) {
  const GuidePositioner robot{.slide_stroke = 40.0 * mm};
  const Eigen::Vector3d q(0.4, -1.1, 7.0 * mm);
  const Vector2 base(3.0 * mm, -5.0 * mm);
  const ChainPose pose = forward(chain_of(robot), base, q);
  const GuidePose two = forward(robot, base, JointAngles{q(0), q(1)}, q(2));
  EXPECT_LT((pose.points[1] - two.X1).norm(), 1e-15);
  EXPECT_LT((pose.tip() - two.X2).norm(), 1e-15);
}

TEST(PlanarChain, JacobianMeetsFiniteDifferences) {
  const PlanarChain chain = five_axes();
  Random random(3);
  for (int k = 0; k < 200; ++k) {
    const Eigen::VectorXd q = drawn(chain, random);
    const Eigen::Matrix3Xd jacobian = chain_jacobian(chain, q);
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      constexpr double h = 1e-6;
      Eigen::VectorXd up = q, down = q;
      up(i) += h;
      down(i) -= h;
      const ChainPose a = forward(chain, Vector2::Zero(), up);
      const ChainPose b = forward(chain, Vector2::Zero(), down);
      Eigen::Vector3d slope;
      slope << (a.heading - b.heading) / (2.0 * h), (a.tip() - b.tip()) / (2.0 * h);
      // Truncation h² of lengths of 0.1 m, and rounding 1e-16/h.
      EXPECT_LT((slope - jacobian.col(i)).norm(), 1e-9);
    }
  }
}

TEST(PlanarChain, IsTheInverseOfTheGuidePositionerWithoutFurtherAxes) {
  const GuidePositioner robot;
  const PlanarChain chain = chain_of(robot);
  const Vector2 base(-20.0 * mm, 5.0 * mm);
  for (const CutLine& line : cut_lines(profile_of(generic_family(), 4))) {
    for (const Branch branch : {Branch::outermost, Branch::innermost}) {
      const auto closed = inverse(robot, base, line, branch);
      const auto there = gap(robot, base, line, branch);
      const ChainSolution solution = solve(chain, base, line, branch);
      ASSERT_EQ(solution.found, closed && there && *there >= 0.0);
      if (!solution.found) continue;
      EXPECT_NEAR(wrapped(solution.joints(0) - closed->theta1), 0.0, 1e-12);
      EXPECT_NEAR(wrapped(solution.joints(1) - closed->theta2), 0.0, 1e-12);
      EXPECT_NEAR(solution.gap, *there, 1e-12);
    }
  }
}

TEST(PlanarChain, WithOneSlideClosesTheGapAsTheSlidingGuideDoes) {
  const GuidePositioner robot{.slide_stroke = 6.0 * mm};
  const Vector2 base(-20.0 * mm, 5.0 * mm);
  int closed = 0, short_of = 0;
  for (const CutLine& line : cut_lines(profile_of(generic_family(), 4))) {
    const auto open = gap(robot, base, line, Branch::outermost);
    const ChainSolution solution = solve(chain_of(robot), base, line, Branch::outermost);
    ASSERT_EQ(solution.found, open && *open >= 0.0);
    if (!solution.found) continue;
    EXPECT_NEAR(solution.joints(2), std::min(*open, robot.slide_stroke), 2e-7);
    EXPECT_NEAR(solution.gap, std::max(0.0, *open - robot.slide_stroke), 2e-7);
    (*open <= robot.slide_stroke ? closed : short_of) += 1;
  }
  EXPECT_GT(closed + short_of, 0);
}

TEST(PlanarChain, FindsAPoseForEveryLineThatItsForwardKinematicsCanMake) {
  const PlanarChain chain = five_axes();
  const Vector2 base(-20.0 * mm, 5.0 * mm);
  Random random(4);
  for (int k = 0; k < 60; ++k) {
    const CutLine line = line_of(chain, base, drawn(chain, random), 0.0);
    const ChainSolution solution = solve(chain, base, line);
    ASSERT_TRUE(solution.found) << k << ": " << solution.reason;
    expect_on_line(chain, base, line, solution);
    EXPECT_NEAR(solution.gap, 0.0, 2e-7);
  }
}

// No pose that random search finds for the same cut, with the gap closed, does better.
TEST(PlanarChain, NoOtherPoseServesTheCriterionBetter) {
  const PlanarChain chain = five_axes();
  const Vector2 base(-20.0 * mm, 5.0 * mm);
  Random random(5);
  for (const Redundancy redundancy :
       {Redundancy::joint_centre, Redundancy::smallest_displacement, Redundancy::stiffest}) {
    const Eigen::VectorXd made = drawn(chain, random);
    const CutLine line = line_of(chain, base, made, 0.0);
    const ChainOptions options{redundancy, drawn(chain, random)};
    const ChainSolution solution = solve(chain, base, line, options);
    ASSERT_TRUE(solution.found);
    const auto criterion = [&](const Eigen::VectorXd& q) {
      const Eigen::Matrix3Xd jacobian = chain_jacobian(chain, q);
      const Vector2 normal(-line.direction.y(), line.direction.x());
      double sum = 0.0;
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        const PlanarAxis& axis = chain.axes[static_cast<std::size_t>(i)];
        const double half = 0.5 * (axis.range.high - axis.range.low);
        if (redundancy == Redundancy::stiffest) {
          const double lever = normal.dot(jacobian.col(i).tail<2>());
          sum += axis.stiffness > 0.0 ? lever * lever / axis.stiffness : 0.0;
        } else {
          const double from = redundancy == Redundancy::joint_centre
                                  ? 0.5 * (axis.range.low + axis.range.high)
                                  : options.from(i);
          sum += std::pow((q(i) - from) / half, 2);
        }
      }
      return sum;
    };
    // 0.5e-7 m of gap may be bought; the criteria's slopes over lengths are below 1e3 per metre.
    const double tolerance = 1e-4 * std::max(solution.criterion, 1e-12);
    EXPECT_NEAR(criterion(solution.joints), solution.criterion, 1e-9);
    EXPECT_LE(solution.criterion, criterion(made) + tolerance);
    // Other poses of the same tip: wrist and telescope drawn, the rest in closed form.
    int others = 0;
    for (int k = 0; k < 4000; ++k) {
      Eigen::VectorXd q = drawn(chain, random);
      const PlanarChain rest = {{chain.axes[0], chain.axes[1]}};
      q(0) = q(1) = 0.0;
      const ChainPose folded = forward(chain, Vector2::Zero(), q);
      const double heading = std::atan2(-line.direction.x(), line.direction.y());
      const double turn = heading - folded.heading;
      const Vector2 behind = folded.tip() - folded.points[1];
      const Vector2 across(std::cos(turn) * behind.x() - std::sin(turn) * behind.y(),
                           std::sin(turn) * behind.x() + std::cos(turn) * behind.y());
      // With the gap closed A2 is one point: two circles' worth, so the slide closes it.
      const Vector2 second = line.entry - across;
      const Vector2 along = line.direction;
      const Vector2 from = second - base;
      const double b = from.dot(along), c = from.squaredNorm() - std::pow(rest.axes[0].length, 2);
      if (b * b < c) continue;
      for (const double sign : {-1.0, 1.0}) {
        // The slide comes out by s more: A2 goes back by s along the line.
        const double s = b + sign * std::sqrt(b * b - c);
        Eigen::VectorXd other = q;
        other(4) += s;
        if (other(4) < 0.0 || other(4) > chain.axes[4].range.high) continue;
        const Vector2 link = second - s * along - base;
        other(0) = std::atan2(-link.x(), link.y());
        other(1) = wrapped(heading - folded.heading - other(0));
        const ChainPose pose = forward(chain, base, other);
        ASSERT_LT((pose.tip() - line.entry).norm(), 1e-12);
        EXPECT_GE(criterion(other), solution.criterion - tolerance);
        ++others;
      }
    }
    EXPECT_GT(others, 20);
  }
}

TEST(PlanarChain, TellsWhyThereIsNoPose) {
  const PlanarChain chain = chain_of({.slide_stroke = 10.0 * mm});
  const CutLine far{{500.0 * mm, 0.0}, {0.0, -1.0}, 30.0 * mm};
  const ChainSolution none = solve(chain, Vector2::Zero(), far);
  EXPECT_FALSE(none.found);
  EXPECT_NE(none.reason.find("outside the workspace"), std::string::npos);
  const PlanarChain stiff = chain_of({.range1 = {0.0, 0.01}, .range2 = {0.0, 0.01}});
  const ChainSolution limited =
      solve(stiff, Vector2::Zero(), {{-30.0 * mm, 0.0}, {0.0, -1.0}, 30.0 * mm});
  EXPECT_FALSE(limited.found);
  EXPECT_NE(limited.reason.find("within their ranges"), std::string::npos);
}

TEST(PlanarChain, RefusesWhatIsNoChain) {
  EXPECT_THROW(check(PlanarChain{}), InvalidInput);
  EXPECT_THROW(check(PlanarChain{{{.length = 0.1}, {.kind = AxisKind::prismatic}}}), InvalidInput);
  EXPECT_THROW(check(PlanarChain{{{.length = 0.0}, {.length = 0.1}}}), InvalidInput);
  EXPECT_THROW(check(chain_of({}, {{.length = -1.0}})), InvalidInput);
  EXPECT_THROW(check(chain_of({}, {{.range = {1.0, 0.0}}})), InvalidInput);
  EXPECT_THROW(check(chain_of({}, {{.stiffness = -1.0}})), InvalidInput);
  EXPECT_THROW(solve(chain_of({}), Vector2::Zero(), {Vector2::Zero(), Vector2::UnitY(), 0.0},
                     {Redundancy::smallest_displacement, {}}),
               InvalidInput);
}

}  // namespace
}  // namespace osteomill::robot
