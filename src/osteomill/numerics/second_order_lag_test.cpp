// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/second_order_lag.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::numerics {
namespace {

TEST(HeldLag, StepResponseIsTheTextbookOneForAnUnderdampedLag) {
  const SecondOrderLag lag{62.8, 0.7};
  const HeldLag held(lag, 0.01);
  const double w_d = lag.natural_frequency * std::sqrt(1.0 - 0.7 * 0.7);
  LagState state;
  for (int step = 1; step <= 20; ++step) {
    state = held.advance(state, 3.0);
    const double t = 0.01 * step;
    const double decay = std::exp(-0.7 * lag.natural_frequency * t);
    const double expected =
        3.0 * (1.0 - decay * (std::cos(w_d * t) + 0.7 / std::sqrt(0.51) * std::sin(w_d * t)));
    // Twenty products of a matrix with entries up to w_n² = 4000: rounding only.
    EXPECT_NEAR(state.value, expected, 1e-11);
  }
}

TEST(HeldLag, TwoHalfStepsAreOneStepWhateverTheDamping) {
  for (const double damping : {0.05, 0.7, 1.0, 3.0}) {
    const SecondOrderLag lag{118.0, damping};
    const LagState start{0.2, 3.0, -40.0};
    const HeldLag half(lag, 0.005);
    const LagState twice = half.advance(half.advance(start, 5.0), 5.0);
    const LagState once = HeldLag(lag, 0.01).advance(start, 5.0);
    EXPECT_NEAR(twice.integral, once.integral, 1e-13);
    EXPECT_NEAR(twice.value, once.value, 1e-11);
    EXPECT_NEAR(twice.rate, once.rate, 1e-9);  // of values near w_n * 5 = 600
  }
}

TEST(HeldLag, AtRestOnItsInputItStaysThereAndTheIntegralGrowsWithTime) {
  const HeldLag held({118.0, 0.7}, 0.01);
  LagState state{0.0, 12.0, 0.0};
  for (int step = 0; step < 100; ++step) state = held.advance(state, 12.0);
  EXPECT_NEAR(state.value, 12.0, 1e-10);
  EXPECT_NEAR(state.integral, 12.0, 1e-10);
}

TEST(HeldLag, RefusesAServoThatIsNone) {
  EXPECT_THROW(HeldLag({0.0, 0.7}, 0.01), InvalidInput);
  EXPECT_THROW(HeldLag({62.8, 0.0}, 0.01), InvalidInput);
  EXPECT_THROW(HeldLag({62.8, std::nan("")}, 0.01), InvalidInput);
  EXPECT_THROW(HeldLag({62.8, 0.7}, 0.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::numerics
