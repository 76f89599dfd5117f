// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/loop.hpp"

#include <gtest/gtest.h>

namespace osteomill::control {
namespace {

/// A rod of one material: the feed is the command at once, F = edge + K v.
class Rod final : public Plant {
 public:
  Rod(double gain, double edge) : gain_(gain), edge_(edge) {}
  Observation start() override { return seen_; }
  Observation advance(const FeedCommand& command) override {
    seen_.time += 0.01;
    seen_.sample_time = seen_.time;
    seen_.position += 0.01 * command.feed;
    seen_.feed = command.feed;
    seen_.mean_force = edge_ + gain_ * command.feed;
    seen_.finished = seen_.position >= 66e-3;
    return seen_;
  }
  const Observation& seen() const { return seen_; }

 private:
  double gain_;
  double edge_;
  Observation seen_;
};

FeedController published() {
  FeedController controller;
  controller.law = SugitaLoop{};
  return controller;
}

const LoopOptions kOptions{3e-3, 5.0, 66e-3, {}, {}, false, {}, {}};

TEST(Loop, RunsToTheEndOfThePath) {
  Rod rod(3800.0, 0.0);
  EXPECT_EQ(run(rod, published(), kOptions).end, LoopEnd::finished);
  EXPECT_NEAR(rod.seen().mean_force, 12.0, 1e-6);
}

TEST(Loop, SaysWhenTheControllerAsksForNoFeedAnyMore) {
  Rod rod(3800.0, 14.0);
  EXPECT_EQ(run(rod, published(), kOptions).end, LoopEnd::stalled);
  EXPECT_LT(rod.seen().time, 10.0);
}

TEST(Loop, StopsCleanlyWhenAsked) {
  Rod rod(3800.0, 0.0);
  double share = 0.0;
  const auto half = [&](std::string_view, double done) {
    share = done;
    return done < 0.5;
  };
  EXPECT_EQ(run(rod, published(), kOptions, half).end, LoopEnd::stopped);
  EXPECT_NEAR(share, 0.5, 0.05);
  EXPECT_NEAR(rod.seen().position, 33e-3, 3e-3);
}

TEST(Loop, SupervisorStopsThePlantAndLeavesAnEvent) {
  Rod rod(3800.0, 0.0);
  LoopOptions options = kOptions;
  options.supervisor = SupervisorLimits{};
  options.supervisor->frozen_periods = 0;  // the rod has no noise
  EXPECT_EQ(run(rod, published(), options).end, LoopEnd::finished);
  Rod strong(3800.0, 0.0);
  options.supervisor->torque = 1e-9;
  options.supervisor->highest_feed = 3.0e-3;  // less than the controller asks for
  int told = 0;
  options.on_event = [&told](const LoopEvent& event) {
    told += event.cause == Cause::command_range ? 1 : 100;
  };
  const LoopSummary stopped = run(strong, published(), options);
  EXPECT_EQ(told, 1);
  EXPECT_EQ(stopped.end, LoopEnd::supervisor);
  ASSERT_EQ(stopped.events.size(), 1u);
  EXPECT_EQ(stopped.events[0].cause, Cause::command_range);
  EXPECT_EQ(strong.seen().feed, 0.0);
}

TEST(Loop, MeasuresItsStepsByTheClockThatItIsGiven) {
  Rod rod(3800.0, 0.0);
  LoopOptions options = kOptions;
  double now = 0.0;
  options.clock = [&] { return now += 6e-3; };
  const LoopSummary done = run(rod, published(), options);
  EXPECT_EQ(done.overruns, 0);
  ASSERT_FALSE(done.compute_times.empty());
  EXPECT_NEAR(done.compute_times.front(), 6e-3, 1e-12);
  // Slower than the period: counted, and a reason to stop where the plant does not wait.
  options.clock = [&] { return now += 11e-3; };
  options.supervisor = SupervisorLimits{};
  options.supervisor->frozen_periods = 0;
  Rod patient(3800.0, 0.0);
  const LoopSummary late = run(patient, published(), options);
  EXPECT_EQ(late.end, LoopEnd::finished);
  EXPECT_EQ(late.overruns, static_cast<int>(late.compute_times.size()));
  options.real_time = true;
  Rod hurried(3800.0, 0.0);
  const LoopSummary stopped = run(hurried, published(), options);
  EXPECT_EQ(stopped.end, LoopEnd::supervisor);
  EXPECT_EQ(stopped.events[0].cause, Cause::controller_overrun);
}

}  // namespace
}  // namespace osteomill::control
