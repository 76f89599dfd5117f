// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/feed_controller.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <new>
#include <utility>
#include <vector>

#include "osteomill/base/error.hpp"

namespace {
std::atomic<long> allocations{0};
}

// Counted, so that a test can say that the step takes nothing from the heap. Not inlined: g++ would
// take malloc and free for a mismatched pair.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace osteomill::control {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

FeedController published(SumReading reading = SumReading::override) {
  FeedController controller;
  SugitaLoop loop;
  loop.reading = reading;
  controller.law = loop;
  return controller;
}

Observation force(double newton) {
  Observation seen;
  seen.programmed_feed = 3e-3;
  seen.mean_force = newton;
  return seen;
}

/// Feeds while the cutting gain is `gain(step)`, N/(m/s), and the feed follows the command at once.
template <class Gain>
std::vector<double> feeds(const FeedController& controller, int steps, const Gain& gain) {
  ControllerState state;
  state.feed = 3e-3;
  double feed = 3e-3;
  std::vector<double> record;
  for (int i = 0; i < steps; ++i) {
    const ControlStep next = step(controller, state, force(gain(i) * feed));
    state = next.state;
    feed = next.command.feed;
    record.push_back(feed);
  }
  return record;
}

TEST(SugitaLoop, OneStepIsTheGainTimesTheSumInEveryReading) {
  // Last feed 3 mm/s, one force 2 N below F_ref: the sum is 2 N.
  const double last = 3e-3;
  EXPECT_NEAR(step(SugitaLoop{.reading = SumReading::sum}, {}, last, 10.0).feed, 3.1e-3, 1e-15);
  EXPECT_NEAR(step(SugitaLoop{.reading = SumReading::mean}, {}, last, 10.0).feed, 3.02e-3, 1e-15);
  // 0.05 % / N x 2 N = 0.1 % of 12 mm/s.
  EXPECT_NEAR(step(SugitaLoop{}, {}, last, 10.0).feed, 3.012e-3, 1e-15);
  // 2 N above F_ref: twice the gain, downwards.
  EXPECT_NEAR(step(SugitaLoop{}, {}, last, 14.0).feed, 2.976e-3, 1e-15);
}

TEST(SugitaLoop, TheSignOfTheFilteredSumChoosesTheGainNotTheLastForce) {
  SugitaState state;
  state.differences = {10.0, 10.0, 0.0, 0.0, 0.0};
  // Last force 5 N too high, sum still +15 N: the acceleration gain.
  EXPECT_NEAR(step(SugitaLoop{}, state, 3e-3, 17.0).feed, 3e-3 + 0.05e-2 * 15.0 * 12e-3, 1e-15);
}

TEST(SugitaLoop, ForgetsAForceAfterFivePeriods) {
  SugitaState state = step(SugitaLoop{}, {}, 3e-3, 112.0).state;
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT(step(SugitaLoop{}, state, 3e-3, 12.0).feed, 3e-3);
    state = step(SugitaLoop{}, state, 3e-3, 12.0).state;
  }
  EXPECT_EQ(step(SugitaLoop{}, state, 3e-3, 12.0).feed, 3e-3);
}

TEST(FeedController, HoldsTheReferenceForceInUniformBone) {
  for (const SumReading reading : {SumReading::mean, SumReading::override}) {
    const auto record = feeds(published(reading), 1000, [](int) { return 3800.0; });
    EXPECT_NEAR(record.back() * 3800.0, 12.0, 1e-9);
  }
}

TEST(FeedController, TheLiteralSumNeverSettlesInCorticalBone) {
  for (const double gain : {3250.0, 3800.0, 4600.0}) {
    const auto record = feeds(published(SumReading::sum), 3000, [&](int) { return gain; });
    const auto [low, high] = std::minmax_element(record.end() - 100, record.end());
    EXPECT_GT(*high - *low, 1e-3) << gain;  // it swings by more than 1 mm/s for ever
  }
}

TEST(FeedController, DoesNotWindUpAtTheLargestFeed) {
  // Ten seconds at the clamp in air, then cortical bone: it must leave the clamp with the first
  // negative sum, that is after at most five periods.
  const auto record = feeds(published(), 1006, [](int i) { return i < 1000 ? 0.0 : 3800.0; });
  EXPECT_EQ(record[999], 12e-3);
  EXPECT_LT(record[1005], 12e-3);
  // And from the clamp at zero.
  const auto stalled = feeds(published(), 1010, [](int i) { return i < 1000 ? 1e6 : 0.0; });
  EXPECT_GT(stalled.back(), 0.0);
}

