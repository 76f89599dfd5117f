// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/model_adaptive.hpp"

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

/// A rod whose gain is a function of place, behind a servo, with late and noisy forces. The cutter
/// enters it from air at x = 0 and is fully engaged after 2.6 mm.
struct Bone {
  std::function<double(double x)> gain;
  int delay = 1;
  double noise = 0.0;
  double edge = 0.0;
};

struct Ride {
  double peak = 0.0;
  double time = 0.0;
  double last_feed = 0.0;
  ControllerState state;
};

FeedController controller() {
  FeedController made;
  made.law = ModelAdaptive(ModelAdaptiveOptions{});
  made.predictive = PredictiveMode{};
  return made;
}

Ride ride(const FeedController& on, const Bone& bone, double length, double first_feed = 3e-3) {
  const numerics::HeldLag servo({118.0, 0.7}, 1e-3);
  numerics::LagState state{0.0, first_feed, 0.0};
  Random random(7);
  std::deque<double> forces(bone.delay, 0.0);
  Ride done;
  done.state.feed = first_feed;
  Observation seen;
  seen.feed = first_feed;
  seen.to_contact = 0.0;
  while (state.integral < length && done.time < 300.0) {
    const ControlStep next = step(on, done.state, seen);
    done.state = next.state;
    double mean = 0.0;
    for (int i = 0; i < 10; ++i) {
      state = servo.advance(state, next.command.feed);
      const double out = std::clamp(1.0 - state.integral / 2.646e-3, 0.0, 1.0);
      const double force =
          (1.0 - out * out) * (bone.edge + bone.gain(state.integral) * state.value);
      mean += force / 10.0;
      done.peak = std::max(done.peak, kRatio * force);
    }
    done.time += 0.01;
    forces.push_front(mean + bone.noise * random.normal());
    seen.time = done.time;
    seen.position = state.integral;
    seen.to_contact = -state.integral;
    seen.feed = state.value;
    seen.mean_force = forces[bone.delay - 1];
    seen.peak_force = kRatio * seen.mean_force;
    done.last_feed = state.value;
  }
  return done;
}

TEST(ModelAdaptive, LearnsTheGainOfUniformBoneAndGoesAsFastAsTheLimitAllows) {
  const Ride done = ride(controller(), {[](double) { return 3250.0; }}, 66e-3);
  EXPECT_NEAR(done.state.model.estimates[0].gain, 3250.0, 0.01 * 3250.0);
  EXPECT_NEAR(done.state.model.peak_to_mean, kRatio, 1e-3);
  EXPECT_LT(done.peak, 30.0);
  // Reserve against a hard zone: (1 + 3/mm v 12 ms) at 5 mm/s is 18 %; margin 8 %.
  EXPECT_GT(done.last_feed * 3250.0 * kRatio, 0.7 * 30.0);
}

TEST(ModelAdaptive, KeepsAHardZoneBelowTheLimit) {
  // Ahead of an arc with a_e 1 mm on D 8 mm the gain rises to 4.4 times over 1.17 mm at most so
  // fast.
  const auto zone = [](double x) {
    const double inside = std::clamp((x - 30e-3) * 880.0, 0.0, 1.0);
    return 3250.0 * (1.0 + 2.5 * inside);
  };
  for (const int delay : {1, 2}) {
    EXPECT_LT(ride(controller(), {zone, delay}, 40e-3).peak, 30.0) << delay;
  }
}

TEST(ModelAdaptive, FindsTheDelayBetweenForceAndFeed) {
  const auto waves = [](double x) { return 2000.0 + 1200.0 * std::sin(x / 1e-3); };
  for (const int delay : {1, 2, 3}) {
    const Ride done = ride(controller(), {waves, delay, 0.2}, 40e-3);
    int likeliest = 0;
    for (int d = 1; d < kDelays; ++d) {
      const auto& estimates = done.state.model.estimates;
      if (estimates[d].likelihood > estimates[likeliest].likelihood) likeliest = d;
    }
    EXPECT_EQ(likeliest + 1, delay);
  }
}

TEST(ModelAdaptive, LearnsTheNoiseOfTheSensor) {
  const Ride quiet = ride(controller(), {[](double) { return 3250.0; }, 1, 0.1}, 66e-3);
  const Ride loud = ride(controller(), {[](double) { return 3250.0; }, 1, 1.0}, 66e-3);
  EXPECT_LT(quiet.state.model.estimates[0].noise, 0.1);
  EXPECT_NEAR(loud.state.model.estimates[0].noise, 1.0, 0.5);  // one second of memory: 100 values
  EXPECT_LT(quiet.time, loud.time);  // what it does not know well it takes more slowly
}

TEST(ModelAdaptive, DoesNotStallOnAnEdgeForceAboveTheReferenceOfThePublishedLoop) {
  const Ride done = ride(controller(), {[](double) { return 3250.0; }, 1, 0.0, 14.0}, 10e-3);
  EXPECT_LT(done.time, 60.0);
  const Ride worse = ride(controller(), {[](double) { return 3250.0; }, 1, 0.0, 25.0}, 4e-3);
  EXPECT_NEAR(worse.last_feed, 0.4e-3, 1e-5);  // the floor
}

TEST(ModelAdaptive, GoesAtFullFeedInAirAndNoFasterThanTheEntryFeedIntoBone) {
  FeedController made = controller();
  EXPECT_NEAR(ride(made, {[](double) { return 0.0; }}, 20e-3).last_feed, 12e-3, 1e-6);
  Observation seen;
  seen.feed = 3e-3;
  ControllerState state;
  state.feed = 3e-3;
  seen.to_contact = -0.8e-3;  // past the hold of the predictive mode, not yet settled
  EXPECT_LE(step(made, state, seen).command.feed, 3e-3);
  seen.to_contact = -1.2e-3;
  EXPECT_GT(step(made, state, seen).command.feed, 3e-3);
}

TEST(ModelAdaptive, LeadBringsTheServoWhereItIsWantedWithinAPeriod) {
  // From 3 mm/s in air: full feed is wanted; the command may not pass it, so the servo lags; down
  // again the command may go to the floor and the servo arrives.
  const ModelAdaptive law{ModelAdaptiveOptions{}};
  ModelAdaptiveState state;
  Observation seen;
  seen.feed = 5e-3;
  const ModelAdaptive::Step next = law.step(state, seen, 4e-3);
  EXPECT_EQ(next.wanted, 4e-3);
  EXPECT_LT(next.command, 4e-3);
  EXPECT_NEAR(law.after(next.state.servo, next.command).value, 4e-3, 1e-12);
}

TEST(ModelAdaptive, RefusesOptionsThatMakeNoLaw) {
  const auto broken = [](auto change) {
    ModelAdaptiveOptions options;
    change(options);
    return options;
  };
  using Options = ModelAdaptiveOptions;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(check(broken([](Options& o) { o.force_limit = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.margin = 1.1; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.floor_feed = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.servo.damping_ratio = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([&](Options& o) { o.hardest_rise = nan; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.slope_length = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.jump_test = -1.0; })), InvalidInput);
  EXPECT_THROW(ModelAdaptive(broken([](Options& o) { o.period = 0.0; })), InvalidInput);
}

}  // namespace
}  // namespace osteomill::control
