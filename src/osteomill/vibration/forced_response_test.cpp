// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/forced_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/vibration/chatter_simulation.hpp"
#include "osteomill/vibration/linearised_cut.hpp"
#include "osteomill/vibration/stability.hpp"

namespace osteomill::vibration {
namespace {

using units::mm;
using units::rpm;

const cutting::Cutter kMill{.radius = 1.55 * mm, .flutes = 2, .cutting_length = 35 * mm};

cutting::CuttingLaw power_law(double exponent) {
  const cutting::PowerLaw tangential{.at_1_mm = 70 * units::n_per_mm, .exponent = exponent};
  const cutting::PowerLaw radial{.at_1_mm = 30 * units::n_per_mm, .exponent = exponent};
  return {.tangential = {tangential, {}},
          .radial = {radial, {}},
          .lateral = {},
          .orientation = cutting::OrientationCriterion::none};
}

cutting::Condition at(double speed_rpm, double feed_per_tooth) {
  return {.spindle_speed = speed_rpm * rpm, .feed_per_tooth = feed_per_tooth};
}

const cutting::Immersion kSlot{.kind = cutting::ImmersionKind::slot, .axial_depth = 5 * mm};

std::vector<Mode> modes() {
  return {{1000.0, 0.02, 1e-3, 1.0, 0.0}, {1000.0, 0.02, 1e-3, 0.0, 1.0}};
}

Receptance receptance() {
  return [m = modes()](double f) { return tip_receptance(m, f); };
}

TEST(ForcedResponse, SlowTurningIsTheStaticDeflection) {
  const ForcedMotion motion =
      forced_motion(receptance(), kMill, power_law(0.7), at(60, 0.01 * mm), kSlot);
  for (std::size_t i = 0; i < motion.x.size(); ++i) {
    // Tooth passing at 2 Hz, its 47th harmonic at 94 Hz: (94/1000)² of a small harmonic.
    EXPECT_NEAR(motion.y[i], motion.static_y[i], 1e-3 * 1e-4);
  }
}

TEST(ForcedResponse, IsTheSteadyStateOfTheTimeDomainSimulation) {
  const auto law = power_law(1.0);
  const auto cut = linearised_cut(kMill, law, at(12000, 0.05 * mm), kSlot);
  const RegenerativeSystem system(modes(), cut);
  // So shallow that the vibration hardly changes the chip.
  const double depth = 0.01 * mm;
  const auto simulated =
      simulate_chatter(system, 12000 * rpm, depth, 0.05 * mm, {.steps = 480, .most_periods = 400});
  const cutting::Immersion thin{.kind = cutting::ImmersionKind::slot, .axial_depth = depth};
  const ForcedMotion motion = forced_motion(receptance(), kMill, law, at(12000, 0.05 * mm), thin);
  const auto [low, high] = std::minmax_element(motion.y.begin(), motion.y.end());
  EXPECT_NEAR(simulated.peak_to_peak_y, *high - *low, 0.02 * (*high - *low));
}

TEST(ForcedResponse, PeaksWhereAHarmonicOfTheToothPassingMeetsTheMode) {
  std::vector<double> speeds;
  for (int i = 0; i < 200; ++i) speeds.push_back((10000 + 150 * i) * rpm);
  const auto sweep = forced_sweep(receptance(), kMill, power_law(0.7), at(10000, 0.01 * mm), kSlot,
                                  speeds, {2 * units::mm_per_s});
  std::size_t worst = 0;
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    if (sweep[i].amplification() > sweep[worst].amplification()) worst = i;
  }
  const auto resonances = resonance_speeds({1000.0}, 2, 3, 10000 * rpm, 40000 * rpm);
  ASSERT_EQ(resonances.size(), 3u);
  EXPECT_NEAR(resonances.back().spindle_speed / rpm, 30000.0, 1e-6);
  EXPECT_EQ(resonances.back().harmonic, 1);
  EXPECT_NEAR(sweep[worst].spindle_speed / rpm, 30000.0, 300.0);
  for (const CalmRange& range : calm_ranges(sweep, 1.5)) {
    EXPECT_FALSE(range.low <= 30000 * rpm && range.high >= 30000 * rpm);
    EXPECT_GE(range.calmest, range.low);
    EXPECT_LE(range.calmest, range.high);
  }
}

TEST(ForcedResponse, FasterFeedMakesLargerVibration) {
  const auto sweep = forced_sweep(receptance(), kMill, power_law(0.7), at(20000, 0.01 * mm), kSlot,
                                  {20000 * rpm}, {0.5e-3, 1e-3, 2e-3});
  // Forces of a power law scale with the feed's power; the receptance is linear.
  EXPECT_NEAR(sweep[1].peak / sweep[0].peak, std::pow(2.0, 0.7), 1e-6);
  EXPECT_NEAR(sweep[2].peak / sweep[0].peak, std::pow(4.0, 0.7), 1e-6);
}

TEST(LinearisedCut, OfALinearLawHasItsCoefficients) {
  const auto cut = linearised_cut(kMill, power_law(1.0), at(10000, 0.05 * mm), kSlot);
  const EdgeStiffness k = cut.edge(1.0);
  EXPECT_NEAR(k.tangential, 70e6, 1.0);
  EXPECT_NEAR(k.radial, 30e6, 1.0);
}

TEST(LinearisedCut, OfAPowerLawIsStifferForThinChips) {
  const auto limit = [&](double feed_per_tooth) {
    const RegenerativeSystem system(
        modes(), linearised_cut(kMill, power_law(0.7), at(20000, feed_per_tooth), kSlot));
    return lobes(system, {20000 * rpm}, {.max_depth = 50 * mm})[0].limit_depth;
  };
  // ∂F/∂h ∝ h^(n − 1): the limit depth goes with the feed to the power 1 − n = 0.3, but for the
  // thinnest chips at entry and exit.
  EXPECT_NEAR(limit(0.1 * mm) / limit(0.05 * mm), std::pow(2.0, 0.3), 0.01);
}

TEST(LinearisedCut, ContactAnglesMeetInTheSlot) {
  using cutting::ImmersionKind;
  constexpr double pi = std::numbers::pi;
  EXPECT_NEAR(contact_angles(ImmersionKind::up, 0.5).exit, pi / 2, 1e-15);
  EXPECT_NEAR(contact_angles(ImmersionKind::down, 0.5).entry, pi / 2, 1e-15);
  EXPECT_NEAR(contact_angles(ImmersionKind::up, 1.0).exit, pi, 1e-15);
  EXPECT_THROW(contact_angles(ImmersionKind::up, 1.2), InvalidInput);
}

TEST(LinearisedCut, RefusesABall) {
  cutting::Cutter ball = kMill;
  ball.shape = cutting::CutterShape::ball;
  EXPECT_THROW(linearised_cut(ball, power_law(1.0), at(10000, 0.05 * mm), kSlot), InvalidInput);
}

}  // namespace
}  // namespace osteomill::vibration
