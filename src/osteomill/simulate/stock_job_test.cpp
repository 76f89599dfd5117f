// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/stock_job.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/simulate/milling.hpp"
#include "osteomill/simulate/summary.hpp"
#include "osteomill/workpiece/cut_surface.hpp"
#include "osteomill/workpiece/phantoms.hpp"

namespace osteomill::simulate {
namespace {

using geometry::Vector3;

constexpr double kSpacing = 0.25e-3;
const double kSpindle = 6000.0 * units::rpm;

cutting::Cutter cutter() { return {cutting::CutterShape::cylindrical, 3e-3, 2, 0.5, 0.0, 10e-3}; }

/// F = 60 N/mm² h + 2 N/mm tangential, half of it radial, a fifth lateral.
cutting::CuttingLaw law() {
  cutting::CuttingLaw law;
  law.tangential = {cutting::LinearLaw{60e6, 2e3}, {}};
  law.radial = {cutting::LinearLaw{30e6, 1e3}, {}};
  law.lateral = cutting::DirectionalLaw{cutting::LinearLaw{12e6, 0.0}, {}};
  law.orientation = cutting::OrientationCriterion::none;
  return law;
}

workpiece::Stock block(double force_scale = 1.0) {
  return workpiece::block({0.0, -6e-3, -6e-3}, {20e-3, 6e-3, 0.0}, {1900.0, force_scale}, kSpacing,
                          0.5e-3);
}

/// A slot 3 mm deep through the block, 4 mm/s.
StockJob slot() {
  return {cutter(), law(),
          workpiece::line({-6e-3, 0.0, -3e-3}, {26e-3, 0.0, -3e-3}, {4e-3, kSpindle})};
}

Machine machine() {
  Machine machine;
  machine.spindle_speed = kSpindle;
  machine.start_feed = 4e-3;
  return machine;
}

std::vector<Step> mill(StockWorkpiece& workpiece, double feed) {
  Milling milling(workpiece, machine(), 30.0);
  while (!milling.finished()) milling.advance({feed, 0, false});
  return milling.steps();
}

Vector3 mean_force_in_the_middle(const std::vector<Step>& steps) {
  Vector3 mean = Vector3::Zero();
  int count = 0;
  for (const Step& step : steps) {
    if (step.tip_W.x() < 6e-3 || step.tip_W.x() > 14e-3) continue;
    mean += step.mean_force_W;
    ++count;
  }
  return mean / count;
}

TEST(StockWorkpiece, MeanForceInASlotIsThatOfTheNominalCut) {
  StockWorkpiece workpiece(block(), slot());
  const std::vector<Step> steps = mill(workpiece, 4e-3);
  const cutting::Condition condition{kSpindle, cutting::feed_per_tooth(4e-3, kSpindle, 2)};
  const Vector3 expected =
      cutting::mean_load(cutter(), law(), condition, {cutting::ImmersionKind::slot, 0.0, 3e-3})
          .force;
  const Vector3 mean = mean_force_in_the_middle(steps);
  // Voxel engagement against the analytic one: 2 % of the resultant at 12 voxels a radius; the
  // feed is along x, so the tool frame is the work frame.
  EXPECT_LT((mean - expected).norm(), 0.02 * expected.norm()) << mean << "\n" << expected;
}

TEST(StockWorkpiece, AToolThatBendsLeavesTheSlotBesideItsPathByItsDeflection) {
  StockJob job = slot();
  job.tool = accuracy::ToolCompliance::cantilever(40e-3, 3e-3, 200e9);
  const workpiece::Stock before = block();
  StockWorkpiece workpiece(before, job);
  const std::vector<Step> steps = mill(workpiece, 4e-3);
  const Vector3 mean = mean_force_in_the_middle(steps);
  double walls = 0.0;
  for (const double side : {-1.0, 1.0}) {
    double sum = 0.0, weight = 0.0;
    for (const workpiece::CutPoint& p : workpiece::cut_surface(before, workpiece.stock())) {
      if (p.normal_W.y() * side > -0.99 || p.p_W.x() < 6e-3 || p.p_W.x() > 14e-3) continue;
      if (p.p_W.z() < -2.5e-3) continue;
      sum += p.p_W.y();
      weight += 1.0;
    }
    ASSERT_GT(weight, 50.0);
    walls += 0.5 * sum / weight;
  }
  // The line of action of a slot 3 mm deep lies at its middle, give or take the lag of the helix.
  const double expected = job.tool->between(1.5e-3, 1.5e-3) * mean.y();
  EXPECT_GT(std::abs(expected), 20e-6);
  EXPECT_NEAR(walls, expected, 0.03 * std::abs(expected));
  // On the way in, where only a part of the front is in bone, it may bend farther.
  EXPECT_GT(workpiece.bent_tool().largest, std::abs(expected));
  EXPECT_LT(workpiece.bent_tool().mean, workpiece.bent_tool().largest);
  // A rigid tool leaves it where the path is.
  StockWorkpiece rigid(before, slot());
  mill(rigid, 4e-3);
  EXPECT_EQ(rigid.bent_tool().largest, 0.0);
}

TEST(StockWorkpiece, ForceTurnsWithTheFeed) {
  const auto mean_of = [](const Vector3& from, const Vector3& to) {
    StockWorkpiece workpiece(workpiece::block({-10e-3, -10e-3, -6e-3}, {10e-3, 10e-3, 0.0},
                                              {1900.0, 1.0}, kSpacing, 0.5e-3),
                             {cutter(), law(), workpiece::line(from, to, {4e-3, kSpindle})});
    Vector3 mean = Vector3::Zero();
    for (const Step& step : mill(workpiece, 4e-3)) mean += step.mean_force_W;
    return mean;
  };
  const Vector3 along_x = mean_of({-15e-3, 0.0, -3e-3}, {15e-3, 0.0, -3e-3});
  const Vector3 along_y = mean_of({0.0, -15e-3, -3e-3}, {0.0, 15e-3, -3e-3});
  // The grid is the same seen from x and y; only the shares of neighbouring cells are rounded.
  EXPECT_NEAR(along_y.x(), -along_x.y(), 1e-3 * along_x.norm());
  EXPECT_NEAR(along_y.y(), along_x.x(), 1e-3 * along_x.norm());
}

TEST(StockWorkpiece, ForceDensityAndRemovalAreNowhereInAir) {
  StockWorkpiece workpiece(block(), slot());
  int air = 0;
  for (const Step& step : mill(workpiece, 4e-3)) {
    // The cutter reaches 3 mm ahead of and behind its axis; one voxel of blur.
    const bool outside = step.tip_W.x() < -3e-3 - kSpacing || step.tip_W.x() > 23e-3 + kSpacing;
    if (!outside) continue;
    ++air;
    EXPECT_EQ(step.peak_force, 0.0);
    EXPECT_EQ(step.mean_torque, 0.0);
    EXPECT_EQ(step.removed_volume, 0.0);
    EXPECT_EQ(step.material, 0.0);
    EXPECT_EQ(step.samples_in_contact, 0);
  }
  EXPECT_GT(air, 50);
}

TEST(StockWorkpiece, WhatIsRemovedIsMissingFromTheStock) {
  StockWorkpiece workpiece(block(), slot());
  const Summary summary = summarise(mill(workpiece, 4e-3), workpiece.lines(), Status::finished);
  EXPECT_NEAR(summary.removed_volume,
              workpiece.stock().initial_volume() - workpiece.stock().remaining_volume(),
              1e-9 * summary.removed_volume);
  EXPECT_NEAR(summary.removed_volume / (6e-3 * 3e-3 * 20e-3), 1.0, 0.01);
}

TEST(StockWorkpiece, WorkIsTheTorqueAndTheFeedForceTimesTheirVelocities) {
  StockWorkpiece workpiece(block(), slot());
  const std::vector<Step> steps = mill(workpiece, 4e-3);
  const Summary summary = summarise(steps, workpiece.lines(), Status::finished);
  double spindle = 0.0;
  double feed = 0.0;
  for (const Step& step : steps) {
    spindle += step.mean_torque * kSpindle * 10e-3;
    feed -= step.mean_force_W.x() * step.feed * 10e-3;
  }
  // Constant feed and speed: the sums differ by rounding only.
  EXPECT_NEAR(spindle / summary.spindle_work, 1.0, 1e-9);
  EXPECT_NEAR(feed / summary.feed_work, 1.0, 1e-9);
  // The spindle's work is the tangential force times the way of the edges: with F_t = k h + e over
  // half a turn, an edge element does k f_z + e pi/2 ... per turn, times depth and edges.
  const double f_z = cutting::feed_per_tooth(4e-3, kSpindle, 2);
  const double torque = 2.0 * 3e-3 * 3e-3 * (60e6 * f_z * 2.0 + 2e3 * M_PI) / (2.0 * M_PI);
  const double contact_time = 20e-3 / 4e-3;  // whole slot, entry and exit make up for each other
  EXPECT_NEAR(summary.spindle_work / (torque * kSpindle * contact_time), 1.0, 0.03);
}

TEST(StockWorkpiece, ForceFollowsTheLocalStrength) {
  StockWorkpiece full(block(1.0), slot());
  StockWorkpiece half(block(0.5), slot());
  const Summary strong = summarise(mill(full, 4e-3), 1, Status::finished);
  const Summary weak = summarise(mill(half, 4e-3), 1, Status::finished);
  EXPECT_NEAR(weak.mean_force / strong.mean_force, 0.5, 1e-6);  // single-precision weights
}

TEST(StockWorkpiece, KnowsWhereItWillTouchTheBone) {
  const StockWorkpiece workpiece(block(), slot());
  // The edge of the block is 6 mm ahead of the tip, the cutter reaches 3 mm ahead; the path is
  // searched in steps of a voxel.
  EXPECT_NEAR(workpiece.to_contact(0.0), 3e-3, 1.5 * kSpacing);
  EXPECT_LT(workpiece.to_contact(10e-3), 0.0);
  // A cutter of D 6 mm is as deep in as it gets when its axis has come to the edge, 6 mm on.
  EXPECT_GT(workpiece.to_engagement(4e-3), 0.0);
  EXPECT_LT(workpiece.to_engagement(6.2e-3), 0.0);
  EXPECT_LT(workpiece.to_contact(workpiece.length()), 0.0);
}

TEST(StockWorkpiece, LinesAndRapidsComeFromThePath) {
  workpiece::Lines two;
  two.start_W = {-6e-3, 0.0, -1e-3};
  two.along_W = {32e-3, 0.0, 0.0};
  two.step_over_W = {0.0, 2e-3, 0.0};
  two.count = 2;
  StockJob job{cutter(), law(), workpiece::lines(two, {4e-3, kSpindle})};
  job.rapid_feed = 20e-3;
  const StockWorkpiece workpiece(block(), job);
  EXPECT_EQ(workpiece.lines(), 2);
  EXPECT_EQ(workpiece.at(0.0).line, 0);
  EXPECT_EQ(workpiece.at(0.0).programmed_feed, 4e-3);
  EXPECT_EQ(workpiece.at(40e-3).programmed_feed, 20e-3);
  EXPECT_EQ(workpiece.at(workpiece.length()).line, 1);
}

TEST(StockWorkpiece, ARapidSlowsDownToTheFeedOfTheCutBehindIt) {
  const workpiece::Move cut{workpiece::MoveKind::cut,
                            {Vector3(-6e-3, 0.0, -1e-3), Vector3(26e-3, 0.0, -1e-3)},
                            4e-3,
                            kSpindle,
                            1};
  StockJob job{cutter(), law(),
               workpiece::ToolPath({{workpiece::MoveKind::rapid,
                                     {Vector3(-66e-3, 0.0, -1e-3), Vector3(-6e-3, 0.0, -1e-3)},
                                     0.0,
                                     kSpindle,
                                     1},
                                    cut})};
  job.rapid_feed = 100e-3;
  StockWorkpiece workpiece(block(), job);
  Machine slow = machine();
  slow.servo = numerics::SecondOrderLag{118.0, 0.7};
  Milling milling(workpiece, slow, 30.0);
  double fastest = 0.0;
  while (milling.report().rapid) {
    milling.advance({milling.report().programmed_feed, 0, false});
    fastest = std::max(fastest, milling.report().feed);
  }
  EXPECT_GT(fastest, 0.99 * job.rapid_feed);
  // At most the lag of servo and control, some 25 ms, too fast when the cut begins: of a feed that
  // falls by kBraking = 15 1/s.
  EXPECT_LT(milling.report().feed, 1.5 * cut.feed_rate);
}

/// A pass whose tool leans towards a ball beside it.
StockJob leaning_slot(double lean) {
  StockJob job = slot();
  const Vector3 axis(0.0, std::sin(lean), std::cos(lean));
  job.path = workpiece::ToolPath({{workpiece::MoveKind::cut,
                                   {Vector3(-6e-3, 0.0, -2e-3), Vector3(26e-3, 0.0, -2e-3)},
                                   4e-3,
                                   kSpindle,
                                   1,
                                   {axis, axis}}});
  return job;
}

TEST(StockWorkpiece, WatchesTheDistanceOfALeaningToolToANoGoRegion) {
  const double lean = 0.35, ball_radius = 1e-3;
  const Vector3 ball(10e-3, 14e-3, 20e-3);
  StockJob job = leaning_slot(lean);
  job.no_go = {workpiece::no_go_ball("vessel", ball, ball_radius, 0.0)};
  const Vector3 axis = job.path.at(0.0).axis_W;
  StockWorkpiece workpiece(block(), job);
  double least = 1.0;
  for (const Step& step : mill(workpiece, 8e-3)) EXPECT_EQ(step.axis_W, axis);
  StockWorkpiece again(block(), job);
  Milling milling(again, machine(), 30.0);
  while (!milling.finished()) {
    const Report seen = milling.advance({8e-3, 0, false});
    // The ball is beside the shank all along.
    const Vector3 way = ball - job.path.at(std::min(seen.position, again.length())).position_W;
    const double truth = (way - axis.dot(way) * axis).norm() - cutter().radius - ball_radius;
    // Never more than there is, but for the 10 µm of nearest_approach(); worked out anew when a
    // tenth of it, or 0.1 mm, has been travelled.
    EXPECT_LE(seen.no_go_distance, truth + 10e-6);
    EXPECT_GE(seen.no_go_distance, truth - std::max(0.2 * truth, 0.2e-3) - 10e-6);
    least = std::min(least, seen.no_go_distance);
  }
  // Upright, the tool would pass 10 mm from it.
  const double nearest =
      std::abs(ball.y() * std::cos(lean) - (ball.z() + 2e-3) * std::sin(lean)) - 4e-3;
  EXPECT_NEAR(least, nearest, 0.2e-3 + 0.2 * nearest);
  EXPECT_LT(least, 0.5 * (14e-3 - 4e-3));
}

TEST(StockWorkpiece, RefusesAPathThatNeverMeetsTheBone) {
  StockJob job = slot();
  job.path = workpiece::line({-6e-3, 0.0, 5e-3}, {26e-3, 0.0, 5e-3}, {4e-3, kSpindle});
  EXPECT_THROW(StockWorkpiece(block(), job), InvalidInput);
}

}  // namespace
}  // namespace osteomill::simulate
