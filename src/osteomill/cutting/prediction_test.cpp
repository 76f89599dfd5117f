// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/prediction.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

CuttingLaw linear() {
  const ChipRange range{1e-6, 50e-6};
  CuttingLaw law;
  law.tangential = {LinearLaw{200e6, 0.0, range}, {}};
  law.radial = {LinearLaw{90e6, 0.0, range}, {}};
  return law;
}

const Cutter kCutter{CutterShape::cylindrical, 3e-3, 4, 0.0, 0.0, 20e-3};
const Immersion kSlot{ImmersionKind::slot, 0.0, 5e-3};

Condition at(double feed_um) { return {500.0, feed_um * units::um}; }

TEST(Prediction, EnergyIsThePressureWhenTheChipCarriesIt) {
  const Prediction cut = predict(kCutter, linear(), at(20.0), kSlot);
  // The tangential pressure is the energy per volume; the feed adds (mean Fx) v.
  const double feed = feed_rate(at(20.0), 4);
  EXPECT_NEAR(cut.spindle_power, 200e6 * cut.removal_rate, 1e-9 * cut.spindle_power);
  EXPECT_NEAR(cut.feed_power, -feed * cut.mean.force.x(), 1e-15);
  EXPECT_NEAR(cut.specific_energy * cut.removal_rate, cut.spindle_power + cut.feed_power, 1e-12);
}

TEST(Prediction, RubbingIsWhatTheEdgeForceTakes) {
  CuttingLaw law = linear();
  law.tangential.at_0 = LinearLaw{200e6, 4e3};
  const Prediction cut = predict(kCutter, law, at(20.0), kSlot);
  // Two of four flutes are in the slot at a time.
  EXPECT_NEAR(cut.rubbing_power, 2.0 * 4e3 * 5e-3 * 3e-3 * 500.0, 1e-9);
  EXPECT_EQ(predict(kCutter, linear(), at(20.0), kSlot).rubbing_power, 0.0);
}

TEST(Prediction, HarmonicsAndMeanHoldTheEnergyOfTheSignal) {
  const Cutter two{CutterShape::cylindrical, 3e-3, 2, 0.0, 0.0, 20e-3};
  const Prediction cut = predict(two, linear(), at(20.0), kSlot, {360, 179});
  geometry::Vector3 square = geometry::Vector3::Zero();
  for (const Load& load : cut.revolution.loads) square += load.force / 360.0;
  square = square.cwiseAbs2();
  for (const auto& amplitude : cut.harmonics) square += 0.5 * amplitude.cwiseAbs2();
  EXPECT_LT((square.cwiseSqrt() - cut.rms).norm(), 1e-6 * cut.rms.norm());  // Parseval
  EXPECT_LT(cut.harmonics[0].norm(), 1e-9);  // two equal flutes: even orders only
  EXPECT_GT(cut.harmonics[1].norm(), 0.1);
}

TEST(Prediction, PeaksBoundTheSignal) {
  const Prediction cut = predict(kCutter, linear(), at(20.0), {ImmersionKind::up, 1e-3, 5e-3});
  for (const Load& load : cut.revolution.loads) {
    EXPECT_LE(load.force.norm(), cut.peak_resultant);
    EXPECT_LE(std::abs(load.force.y()), cut.peak.y());
  }
  EXPECT_NEAR(cut.largest_chip, 20e-6 * std::sin(std::acos(2.0 / 3.0)), 1e-15);
}

TEST(Prediction, SaysWhenTheLawIsExtrapolated) {
  EXPECT_THAT(predict(kCutter, linear(), at(20.0), kSlot).warnings, ElementsAre());
  EXPECT_THAT(predict(kCutter, linear(), at(100.0), kSlot).warnings,
              ElementsAre(HasSubstr("1 ... 50 um")));
  EXPECT_THAT(predict(kCutter, linear(), at(0.5), kSlot).warnings,
              ElementsAre(HasSubstr("extrapolated")));
}

}  // namespace
}  // namespace osteomill::cutting
