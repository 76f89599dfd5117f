// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/supervised_plant.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "osteomill/base/error.hpp"
#include "osteomill/io/paced_plant.hpp"

namespace osteomill::io {
namespace {

using control::Cause;

// Long against what a busy machine delays a thread by; nothing below measures time.
const double kPeriod = 60e-3;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void sleep_periods(double periods) {
  std::this_thread::sleep_for(std::chrono::duration<double>(periods * kPeriod));
}

/// The feed follows the command within a period; finished after so many.
class Machine final : public control::Plant {
 public:
  explicit Machine(int periods) : periods_(periods) {}
  control::Observation start() override { return seen_; }
  control::Observation advance(const control::FeedCommand& command) override {
    if (broken && count_ == 3) throw WorldError("the machine is gone");
    ++count_;
    seen_.time = kPeriod * count_;
    seen_.sample_time = seen_.time;
    seen_.feed = command.feed;
    seen_.mean_force = 5.0 + 0.01 * (count_ % 7);
    seen_.finished = count_ >= periods_;
    if (command.feed > 0.0) ++moved;
    return seen_;
  }
  int moved = 0;  ///< periods with a feed
  bool broken = false;

 private:
  int periods_;
  int count_ = 0;
  control::Observation seen_;
};

SupervisedOptions options() {
  SupervisedOptions made;
  made.limits.period = kPeriod;
  made.limits.sample_age = 3.0 * kPeriod;
  made.clock = now;
  return made;
}

/// The controller asks for 5 mm/s in every period and is `late` in the fourth.
std::optional<SupervisedStop> ride(Machine& machine, const SupervisedOptions& how,
                                   double late = 0.0) {
  PacedPlant paced(machine, kPeriod);
  SupervisedPlant plant(paced, how);
  control::Observation seen = plant.start();
  for (int period = 0; !seen.finished; ++period) {
    if (period == 3 && late > 0.0) sleep_periods(late);
    seen = plant.advance({5e-3, control::Mode::adaptive, false});
  }
  control::LoopSummary loop;
  plant.finish(loop);
  EXPECT_EQ(loop.events.size(), plant.stop() ? 1u : 0u);
  return plant.stop();
}

TEST(SupervisedPlant, LetsAHealthyRunThrough) {
  Machine machine(6);
  EXPECT_FALSE(ride(machine, options()).has_value());
  EXPECT_EQ(machine.moved, 6);
}

TEST(SupervisedPlant, StopsWhenTheControllerTakesLongerThanItsPeriodWhileTheMachineMovesOn) {
  Machine machine(200);
  const auto stop = ride(machine, options(), 4.0);
  ASSERT_TRUE(stop.has_value());
  EXPECT_EQ(stop->event.cause, Cause::controller_overrun);
  EXPECT_GT(machine.moved, 3);  // on the last command, until it was stopped
  EXPECT_LT(machine.moved, 20);
  ASSERT_TRUE(stop->rest.has_value());
  EXPECT_LE(*stop->rest - stop->event.time, 2.01 * kPeriod);
}

TEST(SupervisedPlant, TheWatchdogStopsWhenTheSupervisorIsStarved) {
  Machine machine(200);
  SupervisedOptions how = options();
  how.limits.watchdog_periods = 2;
  int looks = 0;
  how.before_look = [&] {
    if (++looks == 3) sleep_periods(6.0);
  };
  const auto stop = ride(machine, how);
  ASSERT_TRUE(stop.has_value());
  EXPECT_EQ(stop->event.cause, Cause::supervisor_starved);
  EXPECT_TRUE(stop->spindle.has_value());
  EXPECT_LT(machine.moved, 20);
}

TEST(SupervisedPlant, FaultsOfBoneAndMachineStopItAndItNeverStartsAgain) {
  Machine machine(200);
  SupervisedOptions how = options();
  how.disturb = [](control::SupervisorInput& input) {
    if (input.clock > 3.5 * kPeriod && input.clock < 4.5 * kPeriod) input.temperature = 350.0;
  };
  int told = 0;
  how.on_event = [&](const control::LoopEvent& event) {
    told += event.cause == Cause::temperature ? 1 : 100;
  };
  const auto stop = ride(machine, how);  // the bone is cool again in the next period
  ASSERT_TRUE(stop.has_value());
  EXPECT_EQ(told, 1);
  EXPECT_LE(machine.moved, 6);
  EXPECT_LE(*stop->rest - stop->event.time, 2.01 * kPeriod);
}

TEST(SupervisedPlant, AMachineThatThrowsIsReportedToTheCaller) {
  Machine machine(200);
  machine.broken = true;
  EXPECT_THROW(ride(machine, options()), WorldError);
}

}  // namespace
}  // namespace osteomill::io
