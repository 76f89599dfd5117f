// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/force_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/engaged_force.hpp"
#include "osteomill/simulate/milling.hpp"
#include "osteomill/simulate/stock_job.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/remover.hpp"
#include "osteomill/workpiece/swing.hpp"

namespace osteomill::simulate {
namespace {

using geometry::Vector3;
using units::mm;

constexpr double kTangential = 60e6, kTangentialEdge = 2e3, kRadial = 30e6, kRadialEdge = 1e3;

cutting::CuttingLaw linear_law() {
  cutting::CuttingLaw law;
  law.tangential = {cutting::LinearLaw{kTangential, kTangentialEdge}, {}};
  law.radial = {cutting::LinearLaw{kRadial, kRadialEdge}, {}};
  law.orientation = cutting::OrientationCriterion::none;
  return law;
}

/// Effective rake 10°, from the means of [plaskos2006] tables 3.4 and 3.5: see data/.
cutting::CuttingLaw log_law() {
  cutting::CuttingLaw law;
  law.tangential = {cutting::LogLaw{0.42083, 0.58122, -0.06584},
                    cutting::LogLaw{0.27242, 0.66537, -0.08710}};
  law.radial = {cutting::LogLaw{0.62379, 0.43160, -0.20553},
                cutting::LogLaw{0.64731, 0.17764, -0.06681}};
  return law;
}

/// A guide 20 mm before the middle of the side x = 0 of a plane of 40 x 40 mm.
ForceMapOptions guide(const cutting::CuttingLaw& law) {
  ForceMapOptions o;
  o.poses.pivot_W = {-20 * mm, 0.0, 0.0};
  o.poses.first_angle = -40 * units::deg;
  o.poses.last_angle = 40 * units::deg;
  o.poses.angle_step = 5 * units::deg;
  o.poses.first_insertion = 10 * mm;
  o.poses.last_insertion = 70 * mm;
  o.poses.insertion_step = 5 * mm;
  o.cutter = {cutting::CutterShape::cylindrical, 3 * mm, 2, 0.5, 0.0, 15 * mm};
  o.law = law;
  o.spindle_speed = 6000 * units::rpm;
  o.axial_depth = 10 * mm;
  return o;
}

workpiece::Stock plateau(double force_scale = 1.0, double spacing = 0.5 * mm) {
  return workpiece::block({0.0, -20 * mm, -5 * mm}, {40 * mm, 20 * mm, 10 * mm},
                          {1900.0, force_scale}, spacing, 1 * mm);
}

std::size_t middle(const ForceMap& map, double insertion) {
  for (std::size_t j = 0; j < map.insertions().size(); ++j)
    if (std::abs(map.insertions()[j] - insertion) < 1e-9)
      return map.index(map.angles().size() / 2, j);
  throw std::logic_error("no such insertion");
}

TEST(ForceMap, IsTheAnalyticMeanOfASlotInBoneOfOneDensity) {
  const ForceMapOptions o = guide(linear_law());
  const ForceMap map(plateau(), o);
  ASSERT_TRUE(map.linear());
  const double insertion = 45 * mm, feed = 8e-3;
  const PoseForces forces = map.at(feed);
  const std::size_t pose = middle(map, insertion);
  const double edges = o.cutter.flutes * o.axial_depth;
  // The guide turns: the chip's mean over the groove is that of its middle.
  const double chip = cutting::feed_per_tooth(feed, o.spindle_speed, o.cutter.flutes) *
                      (1.0 - 0.5 * o.axial_depth / insertion);
  const double normal = edges * (kTangential * chip / 4 + kTangentialEdge / std::numbers::pi);
  const double push = edges * (kRadial * chip / 4 + kRadialEdge / std::numbers::pi);
  // Patches of 5° by their middles: (5°)²/24 of the value.
  const double tolerance = 4e-4;
  EXPECT_NEAR(forces.normal[pose], normal, tolerance * normal);
  EXPECT_NEAR(forces.feed[pose], push, tolerance * push);
  EXPECT_FLOAT_EQ(map.contact()[pose], 1.0F);
}

TEST(ForceMap, PullsTheToolIntoTheBoneWhereItLiftsItWhenTheSwingIsReversed) {
  ForceMapOptions o = guide(linear_law());
  const PoseForces down = ForceMap(plateau(), o).at(5e-3);
  o.milling = workpiece::Milling::up;
  const ForceMap reversed(plateau(), o);
  const PoseForces up = reversed.at(5e-3);
  const std::size_t pose = middle(reversed, 40 * mm);
  EXPECT_GT(down.normal[pose], 1.0F);
  EXPECT_NEAR(up.normal[pose], -down.normal[pose], 1e-4 * down.normal[pose]);
  EXPECT_NEAR(up.feed[pose], down.feed[pose], 1e-4 * down.feed[pose]);
}

TEST(ForceMap, GrowsInProportionToTheForceScaleOfTheBone) {
  for (const cutting::CuttingLaw& law : {linear_law(), log_law()}) {
    // Density twice the reference under the law of strength: (2)² (bone::ForceDensityLaw).
    const ForceMap reference(plateau(1.0), guide(law)), dense(plateau(4.0), guide(law));
    const PoseForces a = reference.at(6e-3), b = dense.at(6e-3);
    // Values are kept in single precision.
    for (std::size_t i = 0; i < a.normal.size(); ++i) {
      EXPECT_NEAR(b.normal[i], 4.0F * a.normal[i], 1e-5F * std::abs(b.normal[i]) + 1e-9F);
      EXPECT_NEAR(b.feed[i], 4.0F * a.feed[i], 1e-5F * std::abs(b.feed[i]) + 1e-9F);
    }
  }
}

TEST(ForceMap, IsZeroOutsideTheBone) {
  const ForceMap map(plateau(), guide(linear_law()));
  const PoseForces forces = map.at(10e-3);
  int outside = 0;
  for (std::size_t i = 0; i < map.angles().size(); ++i)
    for (std::size_t j = 0; j < map.insertions().size(); ++j) {
      // The tool reaches 10 mm back from its tip, and its radius and a voxel to the sides.
      const Vector3 p = map.place_W(i, j);
      if (p.x() > -4 * mm && p.x() < 54 * mm && std::abs(p.y()) < 34 * mm) continue;
      ++outside;
      const std::size_t pose = map.index(i, j);
      EXPECT_EQ(forces.normal[pose], 0.0F);
      EXPECT_EQ(forces.feed[pose], 0.0F);
      EXPECT_EQ(map.contact()[pose], 0.0F);
    }
  EXPECT_GT(outside, 10);
}

TEST(ForceMap, OfASymmetricBoneIsItsMirrorImageForTheReversedSwing) {
  ForceMapOptions o = guide(log_law());
  o.fibre_W = Vector3::UnitX();
  const ForceMap one(plateau(), o);
  o.milling = workpiece::Milling::up;
  const ForceMap other(plateau(), o);
  // The mirror image of a clockwise cutter turns the other way: what is a mirror image is what
  // each pose meets, and with it the push of a slot whose force is along the feed by symmetry.
  const std::size_t angles = one.angles().size();
  const PoseForces forces = one.at(6e-3);
  int whole = 0;
  for (std::size_t i = 0; i < angles; ++i)
    for (std::size_t j = 0; j < one.insertions().size(); ++j) {
      const std::size_t pose = one.index(i, j), mirrored = one.index(angles - 1 - i, j);
      EXPECT_NEAR(one.contact()[pose], other.contact()[mirrored], 1e-6);
      // All of the groove, with a radius and a voxel around it, is within the plateau.
      const Vector3 tip = one.place_W(i, j);
      const Vector3 back = one.place_W(i, j - std::min<std::size_t>(j, 2));
      if (j < 2 || tip.x() > 36 * mm || back.x() < 4 * mm || std::abs(tip.y()) > 14 * mm) continue;
      // Where the front is all in bone, the same swing is the same on both sides.
      ++whole;
      EXPECT_NEAR(forces.normal[pose], forces.normal[mirrored], 1e-5 * forces.normal[pose]);
      EXPECT_NEAR(forces.feed[pose], forces.feed[mirrored], 1e-5 * forces.feed[pose]);
    }
  EXPECT_GT(whole, 20);
}

TEST(ForceMap, AFeedBetweenTheNodesIsThatOfAMapMadeForIt) {
  ForceMapOptions o = guide(log_law());
  const ForceMap map(plateau(), o);
  EXPECT_FALSE(map.linear());
  for (const double feed : {0.3e-3, 1.7e-3, 6.1e-3, 17e-3}) {
    o.largest_feed = feed;
    const PoseForces direct = ForceMap(plateau(), o).node(map.feeds().size() - 1);
    const PoseForces mixed = map.at(feed);
    for (std::size_t i = 0; i < direct.normal.size(); ++i) {
      // What the header promises, of the pose's own force.
      const double size = std::hypot(direct.normal[i], direct.feed[i]);
      EXPECT_NEAR(mixed.normal[i], direct.normal[i], 1e-3 * size);
      EXPECT_NEAR(mixed.feed[i], direct.feed[i], 1e-3 * size);
    }
  }
}

TEST(ForceMap, AtTheLargestFeedTheForceIsTheLimit) {
  for (const cutting::CuttingLaw& law : {linear_law(), log_law()}) {
    const ForceMap map(plateau(), guide(law));
    const std::size_t pose = middle(map, 45 * mm);
    const PoseForces forces = map.at(5e-3);
    const double limit = Vector3(forces.normal[pose], forces.feed[pose], forces.axial[pose]).norm();
    const std::vector<float> largest = map.largest_feeds(LimitedForce::resultant, limit);
    EXPECT_NEAR(largest[pose], 5e-3, 1e-5 * 5e-3);  // single precision, bisection to 1e-6
    // In air any feed is allowed, and a limit below the edge forces allows none.
    EXPECT_FLOAT_EQ(largest[map.index(0, 0)], 20e-3F);
    EXPECT_EQ(map.largest_feeds(LimitedForce::resultant, 0.01)[pose], 0.0F);
    EXPECT_GE(map.largest_feeds(LimitedForce::feed, limit)[pose], largest[pose]);
  }
}

/// Bone whose strength changes along the cut, with a step of height in it.
workpiece::Stock uneven(double spacing) {
  return workpiece::Stock(
      workpiece::cubes_over({-12 * mm, -8 * mm, -8 * mm}, {12 * mm, 8 * mm, 1 * mm}, spacing),
      [](const Vector3& p) {
        const double top = p.x() < 3 * mm ? 0.0 : -1 * mm;
        const double outside =
            std::max({p.z() - top, std::abs(p.x()) - 10 * mm, std::abs(p.y()) - 7 * mm});
        // In steps of 1 %, since materials are counted.
        const double scale = 0.01 * std::round(100.0 * (1.0 + 0.05 * p.x() / mm));
        return workpiece::BoneSample{outside, {1900.0, scale}};
      });
}

TEST(ForceMap, IsWhatMillingAlongTheSwingFinds) {
  // The guide stands 2 m above, so that its swing is a straight slot of 3 mm depth along x, with
  // the tool upright; the wall y = -3 mm is the cutting plane.
  const double spacing = 0.2 * mm, feed = 6e-3, far = 2.0;
  ForceMapOptions o = guide(log_law());
  o.axial_depth = 3 * mm;
  o.largest_feed = feed;
  o.poses.pivot_W = {0.0, -3 * mm, far - 3 * mm};
  o.poses.normal_W = Vector3::UnitY();
  o.poses.forward_W = -Vector3::UnitZ();
  o.poses.first_insertion = o.poses.last_insertion = far;
  o.poses.first_angle = -8 * mm / far;
  o.poses.last_angle = 8 * mm / far;
  o.poses.angle_step = spacing / far;
  const ForceMap map(uneven(spacing), o);
  const PoseForces expected = map.at(feed);

  workpiece::Stock stock = uneven(spacing);
  workpiece::Remover remover(stock, o.cutter);
  const workpiece::PatchGrid patches = workpiece::patches_for(o.cutter, spacing);
  const cutting::EngagedForce force(o.cutter, o.law, patches.angles, patches.slices,
                                    patches.slice_height);
  cutting::Condition condition{o.spindle_speed, cutting::feed_per_tooth(feed, o.spindle_speed, 2)};
  condition.fibre_T = Vector3::UnitX();
  double worst = 0.0, sum_of_map = 0.0, sum_of_milling = 0.0;
  Vector3 tip(-14 * mm, 0.0, -3 * mm);
  // Down-milling leaves the wall at -y of the tool: the feed is along +x.
  while (tip.x() < 8 * mm - 1e-9) {
    const Vector3 next = tip + Vector3(spacing, 0.0, 0.0);
    remover.step(tip, next);
    tip = next;
    // What the remover delivers is late by a voxel (ShadowMap): it belongs to the place before.
    const double angle = -(tip.x() - spacing) / far;  // about +y, from -z
    // A radius before the bone ends.
    if (tip.x() < -8 * mm + 2 * spacing || tip.x() > 6.6 * mm) continue;
    const auto i =
        static_cast<std::size_t>(std::lround((angle - o.poses.first_angle) / o.poses.angle_step));
    const Vector3 mean = force.mean(remover.engagement(), condition).force;
    sum_of_map += expected.normal[i];
    sum_of_milling += mean.y();
    // Where the height steps, over a radius, the two look at the edge a voxel apart.
    if (std::abs(tip.x() - 1.5 * mm) < 2.5 * mm) continue;
    const double size = std::hypot(expected.normal[i], expected.feed[i]);
    worst = std::max(
        worst, std::hypot(mean.y() - expected.normal[i], -mean.x() - expected.feed[i]) / size);
  }
  // Two samplings of one bone: patches of 5° and slices of half a millimetre against the voxels'
  // engagement, which has 0.2 % of grain from step to step.
  EXPECT_LT(worst, 0.005);
  EXPECT_NEAR(sum_of_map, sum_of_milling, 0.005 * sum_of_milling);
}

TEST(ForceMap, IsWhatASimulatedSwingOfTheGuideFinds) {
  // Three swings to and fro through bone that is stronger on one side and has a step in its height;
  // the guide is advanced by a groove after each. The spindle turns once in a control period.
  const double spacing = 0.4 * mm, feed = 12e-3;
  const auto bone = [&] {
    return workpiece::Stock(
        workpiece::cubes_over({13 * mm, -24 * mm, -4 * mm}, {44 * mm, 24 * mm, 6 * mm}, spacing),
        [](const Vector3& p) {
          const double top = p.y() < 4 * mm ? 5 * mm : 3 * mm;
          const double outside =
              std::max({p.z() - top, -3 * mm - p.z(), std::abs(p.y()) - 23 * mm, 14 * mm - p.x()});
          // In steps of 1 %, since materials are counted.
          const double scale = 0.01 * std::round(100.0 * (1.0 + 0.02 * p.y() / mm));
          return workpiece::BoneSample{outside, {1900.0, scale}};
        });
  };
  ForceMapOptions o = guide(log_law());
  o.poses.pivot_W = Vector3::Zero();
  o.poses.first_angle = -28 * units::deg;
  o.poses.last_angle = 28 * units::deg;
  o.poses.angle_step = 1 * units::deg;
  o.largest_feed = feed;
  workpiece::Swing swing;
  swing.pivot_W = {0.0, 0.0, o.cutter.radius};
  swing.first_angle = o.poses.first_angle;
  swing.last_angle = o.poses.last_angle;
  swing.first_insertion = 20 * mm;
  swing.last_insertion = 40 * mm;
  swing.advance = o.axial_depth;
  swing.there_and_back = false;
  StockWorkpiece workpiece(
      bone(), {o.cutter, o.law, workpiece::swing_and_advance(swing, {feed, o.spindle_speed})});
  Machine machine;
  machine.spindle_speed = o.spindle_speed;
  machine.start_feed = feed;
  Milling milling(workpiece, machine, 30.0);
  while (!milling.finished()) milling.advance({feed, 0, false});

  // The second swing goes back, down-milling; the third forth, up-milling.
  for (const int line : {1, 2}) {
    o.milling = line == 1 ? workpiece::Milling::down : workpiece::Milling::up;
    const double insertion = swing.first_insertion + line * swing.advance;
    o.poses.first_insertion = o.poses.last_insertion = insertion;
    const ForceMap map(bone(), o);
    const PoseForces expected = map.at(feed);
    double square = 0.0, size = 0.0, length = 0.0;
    Eigen::Vector2d difference = Eigen::Vector2d::Zero();  // normal, push
    int compared = 0;
    for (const Step& step : milling.steps()) {
      const Vector3 from_pivot = step.tip_W - swing.pivot_W;
      const double angle = std::atan2(from_pivot.y(), from_pivot.x());
      if (step.line != line || std::abs(from_pivot.norm() - insertion) > 1e-5) continue;
      // More than a radius of the cutter inside the border of the cut.
      if (std::abs(angle) > 18 * units::deg) continue;
      const double place = (angle - o.poses.first_angle) / o.poses.angle_step;
      const auto i = static_cast<std::size_t>(place);
      const double part = place - static_cast<double>(i);
      const Eigen::Vector2d low(expected.normal[i], expected.feed[i]);
      const Eigen::Vector2d high(expected.normal[i + 1], expected.feed[i + 1]);
      const Eigen::Vector2d mapped = (1.0 - part) * low + part * high;
      const Vector3 along =
          (line == 1 ? -1.0 : 1.0) * Vector3::UnitZ().cross(from_pivot) / insertion;
      const Eigen::Vector2d found(step.mean_force_W.z(), -step.mean_force_W.dot(along));
      difference += found - mapped;
      square += (found - mapped).squaredNorm();
      size += mapped.squaredNorm();
      length += mapped.norm();
      ++compared;
    }
    ASSERT_GT(compared, 100);
    // 7.5 voxels a radius, in a swing oblique to the grid; half of it with half the voxels.
    EXPECT_LT(std::sqrt(square / size), 0.04);
    EXPECT_LT(difference.norm(), 0.03 * length);
  }
}

TEST(ForceMap, RefusesWhatIsNoMapWithAllFaultsAtOnce) {
  ForceMapOptions o = guide(linear_law());
  o.axial_depth = 20 * mm;  // longer than the cutter
  o.poses.last_angle = -1.0;
  o.poses.normal_W = o.poses.forward_W;
  o.spindle_speed = 0.0;
  try {
    const ForceMap map(plateau(), o);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.faults().size(), 4U) << error.what();
    EXPECT_NE(std::string(error.what()).find("cutting length"), std::string::npos);
  }
  o = guide(linear_law());
  o.poses.angle_step = 1e-6;
  EXPECT_THROW(ForceMap(plateau(), o), InvalidInput);
  const ForceMap map(plateau(), guide(log_law()));
  EXPECT_THROW(map.at(0.0), InvalidInput);
  EXPECT_THROW(map.at(1.0), InvalidInput);
  EXPECT_THROW(map.largest_feeds(LimitedForce::normal, 0.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::simulate
