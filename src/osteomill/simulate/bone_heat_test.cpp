// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/bone_heat.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/thermal/thermal_dose.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/remover.hpp"

namespace osteomill::simulate {
namespace {

using geometry::Vector3;
using units::mm;

cutting::Cutter cutter() {
  cutting::Cutter cutter;
  cutter.radius = 1.5 * mm;
  cutter.cutting_length = 8 * mm;
  return cutter;
}

workpiece::ToolPath slot() {
  return workpiece::line({-3 * mm, 0, -3 * mm}, {12 * mm, 0, -3 * mm}, {4 * mm, 600.0});
}

struct Outcome {
  BoneHeatSummary summary;
  double left = 0.0;  ///< energy in the bone that is left, J
};

/// A slot with a constant power in contact, at a feed.
Outcome mill(double power, double feed, double convection, double chip = 30e-6) {
  workpiece::Stock stock = workpiece::block({0, -6 * mm, -8 * mm}, {15 * mm, 6 * mm, 0},
                                            {1900.0, 1.0}, 0.3 * mm, 1 * mm);
  BoneHeatOptions options;
  options.spacing = 0.6 * mm;
  options.field.convection = convection;
  BoneHeat heat(stock, cutter(), slot(), options);
  workpiece::Remover remover(stock, cutter());
  const double step = 0.15 * mm;
  for (double s = 0.0; s < slot().length(); s += step) {
    const Vector3 to = slot().at(s + step).position_W;
    const workpiece::Removal removal = remover.step(slot().at(s).position_W, to);
    const cutting::Engagement& engagement = remover.engagement();
    // By the volume that each patch cuts.
    std::vector<thermal::PatchCut> patches(engagement.weights.size());
    double sum = 0.0;
    for (std::size_t at = 0; at < patches.size() && removal.contact(); ++at) {
      const auto angle = static_cast<double>(at % static_cast<std::size_t>(engagement.angles));
      const double theta = 2.0 * std::numbers::pi * (angle + 0.5) / engagement.angles;
      patches[at] = {engagement.weights[at] * std::max(0.0, std::sin(theta)), 0.0, 3.0, chip};
      sum += patches[at].work;
    }
    for (thermal::PatchCut& patch : patches)
      if (sum > 0.0) patch.work *= power * step / feed / sum;
    heat.advance(stock, to, remover.R_WT(), engagement, patches, step / feed);
  }
  return {heat.summary(), heat.field().energy()};
}

TEST(BoneHeat, PutsTheShareOfTheBoneIntoBoneAndLosesNothing) {
  const Outcome dry = mill(20.0, 4 * mm, 0.0);
  // 13.5 mm of contact at 4 mm/s and 20 W; the share of the shear heat that stays in the bone.
  const double chip = thermal::chip_share(thermal::kCorticalBone.diffusivity(), 2.0, 3.0, 30e-6);
  const double expected = 20.0 * (13.5 / 4.0) * 0.75 * (1.0 - chip);
  // Contact begins and ends within a step of 1 % and half a voxel.
  EXPECT_NEAR(dry.summary.heat_in_bone + dry.summary.unplaced_heat, expected, 0.03 * expected);
  EXPECT_LT(dry.summary.unplaced_heat, 0.1 * expected) << "with the last chips only";
  EXPECT_GT(dry.left, 0.0);
  EXPECT_LT(dry.left, dry.summary.heat_in_bone) << "cut bone takes heat along";
}

TEST(BoneHeat, IsLessWithThickerChipsAndIrrigationMoreWithPower) {
  const Outcome usual = mill(10.0, 2 * mm, 10.0);
  EXPECT_LT(mill(10.0, 2 * mm, 10.0, 90e-6).summary.heat_in_bone, usual.summary.heat_in_bone);
  const Outcome strong = mill(40.0, 2 * mm, 10.0), wet = mill(40.0, 2 * mm, 5000.0);
  EXPECT_GT(strong.summary.hottest, usual.summary.hottest);
  EXPECT_GT(strong.summary.hottest_left, usual.summary.hottest_left);
  EXPECT_GT(strong.summary.largest_dose, usual.summary.largest_dose);
  EXPECT_LT(wet.left, strong.left);
  EXPECT_LT(wet.summary.hottest_left, strong.summary.hottest_left);
}

TEST(BoneHeat, FindsTheDamageBesideTheCut) {
  const Outcome burnt = mill(300.0, 1 * mm, 10.0);
  EXPECT_GT(burnt.summary.hottest_left, 330.0);
  EXPECT_GT(burnt.summary.by_dose.volume, 0.0);
  EXPECT_GT(burnt.summary.by_dose.depth, 0.2 * mm);
  EXPECT_LT(burnt.summary.by_dose.depth, 5 * mm);
  const Outcome gentle = mill(0.5, 4 * mm, 10.0);
  EXPECT_EQ(gentle.summary.by_dose.volume, 0.0);
  EXPECT_EQ(gentle.summary.by_dose.depth, 0.0);
}

TEST(BoneHeat, MaterialGoesFromCancellousToCortical) {
  EXPECT_DOUBLE_EQ(thermal_material(1900.0).conductivity, 0.55);
  EXPECT_DOUBLE_EQ(thermal_material(1900.0).heat_capacity, 1900.0 * 1300.0);
  EXPECT_DOUBLE_EQ(thermal_material(300.0).conductivity, 0.29);
}

TEST(BoneHeat, RefusesTooFineAField) {
  const workpiece::Stock stock =
      workpiece::block({0, -6 * mm, -8 * mm}, {15 * mm, 6 * mm, 0}, {1900.0, 1.0}, 0.3 * mm);
  BoneHeatOptions options;
  options.spacing = 0.0;
  EXPECT_THROW(BoneHeat(stock, cutter(), slot(), options), InvalidInput);
  options.spacing = -1.0;
  EXPECT_THROW(BoneHeat(stock, cutter(), slot(), options), InvalidInput);
}

TEST(BoneHeat, CountsTheTimeAboveEachLimit) {
  // A block at one temperature, no air around it that cools.
  const workpiece::Stock stock = workpiece::block({0, -6 * mm, -8 * mm}, {15 * mm, 6 * mm, 0},
                                                  {1900.0, 1.0}, 0.3 * mm, 1 * mm);
  const auto after = [&](double celsius, double seconds) {
    BoneHeatOptions options;
    options.spacing = 0.6 * mm;
    options.field.initial_temperature = celsius + thermal::kZeroCelsius;
    options.field.blood_temperature = options.field.initial_temperature;
    options.field.convection = 0.0;
    BoneHeat heat(stock, cutter(), slot(), options);
    for (int k = 0; k < 10; ++k) heat.rest(seconds / 10);
    return heat.summary();
  };
  // 48.5 °C for a time: 45.25 equivalent minutes a minute.
  EXPECT_EQ(after(48.5, 59.0).by_47c_60s.volume, 0.0);
  EXPECT_GT(after(48.5, 60.0).by_47c_60s.volume, 0.0);
  EXPECT_EQ(after(48.5, 60.0).by_50c_30s.volume, 0.0);
  EXPECT_EQ(after(50.5, 29.0).by_50c_30s.volume, 0.0);
  EXPECT_GT(after(50.5, 30.0).by_50c_30s.volume, 0.0);
  // 46.9 °C for two minutes are 30 equivalent ones: dead by the dose, not by the others.
  const BoneHeatSummary long_and_warm = after(46.9, 120.0);
  EXPECT_GT(long_and_warm.by_dose.volume, 0.0);
  EXPECT_EQ(long_and_warm.by_47c_60s.volume, 0.0);
}

}  // namespace
}  // namespace osteomill::simulate