TEST(FeedController, AnEdgeForceAboveTheReferenceStallsThePublishedLoopAndAFloorPreventsIt) {
  const auto run = [](FeedController controller) {
    ControllerState state;
    state.feed = 3e-3;
    for (int i = 0; i < 2000; ++i) {
      state = step(controller, state, force(14.0 + 3800.0 * state.feed)).state;
    }
    return state.feed;
  };
  FeedController controller = published();
  EXPECT_EQ(run(controller), 0.0);
  controller.limits.lowest = 0.5e-3;
  EXPECT_EQ(run(controller), 0.5e-3);
}

TEST(FeedController, GoesNoFasterThanTheEntryFeedAroundThePredictedContactAndKeepsNothingBack) {
  FeedController controller = published();
  controller.predictive = PredictiveMode{};
  ControllerState state;
  state.feed = 12e-3;
  Observation seen = force(0.0);
  seen.to_contact = 1.6e-3;
  EXPECT_EQ(step(controller, state, seen).command.mode, Mode::adaptive);
  seen.to_contact = 1.4e-3;
  const ControlStep slowed = step(controller, state, seen);
  EXPECT_EQ(slowed.command.mode, Mode::predictive);
  EXPECT_EQ(slowed.command.feed, 3e-3);
  EXPECT_EQ(slowed.state.feed, 3e-3);  // the loop goes on from here, not from 12 mm/s
  seen.to_contact = -0.2e-3;
  EXPECT_EQ(step(controller, slowed.state, seen).command.feed, 3e-3);
  seen.to_contact = -0.4e-3;
  EXPECT_GT(step(controller, slowed.state, seen).command.feed, 3e-3);
}

double limit_at(const PredictiveMode& mode, double to_contact) {
  Observation seen;
  seen.to_contact = to_contact;
  seen.to_engagement = to_contact + 2.646e-3;
  return entry_limit(mode, seen);
}

TEST(FeedController, UncertaintyOfTheContactWidensTheSlowZoneOnBothSides) {
  PredictiveMode mode;
  mode.uncertainty = 1e-3;
  EXPECT_EQ(limit_at(mode, 2.4e-3), mode.entry_feed);
  EXPECT_EQ(limit_at(mode, -1.2e-3), mode.entry_feed);
  EXPECT_TRUE(std::isinf(limit_at(mode, 2.6e-3)));
  EXPECT_TRUE(std::isinf(limit_at(mode, -1.4e-3)));
  EXPECT_TRUE(std::isinf(limit_at(mode, std::numeric_limits<double>::infinity())));
}

TEST(FeedController, HoldsTheEntryFeedUntilFullEngagementWhenAsked) {
  PredictiveMode mode;
  EXPECT_TRUE(std::isinf(limit_at(mode, -2e-3)));
  mode.until_engaged = true;
  EXPECT_EQ(limit_at(mode, -2e-3), mode.entry_feed);
  EXPECT_TRUE(std::isinf(limit_at(mode, -2.7e-3)));
  // Where the contact may come later, so may the engagement.
  mode.uncertainty = 1e-3;
  EXPECT_EQ(limit_at(mode, -3.6e-3), mode.entry_feed);
  EXPECT_TRUE(std::isinf(limit_at(mode, -3.7e-3)));
}

TEST(FeedController, LimitsTheRateOfTheCommandBothWays) {
  FeedController controller = published();
  controller.law = ConstantFeed{9e-3};
  controller.limits.acceleration = 0.1;  // 1 mm/s in a period
  ControllerState state;
  state.feed = 3e-3;
  EXPECT_NEAR(step(controller, state, force(0.0)).command.feed, 4e-3, 1e-15);
  state.feed = 12e-3;
  EXPECT_NEAR(step(controller, state, force(0.0)).command.feed, 11e-3, 1e-15);
}

TEST(FeedController, ConstantFeedIsTheProgrammedOneUnlessReplaced) {
  FeedController controller;
  EXPECT_EQ(step(controller, {}, force(50.0)).command.feed, 3e-3);
  controller.law = ConstantFeed{5e-3};
  EXPECT_EQ(step(controller, {}, force(50.0)).command.feed, 5e-3);
}

