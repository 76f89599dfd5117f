// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/supervisor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"

namespace osteomill::control {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

/// A healthy cut at 5 mm/s that lets itself be disturbed; the tool follows the feed it is given.
class Cell {
 public:
  using Disturb = std::function<void(SupervisorInput&)>;

  SupervisorStep advance(const Disturb& disturb = {}) {
    ++period_;
    SupervisorInput input;
    input.clock = 0.01 * period_;
    input.sample_clock = input.clock;
    input.mean_force = 12.0 + 0.01 * (period_ % 7);
    input.peak_force = 1.5 * input.mean_force;
    input.torque = 0.02;
    input.tooth_line = 6.0;
    input.feed = feed_;
    input.command = 5e-3;
    if (disturb) disturb(input);
    const SupervisorStep next = supervise(limits_, state_, input);
    state_ = next.state;
    // A servo of 12 ms.
    feed_ += 0.57 * (next.feed - feed_);
    return next;
  }
  void confirm() { state_ = confirmed(); }
  const SupervisorState& state() const { return state_; }

 private:
  SupervisorLimits limits_;
  SupervisorState state_;
  double feed_ = 5e-3;
  int period_ = 0;
};

struct Injection {
  Cause cause;
  Cell::Disturb disturb;
  int periods;  ///< until it must be found
};

std::vector<Injection> injections() {
  using In = SupervisorInput;
  return {
      {Cause::force_overload, [](In& in) { in.peak_force = 151.0; }, 1},
      {Cause::torque_overload, [](In& in) { in.torque = -2.1; }, 1},
      {Cause::force_rate, [](In& in) { in.mean_force += 160.0, in.peak_force = 149.0; }, 1},
      {Cause::tool_breakage, [](In& in) { in.tooth_line = 1.0, in.revolution_line = 9.0; }, 3},
      {Cause::stall, [](In& in) { in.feed = 0.0; }, 52},
      {Cause::temperature, [](In& in) { in.temperature = 343.2; }, 1},
      {Cause::no_go, [](In& in) { in.no_go_distance = 0.4e-3; }, 1},
      {Cause::no_go, [](In& in) { in.no_go_distance = kNan; }, 1},
      {Cause::command_range, [](In& in) { in.command = 12.1e-3; }, 1},
      {Cause::command_range, [](In& in) { in.command = -1e-6; }, 1},
      {Cause::command_range, [](In& in) { in.command = kNan; }, 1},
      {Cause::sensor_stale, [](In& in) { in.sample_clock -= 20e-3; }, 1},
      {Cause::sensor_stale, [](In& in) { in.sample_clock = kNan; }, 1},
      {Cause::sensor_saturated, [](In& in) { in.sensor_saturated = true; }, 1},
      {Cause::sensor_not_a_number, [](In& in) { in.mean_force = kNan; }, 1},
      {Cause::sensor_not_a_number, [](In& in) { in.peak_force = 1.0 / 0.0; }, 1},
      {Cause::sensor_frozen, [](In& in) { in.mean_force = 12.5; }, 11},
      {Cause::clock_jump, [](In& in) { in.clock -= 0.02, in.sample_clock = in.clock; }, 1},
      {Cause::clock_jump, [](In& in) { in.clock += 0.02, in.sample_clock = in.clock; }, 1},
      {Cause::clock_jump, [](In& in) { in.clock = kNan; }, 1},
      {Cause::machine_lost, [](In& in) { in.machine_answers = false; }, 1},
      {Cause::machine_lost, [](In& in) { in.feed = kNan; }, 1},
      {Cause::controller_overrun, [](In& in) { in.compute_time = 11e-3; }, 1},
      {Cause::controller_overrun, [](In& in) { in.compute_time = kNan; }, 1},
      {Cause::supervisor_starved, [](In& in) { in.periods_unseen = 6; }, 1},
  };
}

TEST(Supervisor, LetsAHealthyCutThrough) {
  Cell cell;
  for (int i = 0; i < 5000; ++i) {
    const SupervisorStep next = cell.advance();
    ASSERT_EQ(next.feed, 5e-3);
    ASSERT_FALSE(next.feed_hold || next.spindle_inhibit || next.tripped);
  }
}

TEST(Supervisor, FindsEveryFaultInTimeAndStopsInTheSamePeriod) {
  for (const Injection& fault : injections()) {
    Cell cell;
    for (int i = 0; i < 20; ++i) cell.advance();
    int needed = 0;
    SupervisorStep next;
    do {
      next = cell.advance(fault.disturb);
      ++needed;
    } while (!next.tripped && needed < 100);
    EXPECT_EQ(next.state.cause, fault.cause) << name(fault.cause);
    EXPECT_LE(needed, fault.periods) << name(fault.cause);
    EXPECT_EQ(next.feed, 0.0);
    EXPECT_TRUE(next.feed_hold);
  }
}

TEST(Supervisor, ALateLookAtManySamplesIsNoSteepRiseAndASilentSensorIsNotAFrozenOne) {
  // 160 N in a period of 10 ms are too many; over the 20 ms that the samples took they are not.
  Cell late;
  late.advance();
  const auto rise = [](SupervisorInput& in) { in.mean_force += 160.0, in.peak_force = 149.0; };
  EXPECT_FALSE(
      late.advance([&](SupervisorInput& in) { rise(in), in.sample_span = 20e-3; }).tripped);
  Cell silent;
  SupervisorStep next;
  for (int i = 0; i < 40 && !next.tripped; ++i) {
    next = silent.advance([](SupervisorInput& in) { in.mean_force = 12.5, in.fresh = false; });
  }
  EXPECT_FALSE(next.tripped);
}

TEST(Supervisor, EveryCauseIsInTheFaultTable) {
  for (int cause = 1; cause < kCauses; ++cause) {
    bool listed = false;
    for (const Injection& fault : injections()) listed |= fault.cause == static_cast<Cause>(cause);
    EXPECT_TRUE(listed) << name(static_cast<Cause>(cause));
  }
}

TEST(Supervisor, SpindleTurnsOnUntilTheToolRestsUnlessTheSpindleIsTheFault) {
  Cell overloaded;
  overloaded.advance();
  EXPECT_FALSE(
      overloaded.advance([](SupervisorInput& in) { in.peak_force = 200.0; }).spindle_inhibit);
  int periods = 0;
  while (!overloaded.advance().spindle_inhibit) ++periods;
  EXPECT_LE(periods, 10);  // spindle_delay
  Cell torque;
  torque.advance();
  EXPECT_TRUE(torque.advance([](SupervisorInput& in) { in.torque = 3.0; }).spindle_inhibit);
}

TEST(Supervisor, NeverStartsByItselfAndOnlyTheOperatorLetsItGoOn) {
  Cell cell;
  cell.advance();
  cell.advance([](SupervisorInput& in) { in.peak_force = 200.0; });
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(cell.advance().feed, 0.0);
  cell.confirm();
  EXPECT_EQ(cell.advance().feed, 5e-3);
}

TEST(Supervisor, TwoHundredRandomFaultSequencesLeaveNoFeedAfterAStop) {
  // The model: once any fault has been reported, feed is zero and held until the operator confirms.
  const std::vector<Injection> faults = injections();
  for (std::uint64_t sequence = 0; sequence < 200; ++sequence) {
    Random random(11, sequence);
    Cell cell;
    bool stopped = false;
    for (int i = 0; i < 300; ++i) {
      if (stopped && random.uniform() < 0.02) {
        cell.confirm();
        stopped = false;
      }
      const bool disturbed = random.uniform() < 0.05;
      const auto which =
          static_cast<std::size_t>(random.uniform() * static_cast<double>(faults.size()));
      const SupervisorStep next = cell.advance(disturbed ? faults[which].disturb : Cell::Disturb{});
      if (next.tripped) {
        ASSERT_FALSE(stopped);  // one event a stop
        stopped = true;
      }
      ASSERT_EQ(next.feed_hold, stopped);
      ASSERT_TRUE(!stopped || next.feed == 0.0);
      ASSERT_TRUE(std::isfinite(next.feed) && next.feed >= 0.0 && next.feed <= 12.012e-3);
    }
  }
}

TEST(Supervisor, CannotThrowAndRefusesLimitsThatAreNone) {
  static_assert(noexcept(supervise(std::declval<const SupervisorLimits&>(),
                                   std::declval<const SupervisorState&>(),
                                   std::declval<const SupervisorInput&>())));
  SupervisorLimits limits;
  EXPECT_NO_THROW(check(limits));
  limits.force = 0.0;
  EXPECT_THROW(check(limits), InvalidInput);
  limits = {};
  limits.frozen_periods = -1;
  EXPECT_THROW(check(limits), InvalidInput);
  limits = {};
  limits.period = kNan;
  EXPECT_THROW(check(limits), InvalidInput);
}

}  // namespace
}  // namespace osteomill::control
