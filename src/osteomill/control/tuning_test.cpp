// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/tuning.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::control {
namespace {

TuningRange range() {
  TuningRange made;
  made.least_gain = 620.0;
  made.largest_gain = 3250.0;
  made.largest_delay = 3;
  made.servo = numerics::SecondOrderLag{118.0, 0.7};
  return made;
}

TEST(Tuning, TheGainHasItsMarginsAtEveryCornerAndOneOfThemExactly) {
  const TuningGoal goal;
  const double gain = largest_gain(range(), goal);
  double least_gain = 1e9;
  double least_phase = 1e9;
  for (const LinearPlant& plant : corners(range())) {
    const Margins found = margins(plant, gain);
    least_gain = std::min(least_gain, found.gain_margin / goal.gain_margin);
    least_phase = std::min(least_phase, found.phase_margin / goal.phase_margin);
  }
  EXPECT_GE(least_gain, 1.0);
  EXPECT_GE(least_phase, 1.0);
  // Bisection to 1e-12 of the critical gain; the phase margin moves about as much.
  EXPECT_NEAR(std::min(least_gain, least_phase), 1.0, 1e-9);
}

TEST(Tuning, WithTheGoalOfNoMarginItIsTheCriticalGain) {
  TuningRange bare = range();
  bare.servo.reset();
  bare.largest_delay = 1;
  const double critical = 2.0 * std::pow(std::sin(std::numbers::pi / 10.0), 2);
  EXPECT_NEAR(largest_gain(bare, {1.0, 0.0}) * bare.largest_gain, critical, 1e-9);
}

TEST(Tuning, TheStepResponseOscillatesForEverAtTheCriticalGainAndSettlesBelowIt) {
  const LinearPlant plant{3250.0, numerics::SecondOrderLag{118.0, 0.7}, 10e-3, 2};
  const double critical = margins(plant, 1e-6).critical_loop_gain / plant.force_gain;
  const auto swing = [&](double gain) {
    const std::vector<double> force = step_response(plant, gain, 2000);
    const auto late = force.end() - 200;
    return *std::max_element(late, force.end()) - *std::min_element(late, force.end());
  };
  EXPECT_GT(swing(critical), 0.5);
  EXPECT_LT(swing(0.95 * critical), 0.05);
  EXPECT_GT(swing(1.02 * critical), 10.0);
  const std::vector<double> settled = step_response(plant, 0.4 * critical, 400);
  EXPECT_NEAR(settled.back(), 1.0, 1e-6);
  EXPECT_EQ(step_response(plant, 0.4 * critical, 1).size(), 1u);
}

TEST(Tuning, RefusesRangesAndGoalsThatAreNone) {
  TuningRange turned = range();
  turned.largest_gain = 100.0;
  EXPECT_THROW(corners(turned), InvalidInput);
  TuningRange late = range();
  late.least_delay = 4;
  EXPECT_THROW(corners(late), InvalidInput);
  EXPECT_THROW(largest_gain(range(), {0.5, 0.1}), InvalidInput);
  EXPECT_THROW(largest_gain(range(), {2.0, 2.0}), InvalidInput);
  EXPECT_THROW(step_response({0.0, std::nullopt, 10e-3, 1}, 1e-6, 5), InvalidInput);
}

}  // namespace
}  // namespace osteomill::control
