// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/placement_error.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "osteomill/base/error.hpp"

namespace osteomill::robot {
namespace {

using units::mm;

struct Case {
  GuidePositioner robot{.link1 = 60.0 * mm, .link2 = 30.0 * mm};
  PerCut<CutLine> lines = cut_lines(profile_of(generic_family(), 4));
  Placement best = place(robot, lines);
};

TEST(PlacementRisk, IsTheNominalGapWithoutErrors) {
  const Case c;
  const PlacementRisk risk = placement_risk(
      c.robot, c.lines, c.best.axis_position,
      {.position = 0.0, .varus_valgus = 0.0, .internal_external = 0.0, .samples = 100});
  EXPECT_EQ(risk.share_forbidden, 0.0);
  EXPECT_NEAR(risk.mean_gap, c.best.largest_gap, 1e-12);
  EXPECT_EQ(risk.gap_95, c.best.largest_gap);
}

TEST(PlacementRisk, IsHighAtTheTipAndFallsWithAMargin) {
  // [plaskos2006] 4.4.3: the optimum "would be a dangerous target to aim for".
  const Case c;
  const PlacementErrors errors{.position = 2.0 * mm};
  const PlacementRisk tip = placement_risk(c.robot, c.lines, c.best.axis_position, errors);
  EXPECT_GT(tip.share_forbidden, 0.4);
  const Placement safe = place(c.robot, c.lines, {.margin = 6.0 * mm});
  const PlacementRisk inside = placement_risk(c.robot, c.lines, safe.axis_position, errors);
  EXPECT_LT(inside.share_forbidden, 0.02);
  EXPECT_GT(inside.gap_95, inside.mean_gap);
}

TEST(PlacementRisk, DoesNotDependOnTheNumberOfThreads) {
  const Case c;
  const PlacementRisk many = placement_risk(c.robot, c.lines, c.best.axis_position, {});
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const PlacementRisk one = placement_risk(c.robot, c.lines, c.best.axis_position, {});
  EXPECT_EQ(many.share_forbidden, one.share_forbidden);
  EXPECT_EQ(many.mean_gap, one.mean_gap);
}

TEST(PlacementRisk, RefusesNegativeErrors) {
  const Case c;
  EXPECT_THROW(placement_risk(c.robot, c.lines, {0.0, 0.0}, {.position = -1.0}), InvalidInput);
  EXPECT_THROW(placement_risk(c.robot, c.lines, {0.0, 0.0}, {.varus_valgus = -1.0}), InvalidInput);
  EXPECT_THROW(placement_risk(c.robot, c.lines, {0.0, 0.0}, {.samples = 1}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::robot
