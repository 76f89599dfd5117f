// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/law_interpolation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

const ChipRange kRange{1e-6, 50e-6};

TestedLaw rake_0() {
  CuttingLaw law;
  law.tangential = {LogLaw{0.3487, 0.6503, -0.0710, kRange}, {}};
  law.radial = {LogLaw{0.6709, 0.1982, -0.0437, kRange}, {}};
  return {law, 0.0};
}

TestedLaw rake_10() {
  CuttingLaw law;
  law.tangential = {LogLaw{0.42083, 0.58122, -0.06584, kRange},
                    LogLaw{0.27242, 0.66537, -0.08710, kRange}};
  law.radial = {LogLaw{0.62379, 0.43160, -0.20553, kRange},
                LogLaw{0.64731, 0.17764, -0.06681, kRange}};
  return {law, 10.0 * units::deg};
}

TEST(InterpolateLaw, IsTheTestedLawAtItsOwnAngle) {
  const InterpolatedLaw at_10 = interpolate(rake_0(), rake_10(), 10.0 * units::deg);
  EXPECT_LT(at_10.largest_deviation, 1e-12);
  for (const double h : {2e-6, 20e-6}) {
    EXPECT_NEAR(force_per_width(*at_10.law.radial.at_90, h),
                force_per_width(*rake_10().law.radial.at_90, h), 1e-9);
  }
}

TEST(InterpolateLaw, IsHalfWayBetweenAtEachChip) {
  const InterpolatedLaw middle = interpolate(rake_10(), rake_0(), 5.0 * units::deg);
  EXPECT_LT(middle.largest_deviation, 0.01);
  for (const double h : {1.5e-6, 5e-6, 40e-6}) {
    const double half = 0.5 * (force_per_width(rake_0().law.radial.at_0, h) +
                               force_per_width(rake_10().law.radial.at_0, h));
    EXPECT_NEAR(force_per_width(middle.law.radial.at_0, h), half,
                1.0001 * middle.largest_deviation * half);
  }
}

TEST(InterpolateLaw, DoesNotExtrapolateNorMixForms) {
  EXPECT_THROW(interpolate(rake_0(), rake_10(), 11.0 * units::deg), InvalidInput);
  TestedLaw linear = rake_0();
  linear.law.radial = {LinearLaw{1e8, 1e3}, {}};
  EXPECT_THROW(interpolate(linear, rake_10(), 5.0 * units::deg), InvalidInput);
}

TEST(LawAtSpeed, ChangesAboveAHundredTurnsAMinute) {
  const CuttingLaw slow = rake_0().law;
  const CuttingLaw fast = rake_10().law;
  EXPECT_EQ(&law_at_speed(slow, fast, 100.0 * units::rpm), &slow);
  EXPECT_EQ(&law_at_speed(slow, fast, 101.0 * units::rpm), &fast);
}

}  // namespace
}  // namespace osteomill::cutting
