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

const LoopOptions kOptions{3e-3, 5.0, 66e-3};

TEST(Loop, RunsToTheEndOfThePath) {
  Rod rod(3800.0, 0.0);
  EXPECT_EQ(run(rod, published(), kOptions), LoopEnd::finished);
  EXPECT_NEAR(rod.seen().mean_force, 12.0, 1e-6);
}

TEST(Loop, SaysWhenTheControllerAsksForNoFeedAnyMore) {
  Rod rod(3800.0, 14.0);
  EXPECT_EQ(run(rod, published(), kOptions), LoopEnd::stalled);
  EXPECT_LT(rod.seen().time, 10.0);
}

TEST(Loop, StopsCleanlyWhenAsked) {
  Rod rod(3800.0, 0.0);
  double share = 0.0;
  const auto half = [&](std::string_view, double done) {
    share = done;
    return done < 0.5;
  };
  EXPECT_EQ(run(rod, published(), kOptions, half), LoopEnd::stopped);
  EXPECT_NEAR(share, 0.5, 0.05);
  EXPECT_NEAR(rod.seen().position, 33e-3, 3e-3);
}

}  // namespace
}  // namespace osteomill::control
