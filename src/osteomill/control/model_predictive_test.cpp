// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/model_predictive.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/control/feed_controller.hpp"

namespace osteomill::control {
namespace {

const double kRatio = 1.48;
const double kLength = 40e-3;
const numerics::SecondOrderLag kServo{118.0, 0.7};
using Gain = std::function<double(double x)>;

Forecast map_of(const Gain& gain, double offset = 0.0) {
  Forecast map;
  for (double x = 0.0; x <= kLength; x += map.spacing) {
    map.gains.push_back(gain(x - offset));
    map.edges.push_back(0.0);
    map.peak_gains.push_back(kRatio * gain(x - offset));
    map.peak_edges.push_back(0.0);
  }
  return map;
}

/// Air, then bone that the cutter is fully in after 2.646 mm, as a ball D 8 mm at a_e 1 mm.
double entry(double x) {
  const double out = std::clamp(1.0 - (x - 10e-3) / 2.646e-3, 0.0, 1.0);
  return 3250.0 * (1.0 - out * out);
}

struct Ride {
  double peak = 0.0;
  double time = 0.0;
  double feed_at_contact = 0.0;
  double last_feed = 0.0;
  ControllerState state;
};

/// The feed's servo is stepped a tenth of a period at a time, apart from the law's own model.
Ride ride(const FeedController& on, const Gain& gain, int delay = 1, double noise = 0.0) {
  const numerics::HeldLag servo(kServo, 1e-3);
  numerics::LagState state{0.0, 3e-3, 0.0};
  Random random(7);
  std::deque<double> forces(static_cast<std::size_t>(delay), 0.0);
  Ride done;
  done.state.feed = state.value;
  Observation seen;
  seen.feed = state.value;
  while (state.integral < kLength - 1e-3 && done.time < 300.0) {
    const ControlStep next = step(on, done.state, seen);
    done.state = next.state;
    double mean = 0.0;
    for (int i = 0; i < 10; ++i) {
      state = servo.advance(state, next.command.feed);
      const double force = gain(state.integral) * state.value;
      if (state.integral < 10e-3)
        done.feed_at_contact = std::max(done.feed_at_contact, state.value);
      mean += force / 10.0;
      done.peak = std::max(done.peak, kRatio * force);
    }
    done.time += 0.01;
    forces.push_front(mean + noise * random.normal());
    seen.time = done.time;
    seen.position = state.integral;
    seen.feed = state.value;
    seen.mean_force = forces[static_cast<std::size_t>(delay - 1)];
    seen.peak_force = kRatio * seen.mean_force;
    done.last_feed = state.value;
  }
  return done;
}

FeedController controller(const Forecast& map, double error, double gain_error = 0.1) {
  ModelPredictiveOptions options;
  options.map = {error, gain_error, 1.5e-3};
  options.servo = kServo;
  FeedController made;
  made.law = ModelPredictive(options, map);
  return made;
}

TEST(ModelPredictive,
     EntersBoneFromAirAtFullFeedWithoutPassingTheForceWhereverTheMapIsWithinItsError) {
  // What is aimed at is 0.92 of 30 N; the entry may pass it by 15 %.
  for (const double offset : {-1e-3, -0.37e-3, 0.0, 0.62e-3, 1e-3}) {
    const Ride done = ride(controller(map_of(entry, offset), 1e-3), entry);
    EXPECT_LE(done.peak, 1.15 * 0.92 * 30.0) << offset;
    EXPECT_GT(done.feed_at_contact, 11.9e-3) << offset;
    EXPECT_GT(done.last_feed * 3250.0 * kRatio, 0.75 * 30.0) << offset;
  }
}

TEST(ModelPredictive, AMapThatIsWrongByMoreThanItSaysLetsTheEntryPassTheForce) {
  // The envelope is what keeps it: without it the same map is not enough.
  const Ride trusting = ride(controller(map_of(entry, 1e-3), 0.0), entry);
  EXPECT_GT(trusting.peak, 1.15 * 0.92 * 30.0);
}

TEST(ModelPredictive, SlowsForAHardZoneAheadAndIsFasterWhenItKnowsWhereTheZoneIs) {
  const Gain zone = [](double x) { return entry(x) * (x > 25e-3 && x < 26.2e-3 ? 4.4 : 1.0); };
  const Ride sure = ride(controller(map_of(zone), 0.1e-3), zone);
  const Ride unsure = ride(controller(map_of(zone, 0.8e-3), 1e-3), zone);
  EXPECT_LT(sure.peak, 30.0);
  EXPECT_LT(unsure.peak, 30.0);
  EXPECT_LT(sure.time, unsure.time);
}

TEST(ModelPredictive, TheForcesCorrectTheDensityOfTheMap) {
  const Gain stronger = [](double x) { return 1.5 * entry(x); };
  const Ride done = ride(controller(map_of(entry), 0.2e-3, 0.25), stronger);
  EXPECT_NEAR(done.state.predictive.strength.last.strength, 1.5, 0.08);
  EXPECT_LT(done.last_feed * stronger(39e-3) * kRatio, 30.0);
  // A map that is taken for exact is corrected only by what its noise cannot explain.
  const Ride same = ride(controller(map_of(entry), 0.2e-3, 0.0), entry, 2, 1.0);
  EXPECT_NEAR(same.state.predictive.strength.last.strength, 1.0, 0.05);
}

TEST(ModelPredictive, WhatThePositionErrorExplainsIsNotTakenForStrength) {
  // The map has the bone 1 mm late: at the entry there are forces where it has none.
  const FeedController made = controller(map_of(entry, 0.9e-3), 1e-3, 0.25);
  const Ride done = ride(made, entry);
  EXPECT_NEAR(done.state.predictive.strength.last.strength, 1.0, 0.05);
}

TEST(ModelPredictive, KeepsTheFeedPerToothAndTheDeflectionOfTheTip) {
  ModelPredictiveOptions options;
  options.servo = kServo;
  options.spindle_speed = 628.3185307179586;
  options.limits.feed_per_tooth = 0.03e-3;  // 6 mm/s for two teeth at 100 1/s
  FeedController made;
  made.law = ModelPredictive(options, map_of([](double) { return 0.0; }));
  EXPECT_NEAR(ride(made, [](double) { return 0.0; }).last_feed, 6e-3, 0.02e-3);
  options.limits.feed_per_tooth = std::numeric_limits<double>::infinity();
  options.limits.force_of_deflection = 10.0;  // 100 N/mm, 0.1 mm
  made.law = ModelPredictive(options, map_of(entry));
  const Ride done = ride(made, entry);
  EXPECT_LT(done.peak, 10.0);
  EXPECT_GT(done.peak, 0.75 * 10.0);
}

TEST(ModelPredictive, SaysWhichLimitItKeepsTo) {
  ModelPredictiveOptions options;
  options.servo = kServo;
  const auto bound = [&](const Gain& gain, double position) {
    const ModelPredictive law(options, map_of(gain));
    Observation seen;
    seen.position = position;
    seen.feed = 3e-3;
    Bound last = Bound::none;
    ModelPredictive::Step next;
    for (int i = 0; i < 100; ++i) {
      next = law.step(next.state, seen, 12e-3);
      next.state.servo = law.after(next.state.servo, next.command);
      seen.feed = next.state.servo.value;
      last = next.bound;
    }
    return last;
  };
  EXPECT_EQ(bound(entry, 1e-3), Bound::largest_feed);
  EXPECT_EQ(bound(entry, 30e-3), Bound::force);
  options.limits.force_of_deflection = 10.0;
  EXPECT_EQ(bound(entry, 30e-3), Bound::deflection);
  options.limits.feed_per_tooth = 0.005e-3;
  options.spindle_speed = 600.0;
  EXPECT_EQ(bound(entry, 30e-3), Bound::feed_per_tooth);
}

/// `entry` with a rise of 40 K at 12 mm/s that goes with feed^-slowness and speed^haste.
Forecast warm(double slowness, double haste) {
  Forecast map = map_of(entry);
  map.heat = {2e-3, 12e-3, 900.0, {}, {}, {}};
  for (const double gain : map.gains) {
    const double rise = gain > 0.0 ? 40.0 : 0.0;
    map.heat.fast.push_back(rise);
    map.heat.slow.push_back(rise * std::pow(6.0, slowness));
    map.heat.spun.push_back(rise * std::pow(900.0 / 600.0, haste));
  }
  return map;
}

/// Where the feed has settled in the bone of `entry`.
ModelPredictive::Step settled(const ModelPredictiveOptions& options, const Forecast& map) {
  const ModelPredictive law(options, map);
  Observation seen;
  seen.position = 20e-3;
  seen.spindle_speed = options.spindle_speed;
  seen.feed = 5e-3;
  ModelPredictive::Step next;
  for (int i = 0; i < 200; ++i) {
    seen.mean_force = 3250.0 * seen.feed;  // as the map has it
    next = law.step(next.state, seen, 12e-3);
    next.state.servo = law.after(next.state.servo, next.command);
    seen.feed = next.state.servo.value;
    seen.position += seen.feed * 0.01;
  }
  return next;
}

ModelPredictiveOptions within(double temperature) {
  ModelPredictiveOptions options;
  options.servo = kServo;
  options.spindle_speed = 600.0;
  options.limits.temperature = temperature;
  options.limits.body_temperature = 310.15;
  return options;
}

TEST(ModelPredictive, ATemperatureThatFallsWithTheFeedAsksForFeedAsFarAsTheForceLimitAllows) {
  const double inf = std::numeric_limits<double>::infinity();
  const Forecast map = warm(0.8, 0.5);
  const auto rise = [](double feed) { return 40.0 * std::pow(feed / 12e-3, -0.8); };
  const ModelPredictive::Step free = settled(within(inf), map);
  EXPECT_EQ(free.bound, Bound::force);
  // Just out of reach of the feed with its reserve of force; 90 % of the rise is aimed at.
  const double limit = 0.99 * rise(free.wanted) / 0.9;
  const ModelPredictive::Step kept = settled(within(310.15 + limit), map);
  EXPECT_EQ(kept.bound, Bound::temperature);
  EXPECT_GT(kept.wanted, free.wanted);
  EXPECT_NEAR(rise(kept.wanted), 0.9 * limit, 1e-6);  // but for rounding
  // No feed keeps this one: it gives all that the force's limit leaves, and no more.
  const ModelPredictive::Step most = settled(within(310.15 + 0.5 * limit), map);
  EXPECT_EQ(most.bound, Bound::temperature);
  EXPECT_GT(most.wanted, kept.wanted);
  EXPECT_LT(kRatio * 3250.0 * most.wanted, 30.0);
  EXPECT_THROW(ModelPredictive(within(330.15), map_of(entry)), InvalidInput);  // no temperatures
}

TEST(ModelPredictive, ATemperatureThatRisesWithTheFeedLimitsIt) {
  const ModelPredictive::Step kept = settled(within(310.15 + 10.0), warm(-1.0, 0.0));
  EXPECT_EQ(kept.bound, Bound::temperature);
  EXPECT_NEAR(40.0 * kept.wanted / 12e-3, 0.9 * 10.0, 1e-6);
}

TEST(ModelPredictive, ABoneThatIsWarmerThanTheMapSaysIsTakenForWarmer) {
  const ModelPredictive law(within(340.15), warm(0.8, 0.5));
  Observation seen;
  seen.feed = 2e-3;
  const double rise = 40.0 * std::pow(6.0, 0.8);
  ModelPredictive::Step next;
  const auto go = [&](double seen_rise) {
    seen.position = 15e-3;
    seen.temperature = 310.15 + seen_rise;
    for (int i = 0; i < 1000; ++i) {
      seen.position += seen.feed * 0.01;
      next = law.step(next.state, seen, 12e-3);
    }
  };
  go(1.4 * rise);  // ten time constants
  EXPECT_NEAR(next.state.warmth, 1.4, 0.001);
  EXPECT_NEAR(law.temperature(next.state, 30e-3, 2e-3), seen.temperature, 0.2);
  go(0.5 * rise);  // one that is cooler is not believed to stay so
  EXPECT_NEAR(next.state.warmth, 1.0, 0.001);
}

ModelPredictiveOptions with_spindle() {
  ModelPredictiveOptions options;
  options.servo = kServo;
  options.map = {0.1e-3, 0.1, 1.5e-3};
  options.spindle_speed = 600.0;
  options.spindle = SpindleHandle{400.0, 900.0, 0.2};
  return options;
}

/// What the law asks of the spindle at a place where it has run at `speed`.
ModelPredictive::Step asked(const ModelPredictive& law, double speed, double position) {
  Observation seen;
  seen.position = position;
  seen.feed = 5e-3;
  seen.spindle_speed = speed;
  return law.step({}, seen, 12e-3);
}

TEST(ModelPredictive, TurnsTheSpindleFasterWhereTheForceLimitsTheFeedAndSlowlyInAir) {
  const ModelPredictive law(with_spindle(), map_of(entry));
  EXPECT_EQ(asked(law, 600.0, 1e-3).spindle_speed, 400.0);
  EXPECT_EQ(asked(law, 600.0, 20e-3).spindle_speed, 900.0);
  // Half the chip, half the force: the feed may double. The edge force of this map is none.
  EXPECT_NEAR(asked(law, 800.0, 20e-3).wanted / asked(law, 400.0, 20e-3).wanted, 2.0, 1e-9);
}

TEST(ModelPredictive, LeavesOutSpeedsThatChatter) {
  ModelPredictiveOptions options = with_spindle();
  options.chatter.gain = 3250.0;
  options.chatter.depth = 5e-3;
  // Stable up to 9 mm but around 900 rad/s, where 5 mm with a margin of 1.2 are too much.
  options.chatter.lobes = {{400.0, 9e-3}, {750.0, 9e-3}, {800.0, 5e-3}, {900.0, 5e-3}};
  const double chosen = asked(ModelPredictive(options, map_of(entry)), 600.0, 20e-3).spindle_speed;
  EXPECT_GT(chosen, 700.0);
  EXPECT_LT(chosen, 800.0);
  EXPECT_EQ(asked(ModelPredictive(options, map_of(entry)), 600.0, 20e-3).bound, Bound::chatter);
  // Without the handle a speed that chatters cannot be helped.
  options.spindle.reset();
  options.spindle_speed = 850.0;
  EXPECT_THROW(ModelPredictive(options, map_of(entry)), InvalidInput);
}

TEST(ModelPredictive, ChoosesTheFastestFeedAmongTheSpeedsThatKeepTheBoneCool) {
  ModelPredictiveOptions options = with_spindle();
  options.limits.body_temperature = 310.15;
  // Hotter with the speed than a thinner chip's feed makes cooler: a slow spindle is the cool one.
  const Forecast map = warm(0.5, 1.5);
  options.limits.temperature = 310.15 + 300.0;
  const ModelPredictive::Step hot = asked(ModelPredictive(options, map), 600.0, 20e-3);
  EXPECT_EQ(hot.spindle_speed, 900.0);
  options.limits.temperature = 310.15 + 65.0;
  const ModelPredictive::Step cool = asked(ModelPredictive(options, map), 600.0, 20e-3);
  EXPECT_LT(cool.spindle_speed, 800.0);
  EXPECT_GT(cool.spindle_speed, 400.0);
  EXPECT_EQ(cool.bound, Bound::temperature);
  EXPECT_LT(cool.wanted, hot.wanted);
  // None is cool enough: the coolest.
  options.limits.temperature = 310.15 + 20.0;
  EXPECT_EQ(asked(ModelPredictive(options, map), 600.0, 20e-3).spindle_speed, 400.0);
}

TEST(ModelPredictive, NeverStalls) {
  const Gain rock = [](double x) { return 100.0 * entry(x); };
  const Ride done = ride(controller(map_of(rock), 0.5e-3), rock);
  EXPECT_LT(done.time, 100.0);
  EXPECT_NEAR(done.last_feed, 0.4e-3, 0.01e-3);
}

TEST(ModelPredictive, RefusesOptionsThatMakeNoLaw) {
  const auto broken = [](auto change) {
    ModelPredictiveOptions options;
    change(options);
    return options;
  };
  using Options = ModelPredictiveOptions;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(check(broken([](Options& o) { o.limits.force = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([&](Options& o) { o.limits.feed_per_tooth = nan; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.map.position_error = -1e-3; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.map.correlation = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.floor_feed = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.servo.damping_ratio = 0.0; })), InvalidInput);
  EXPECT_THROW(ModelPredictive(Options{}, Forecast{}), InvalidInput);
  EXPECT_THROW(
      ModelPredictive(Options{}, Forecast{1e-4, {1.0, 2.0}, {0.0}, {1.0, 2.0}, {0.0, 0.0}}),
      InvalidInput);
}

}  // namespace
}  // namespace osteomill::control
