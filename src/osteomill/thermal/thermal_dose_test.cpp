// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/thermal/thermal_dose.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/thermal/analytic_heat.hpp"
#include "osteomill/thermal/heat_partition.hpp"

namespace osteomill::thermal {
namespace {

TEST(ThermalDose, IsSixteenMinutesForTheLimitsOfBone) {
  EXPECT_DOUBLE_EQ(cem43_minutes(kZeroCelsius + 47.0, 60.0), 16.0);
  EXPECT_DOUBLE_EQ(cem43_minutes(kZeroCelsius + 50.0, 30.0), 64.0);
  EXPECT_DOUBLE_EQ(cem43_minutes(kZeroCelsius + 43.0, 60.0), 1.0);
  EXPECT_DOUBLE_EQ(cem43_minutes(kZeroCelsius + 42.0, 60.0), 0.25);
  EXPECT_EQ(cem43_minutes(kZeroCelsius + 37.0, 1e6), 0.0);
  EXPECT_DOUBLE_EQ(kBoneDamageCem43, cem43_minutes(kZeroCelsius + 47.0, 60.0));
}

TEST(ThermalDose, StaysANumberInBoneThatBurns) {
  const double boiling = cem43_rate(kZeroCelsius + kBoilingCelsius);
  EXPECT_DOUBLE_EQ(boiling, std::exp2(57.0));  // R^(43 - 100), R = 1/2
  EXPECT_DOUBLE_EQ(cem43_rate(kZeroCelsius + 1e4), boiling);
}

TEST(HeatPartition, GivesTheChipTheShareThatIsQuotedForBone) {
  // 78 to 96 % at 20 to 100 µm and 0.5 to 5 m/s, to the percent.
  const double a = kCorticalBone.diffusivity();
  EXPECT_NEAR(chip_share(a, 2.0, 0.5, 20e-6), 0.78, 0.01);
  EXPECT_NEAR(chip_share(a, 2.0, 5.0, 100e-6), 0.96, 0.01);
  EXPECT_EQ(chip_share(a, 2.0, 1.0, 0.0), 0.0);
}

TEST(HeatPartition, LosesNothing) {
  const HeatShares shares = partition(3.0, 2.0, 0.8);
  EXPECT_NEAR(shares.chip + shares.tool + shares.bone, 5.0, 1e-15);
  // More rubbing, more heat in the bone; a better chip, less.
  EXPECT_GT(partition(3.0, 3.0, 0.8).bone, shares.bone);
  EXPECT_LT(partition(3.0, 2.0, 0.9).bone, shares.bone);
  EXPECT_THROW(partition(1.0, 1.0, 1.2), InvalidInput);
  EXPECT_THROW(chip_share(0.0, 2.0, 1.0, 1.0), InvalidInput);
}

TEST(HeatShares, OfACutAddUpToItsWork) {
  for (const double rubbing : {0.0, 1.5, 9.0}) {
    const HeatShares shares = shares_of_cut(4.0, rubbing, 1.66, 10e-6);
    EXPECT_NEAR(shares.chip + shares.tool + shares.bone, 4.0, 1e-12);
  }
  // Slow, thin chips leave their heat in the bone, and so does an edge that only rubs.
  EXPECT_GT(shares_of_cut(4.0, 0.0, 0.03, 10e-6).bone, shares_of_cut(4.0, 0.0, 1.66, 10e-6).bone);
  EXPECT_NEAR(shares_of_cut(4.0, 4.0, 1.66, 10e-6).bone, 0.9 * 4.0, 1e-12);
  EXPECT_EQ(shares_of_cut(-1.0, 0.0, 1.66, 10e-6).bone, 0.0);
}

}  // namespace
}  // namespace osteomill::thermal
