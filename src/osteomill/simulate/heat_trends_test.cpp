// SPDX-License-Identifier: BSD-3-Clause
// What the sources state about heat in milled bone, as trends of the whole chain: removal,
// engagement, forces, partition, conduction.
#include <gtest/gtest.h>

#include "osteomill/base/units.hpp"
#include "osteomill/simulate/bone_heat.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/remover.hpp"

namespace osteomill::simulate {
namespace {

using geometry::Vector3;
using units::mm;

enum class Mode { down, up };

/// A 6 mm end mill takes 2 mm off the side of cortical bone, 4 mm deep.
struct Cut {
  double feed = 4 * mm;  ///< m/s
  double speed_rpm = 10000.0;
  int teeth = 2;
  Mode mode = Mode::down;
  bool through = true;  ///< or stops 4 mm before the end of the bone
};

struct Heated {
  double hottest_left = 0.0;  ///< rise of the wall that remains, K
  double in_bone = 0.0;       ///< J
  double with_chips = 0.0;    ///< of patches beside no bone, J
  double work = 0.0;          ///< of the spindle, J
};

/// Bovine cortical bone at high speed, edge across the fibres: constants reconstructed from
/// [plaskos2006] tables 3.4 and 3.5.
cutting::CuttingLaw law() {
  cutting::CuttingLaw law;
  law.tangential = cutting::DirectionalLaw{cutting::LogLaw{0.42083, 0.58122, -0.06584}, {}};
  law.radial = cutting::DirectionalLaw{cutting::LogLaw{0.62379, 0.43160, -0.20553}, {}};
  law.orientation = cutting::OrientationCriterion::none;
  return law;
}

Heated mill(const Cut& cut, const thermal::PartitionOptions& partition = {}) {
  const double spacing = 0.5 * mm, length = 10 * mm, radial = 2 * mm, depth = 4 * mm;
  cutting::Cutter cutter;
  cutter.radius = 3 * mm;
  cutter.cutting_length = 6 * mm;
  cutter.flutes = cut.teeth;
  workpiece::Stock stock =
      workpiece::block({0, -7 * mm, -7 * mm}, {length, 0, 0}, {1900.0, 1.0}, spacing, 1 * mm);
  Vector3 from(-cutter.radius, cutter.radius - radial, -depth);
  Vector3 to(length + cutter.radius, from.y(), -depth);
  // Bone on the right of the feed: down-milling.
  if (cut.mode == Mode::up) std::swap(from, to);
  if (!cut.through) to.x() += (cut.mode == Mode::up ? 1.0 : -1.0) * (cutter.radius + 4 * mm);
  const double speed = cut.speed_rpm * units::rpm;
  const workpiece::ToolPath path = workpiece::line(from, to, {cut.feed, speed});
  BoneHeatOptions options;
  options.spacing = spacing;
  options.partition = partition;
  BoneHeat heat(stock, cutter, path, options);
  workpiece::Remover remover(stock, cutter);
  const workpiece::PatchGrid grid = workpiece::patches_for(cutter, spacing);
  const cutting::EngagedForce force(cutter, law(), grid.angles, grid.slices, grid.slice_height);
  const cutting::Condition condition{speed, cutting::feed_per_tooth(cut.feed, speed, cut.teeth)};
  Heated result;
  const double step = 0.25 * mm, time = step / cut.feed;
  for (double s = 0.0; s < path.length(); s += step) {
    const workpiece::ToolPose pose = path.at(s + step).pose();
    if (!remover.step(path.at(s).pose(), pose).contact()) {
      heat.rest(time);
      continue;
    }
    const std::vector<thermal::PatchCut> patches =
        patch_cuts(force, nullptr, cutter, remover.engagement(), condition, time);
    for (const thermal::PatchCut& patch : patches) result.work += patch.work;
    heat.advance(stock, pose.tip_W, remover.R_WT(), remover.engagement(), patches, time);
  }
  const BoneHeatSummary summary = heat.summary();
  result.hottest_left = summary.hottest_left - options.field.initial_temperature;
  result.in_bone = summary.heat_in_bone;
  result.with_chips = summary.unplaced_heat;
  return result;
}

TEST(HeatTrends, WhereTheCutterLeavesTheBoneItIsNotMuchHotterThanBefore) {
  // The last bone has a side less to conduct to, which could double its rise at most; it does not
  // get the heat of patches that have nothing beside them any more.
  for (const Mode mode : {Mode::down, Mode::up}) {
    const Heated through = mill({.mode = mode}), before = mill({.mode = mode, .through = false});
    EXPECT_LT(through.hottest_left, 1.5 * before.hottest_left);
    EXPECT_GT(through.with_chips, 0.0);
    EXPECT_LT(through.with_chips, 0.1 * through.in_bone);
  }
}

TEST(HeatTrends, AHigherFeedIsCooler) {
  // Krause 1982 by [plaskos2006] 3.5.4: 1.8, 3.7, 6.35 mm/s.
  double last = 1e9;
  for (const double feed : {1.8 * mm, 3.7 * mm, 6.35 * mm}) {
    const double rise = mill({.feed = feed}).hottest_left;
    EXPECT_LT(rise, 0.9 * last) << feed;
    last = rise;
  }
}

TEST(HeatTrends, MoreSpeedIsHotterAtTheSameFeed) {
  double last = 0.0;
  for (const double speed : {5000.0, 10000.0, 20000.0}) {
    const double rise = mill({.speed_rpm = speed}).hottest_left;
    EXPECT_GT(rise, 1.1 * last) << speed;
    last = rise;
  }
}

TEST(HeatTrends, MoreTeethAreHotterAtTheSameFeed) {
  double last = 0.0;
  for (const int teeth : {1, 2, 4}) {
    const double rise = mill({.teeth = teeth}).hottest_left;
    EXPECT_GT(rise, 1.1 * last) << teeth;
    last = rise;
  }
}

TEST(HeatTrends, UpMillingIsHotterThanDownMillingAtTheSameWork) {
  // [sugita2009] IV B: hotter, with little difference of the force. Chips of 6 µm; of thicker ones
  // the least chip is a smaller part, and the difference is, too.
  const Cut by_six_micrometres{.feed = 2 * mm};
  Cut up_cut = by_six_micrometres;
  up_cut.mode = Mode::up;
  const Heated down = mill(by_six_micrometres), up = mill(up_cut);
  EXPECT_NEAR(up.work, down.work, 1e-3 * down.work);
  EXPECT_GT(up.hottest_left, 1.1 * down.hottest_left);
  EXPECT_GT(up.in_bone, 1.05 * down.in_bone);
  // Ploughing makes the difference: without it the two are mirror images.
  thermal::PartitionOptions sharp;
  sharp.least_chip = 0.0;
  EXPECT_NEAR(mill(up_cut, sharp).hottest_left, mill(by_six_micrometres, sharp).hottest_left,
              0.02 * down.hottest_left);
}

}  // namespace
}  // namespace osteomill::simulate
