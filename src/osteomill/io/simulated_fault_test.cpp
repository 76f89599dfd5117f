// SPDX-License-Identifier: BSD-3-Clause
// Every fault that the supervisor knows, brought into a simulated cut with the published servo. The
// same on LinuxCNC: apps/linuxcnc/machine_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <set>
#include <vector>

#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/control/loop.hpp"
#include "osteomill/io/simulated_plant.hpp"
#include "osteomill/simulate/line_profile.hpp"

namespace osteomill::io {
namespace {

using control::Cause;
using In = control::SupervisorInput;

constexpr double kStanding = 0.05e-3;  // slower is no motion, as the supervisor has it, m/s

struct Fault {
  Cause cause;
  std::function<void(In&)> bring;
};

std::vector<Fault> faults() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return {
      {Cause::force_overload, [](In& in) { in.peak_force += 200.0; }},
      {Cause::torque_overload, [](In& in) { in.torque = -2.1; }},
      {Cause::force_rate, [](In& in) { in.mean_force += 160.0; }},
      {Cause::tool_breakage,
       [](In& in) {
         in.mean_force = 12.0 + in.clock, in.tooth_line = 1.0, in.revolution_line = 9.0;
       }},
      {Cause::stall, [](In& in) { in.feed = 0.0; }},
      {Cause::temperature, [](In& in) { in.temperature = 343.2; }},
      {Cause::no_go, [](In& in) { in.no_go_distance = 0.4e-3; }},
      {Cause::command_range, [](In& in) { in.command = 20e-3; }},
      {Cause::command_range, [nan](In& in) { in.command = nan; }},
      {Cause::sensor_stale, [](In& in) { in.sample_clock -= 20e-3; }},
      {Cause::sensor_saturated, [](In& in) { in.sensor_saturated = true; }},
      {Cause::sensor_not_a_number, [nan](In& in) { in.mean_force = nan; }},
      {Cause::sensor_frozen, [](In& in) { in.mean_force = 12.5; }},
      {Cause::clock_jump, [](In& in) { in.clock -= 1.0, in.sample_clock = in.clock; }},
      {Cause::machine_lost, [](In& in) { in.machine_answers = false; }},
      {Cause::controller_overrun, [](In& in) { in.compute_time = 11e-3; }},
      {Cause::supervisor_starved, [](In& in) { in.periods_unseen = 6; }},
  };
}

/// A tibia line that is milled under the published loop, and everything that was commanded.
class Bench final : public control::Plant {
 public:
  Bench() {
    options_.supervisor = control::SupervisorLimits{};
    options_.path_length = bone_.length();
    options_.disturb = [this](In& in) {
      if (disturb) disturb(in);
    };
    options_.on_event = [this](const control::LoopEvent& event) { told.push_back(event); };
    controller_.law = control::SugitaLoop{};
    controller_.limits.lowest = 0.4e-3;
  }
  control::LoopSummary run(const Progress& progress = {}) {
    return control::run(*this, controller_, options_, progress);
  }

  control::Observation start() override { return plant_.start(); }
  control::Observation advance(const control::FeedCommand& command) override {
    const control::Observation seen = plant_.advance(command);
    commands.push_back(command.feed);
    feeds.push_back(seen.feed);
    stopped_at.push_back(told.size());
    return seen;
  }

  std::function<void(In&)> disturb;
  std::vector<control::LoopEvent> told;
  std::vector<double> commands, feeds;
  std::vector<std::size_t> stopped_at;  ///< events so far, a period

 private:
  static simulate::LineProfile profile() {
    simulate::LineProfile made;
    made.zones = {{0.0, 66e-3, 3250.0, {}, {}}};
    return made;
  }
  static simulate::Machine machine() {
    simulate::Machine made;
    made.spindle_speed = 6000 * units::rpm;
    made.servo = numerics::SecondOrderLag{118.0, 0.7};
    made.force_noise = 0.5;
    return made;
  }
  simulate::LineProfileWorkpiece bone_{profile()};
  simulate::Milling milling_{bone_, machine(), 30.0};
  SimulatedPlant plant_{milling_};
  control::LoopOptions options_;
  control::FeedController controller_;
};

TEST(SimulatedFaults, EveryFaultStopsTheCutAndIsAnEvent) {
  constexpr int kFrom = 500;  // periods: within the bone
  std::printf("%-20s %10s %10s\n", "event", "seen, ms", "rest, ms");
  std::set<Cause> seen;
  for (const Fault& fault : faults()) {
    SCOPED_TRACE(control::name(fault.cause));
    Bench bench;
    int period = 0;
    bench.disturb = [&](In& in) {
      if (++period > kFrom) fault.bring(in);
    };
    EXPECT_EQ(bench.run().end, control::LoopEnd::supervisor);
    ASSERT_EQ(bench.told.size(), 1U);
    EXPECT_EQ(bench.told[0].cause, fault.cause);
    seen.insert(fault.cause);
    const auto stop = static_cast<std::size_t>(
        std::find(bench.stopped_at.begin(), bench.stopped_at.end(), 1U) - bench.stopped_at.begin());
    std::size_t rest = stop;
    while (rest < bench.feeds.size() && bench.feeds[rest] > kStanding) ++rest;
    ASSERT_LT(rest, bench.feeds.size());
    std::printf("%-20s %10d %10d\n", control::name(fault.cause),
                10 * static_cast<int>(stop - kFrom), 10 * static_cast<int>(rest - stop + 1));
  }
  EXPECT_EQ(static_cast<int>(seen.size()), control::kCauses - 1) << "a cause is not in the table";
}

// The model: milling until the first event; then every command is zero and the tool comes to rest,
// whatever faults come and go, until the operator begins anew.
TEST(SimulatedFaults, TwoHundredRandomSequencesLeaveNoFeedAfterAStop) {
  const std::vector<Fault> all = faults();
  int stops = 0;
  for (std::uint64_t sequence = 0; sequence < 200; ++sequence) {
    SCOPED_TRACE(sequence);
    Random random(29, sequence);
    Bench bench;
    const Fault* brought = nullptr;
    std::set<Cause> possible;
    bench.disturb = [&](In& in) {
      if (random.uniform() < 0.02) {
        brought = random.uniform() < 0.3
                      ? nullptr
                      : &all[static_cast<std::size_t>(random.uniform() * double(all.size()))];
      }
      if (brought == nullptr) return;
      possible.insert(brought->cause);
      brought->bring(in);
    };
    for (int confirmations = 0; confirmations < 4; ++confirmations) {
      const std::size_t begin = bench.commands.size();
      const std::size_t events = bench.told.size();
      const control::LoopEnd end = bench.run().end;
      if (end != control::LoopEnd::supervisor) break;
      ++stops;
      ASSERT_EQ(bench.told.size(), events + 1) << "one event a stop";
      EXPECT_TRUE(possible.contains(bench.told.back().cause))
          << control::name(bench.told.back().cause);
      for (std::size_t i = begin; i < bench.commands.size(); ++i) {
        ASSERT_TRUE(std::isfinite(bench.commands[i]) && bench.commands[i] >= 0.0);
        if (bench.stopped_at[i] > events) {
          ASSERT_EQ(bench.commands[i], 0.0);
        }
      }
      if (bench.commands.size() > begin) {
        ASSERT_LE(bench.feeds.back(), kStanding) << "it stands";
      }
    }
  }
  std::printf("200 sequences, %d stops\n", stops);
  EXPECT_GT(stops, 200);
}

}  // namespace
}  // namespace osteomill::io