TEST(FeedController, ARapidHasTheMachinesSpeedUnderEveryLawButForTheEntryAndTheAcceleration) {
  FeedController loop = published();
  FeedController constant;
  constant.law = ConstantFeed{5e-3};
  for (FeedController& controller : {std::ref(loop), std::ref(constant)}) {
    controller.limits.lowest = 1e-3;
    controller.limits.highest = 8e-3;
    Observation seen = force(0.0);
    seen.programmed_feed = 40e-3;
    seen.rapid = true;
    ControlStep next = step(controller, {}, seen);
    EXPECT_EQ(next.command.feed, 40e-3);
    EXPECT_EQ(next.command.mode, Mode::constant);
    EXPECT_FALSE(next.command.saturated);
    // What the machine's own speed has been says nothing to the law.
    seen.rapid = false;
    EXPECT_LE(step(controller, next.state, seen).command.feed, 8e-3);
    seen.rapid = true;
    controller.predictive = PredictiveMode{};
    seen.to_contact = 1e-3;
    EXPECT_EQ(step(controller, {}, seen).command.feed, controller.predictive->entry_feed);
    controller.predictive.reset();
    controller.limits.acceleration = 0.1;  // 1 mm/s in a period
    EXPECT_NEAR(step(controller, {}, seen).command.feed, 1e-3, 1e-15);
  }
}

TEST(FeedController, StopsOnAnObservationThatIsNotFiniteAndRecoversItsTaps) {
  ControllerState state;
  state.feed = 3e-3;
  state.sugita.differences = {1.0, 2.0, 3.0, 4.0, 5.0};
  for (const double broken : {kNan, std::numeric_limits<double>::infinity()}) {
    const ControlStep stopped = step(published(), state, force(broken));
    EXPECT_EQ(stopped.command.feed, 0.0);
    EXPECT_EQ(stopped.command.mode, Mode::stopped);
    EXPECT_EQ(stopped.state.sugita.differences, state.sugita.differences);
    EXPECT_TRUE(std::isfinite(step(published(), stopped.state, force(3.0)).command.feed));
  }
}

TEST(FeedController, StepTakesNothingFromTheHeapAndCannotThrow) {
  static_assert(
      noexcept(step(std::declval<const FeedController&>(), std::declval<const ControllerState&>(),
                    std::declval<const Observation&>())));
  FeedController adaptive;
  adaptive.law = ModelAdaptive(ModelAdaptiveOptions{});
  FeedController predictive;
  const std::vector<double> gains(200, 3e3), edges(200, 1.0);
  predictive.law = ModelPredictive(ModelPredictiveOptions{}, {0.1e-3, gains, edges, gains, edges});
  for (FeedController controller : {published(), adaptive, predictive, FeedController{}}) {
    controller.predictive = PredictiveMode{};
    ControllerState state;
    Observation seen = force(9.0);
    const long before = allocations;
    for (int i = 0; i < 1000; ++i) {
      seen.to_contact = 5e-3 - 1e-5 * i;
      seen.position = 1e-5 * i;
      seen.mean_force = i == 500 ? kNan : 9.0 + i % 7;
      state = step(controller, state, seen).state;
    }
    EXPECT_EQ(allocations - before, 0);
    EXPECT_TRUE(std::isfinite(state.feed));
  }
}

TEST(FeedController, RefusesWhatIsNoController) {
  const auto broken = [](auto change) {
    FeedController controller = published();
    controller.predictive = PredictiveMode{};
    change(controller);
    return controller;
  };
  EXPECT_NO_THROW(check(broken([](FeedController&) {})));
  EXPECT_THROW(check(broken([](FeedController& c) { c.limits.highest = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](FeedController& c) { c.limits.lowest = 13e-3; })), InvalidInput);
  EXPECT_THROW(check(broken([](FeedController& c) { c.limits.acceleration = kNan; })),
               InvalidInput);
  EXPECT_THROW(check(broken([](FeedController& c) { c.period = -1.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](FeedController& c) { c.law = ConstantFeed{-3e-3}; })), InvalidInput);
  EXPECT_THROW(check(broken([](FeedController& c) { c.law = SugitaLoop{.gain_up = kNan}; })),
               InvalidInput);
  EXPECT_THROW(check(broken([](FeedController& c) { c.law = SugitaLoop{.reference_force = 0.0}; })),
               InvalidInput);
  EXPECT_THROW(check(broken([](FeedController& c) { c.predictive->entry_feed = 0.0; })),
               InvalidInput);
  EXPECT_THROW(check(broken([](FeedController& c) { c.predictive->hold = -1e-3; })), InvalidInput);
}

}  // namespace
}  // namespace osteomill::control
