// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/tilted_cut.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

using geometry::Vector3;

CuttingLaw linear() {
  CuttingLaw law;
  law.tangential = {LinearLaw{200e6, 2e3}, {}};
  law.radial = {LinearLaw{90e6, 1e3}, {}};
  return law;
}

Cutter ball() { return {CutterShape::ball, 4e-3, 2, 0.4, 0.0, 20e-3}; }

const Condition kLevel{600.0, 10e-6};

TEST(TiltedCut, WithoutLeanIsTheNominalCut) {
  for (const ImmersionKind kind : {ImmersionKind::slot, ImmersionKind::up, ImmersionKind::down}) {
    const Prediction leaning =
        predict(ball(), linear(), kLevel, TiltedCut{0.0, 0.0, 3e-3, 2e-3, kind});
    // The radial depth of a leaning cut counts from the envelope in bone, that of a nominal one
    // from the full radius: here 3 mm deep, 3.873 mm wide.
    const double reach = std::sqrt(3e-3 * 5e-3);
    const Prediction nominal =
        predict(ball(), linear(), kLevel, Immersion{kind, 2e-3 + 4e-3 - reach, 3e-3});
    // Patches of 2 degrees by 1/60 of the height, four by four points in each.
    EXPECT_LT((leaning.mean.force - nominal.mean.force).norm(), 0.01 * nominal.mean.force.norm())
        << static_cast<int>(kind);
    EXPECT_NEAR(leaning.removal_rate, nominal.removal_rate, 0.01 * nominal.removal_rate);
  }
}

TEST(TiltedCut, OfABallRemovesTheSameSectionHoweverItLeans) {
  const double section = 16e-6 * std::acos(1.0 - 2.0 / 4.0) - 2e-3 * std::sqrt(2e-3 * 6e-3);
  for (const double lead : {-0.5, 0.0, 0.4}) {
    for (const double tilt : {-0.4, 0.3}) {
      const Prediction cut =
          predict(ball(), linear(), kLevel, TiltedCut{lead, tilt, 2e-3, 0.0, ImmersionKind::slot});
      const double expected = section * feed_rate(kLevel, 2);
      EXPECT_NEAR(cut.removal_rate, expected, 0.02 * expected) << lead << " " << tilt;
    }
  }
}

TEST(TiltedCut, TakesThePressureTimesTheVolumeHoweverItLeans) {
  CuttingLaw law = linear();
  law.tangential.at_0 = LinearLaw{200e6, 0.0};
  for (const double tilt : {-0.5, 0.0, 0.5}) {
    const Prediction cut =
        predict(ball(), law, kLevel, TiltedCut{0.2, tilt, 0.5e-3, 0.0, ImmersionKind::slot});
    // Power and volume are summed over the same patches; near the tip the force takes smaller ones.
    EXPECT_NEAR(cut.spindle_power, 200e6 * cut.removal_rate, 0.01 * cut.spindle_power) << tilt;
    const Prediction mirrored =
        predict(ball(), law, kLevel, TiltedCut{0.2, -tilt, 0.5e-3, 0.0, ImmersionKind::slot});
    EXPECT_NEAR(cut.mean.torque(), mirrored.mean.torque(), 0.01 * cut.mean.torque());
  }
}

TEST(TiltedCut, RefusesTooMuchLeanAndDepthBeyondTheEdges) {
  EXPECT_NO_THROW(check(TiltedCut{0.2, 0.1, 2e-3, 0.0, ImmersionKind::slot}, ball()));
  EXPECT_THROW(check(TiltedCut{1.2, 0.0, 2e-3, 0.0, ImmersionKind::slot}, ball()), InvalidInput);
  EXPECT_THROW(check(TiltedCut{0.0, 0.0, 0.0, 0.0, ImmersionKind::slot}, ball()), InvalidInput);
  EXPECT_THROW(check(TiltedCut{0.0, 0.0, 2e-3, 0.0, ImmersionKind::up}, ball()), InvalidInput);
  EXPECT_THROW(check(TiltedCut{0.0, 0.0, 21e-3, 0.0, ImmersionKind::slot}, ball()), InvalidInput);
}

}  // namespace
}  // namespace osteomill::cutting
