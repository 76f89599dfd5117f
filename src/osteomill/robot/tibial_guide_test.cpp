// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/tibial_guide.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

using geometry::Pose;
using geometry::Vector3;
using units::deg;
using units::mm;

/// The base as it is pinned: turned against the anatomy by some degrees, 60 mm below the plateau.
Pose pinned(Random& random, double most) {
  Pose X_AB = Pose::Identity();
  X_AB.linear() = (Eigen::AngleAxisd(random.uniform(-most, most), Vector3::UnitX()) *
                   Eigen::AngleAxisd(random.uniform(-most, most), Vector3::UnitY()) *
                   Eigen::AngleAxisd(random.uniform(-most, most), Vector3::UnitZ()))
                      .toRotationMatrix();
  X_AB.translation() = Vector3(5.0, 30.0, -60.0) * mm;
  return X_AB;
}

TibialGuide guide() { return {.centre_B = Vector3(0.0, 10.0, 40.0) * mm, .height = 12.0 * mm}; }

TEST(TibialGuide, ShowsTheTargetAfterTheJointsAreSet) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Pose X_AB = pinned(random, 15.0 * deg);
    const TibialDisplay target{random.uniform(-4.0, 4.0) * deg, random.uniform(0.0, 8.0) * deg,
                               random.uniform(-10.0, -6.0) * mm};
    const TibialSetting setting = solve(guide(), X_AB, target);
    const TibialDisplay shown = display(guide(), X_AB, setting.joints);
    EXPECT_NEAR(shown.varus, target.varus, 1e-12);
    EXPECT_NEAR(shown.slope, target.slope, 1e-12);
    EXPECT_NEAR(shown.depth, target.depth, 1e-12);
  }
}

TEST(TibialGuide, NeedsOneTurnOfEachAxisWhereTheScreenNeedsSeveral) {
  Random random(2);
  const TibialDisplay target{0.0, 5.0 * deg, -9.0 * mm};
  Pose X_AB = pinned(random, 0.0);
  X_AB.linear() = Eigen::AngleAxisd(20.0 * deg, Vector3::UnitZ()).toRotationMatrix();
  const auto steps =
      adjust_by_screen(guide(), X_AB, {0.0, 8.0 * deg, -6.0 * deg}, target, 0.1 * deg);
  EXPECT_GT(steps.size(), 4u) << "coupled: more than one turn of each axis";
  EXPECT_NEAR(steps.back().shown.varus, target.varus, 0.1 * deg);
  EXPECT_NEAR(steps.back().shown.slope, target.slope, 0.1 * deg);
  const TibialSetting direct = solve(guide(), X_AB, target);
  ASSERT_TRUE(direct.reachable) << direct.reason;
  EXPECT_NEAR(direct.joints.flexion, steps.back().joints.flexion, 0.3 * deg);
  EXPECT_NEAR(direct.joints.varus, steps.back().joints.varus, 0.3 * deg);
}

TEST(TibialGuide, IsNotCoupledWhenItsAxesAreThoseOfTheAnatomy) {
  Pose X_AB = Pose::Identity();
  X_AB.translation() = Vector3(0.0, 0.0, -60.0) * mm;
  const TibialDisplay zero = display(guide(), X_AB, {});
  const TibialDisplay flexed = display(guide(), X_AB, {0.0, 5.0 * deg, 0.0});
  EXPECT_NEAR(flexed.varus, zero.varus, 1e-15);
  EXPECT_NEAR(std::abs(flexed.slope - zero.slope), 5.0 * deg, 1e-12);
}

TEST(TibialGuide, SaysWhenItsRangeIsTooSmall) {
  Random random(3);
  const TibialSetting setting = solve(guide(), pinned(random, 0.0), {0.0, 25.0 * deg, 0.0});
  EXPECT_FALSE(setting.reachable);
  EXPECT_NE(setting.reason, "");
  TibialGuide bad = guide();
  bad.varus_axis_B = bad.flexion_axis_B;
  EXPECT_THROW(solve(bad, Pose::Identity(), {}), InvalidInput);
  bad = guide();
  bad.normal_B *= 2.0;
  EXPECT_THROW(display(bad, Pose::Identity(), {}), InvalidInput);
  EXPECT_THROW(adjust_by_screen(guide(), Pose::Identity(), {}, {}, 0.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::robot
