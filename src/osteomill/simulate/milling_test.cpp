// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/milling.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/simulate/line_profile.hpp"
#include "osteomill/simulate/summary.hpp"

namespace osteomill::simulate {
namespace {

LineProfile cortical(double edge_force = 0.0) {
  LineProfile profile;
  profile.zones = {{0.0, 66e-3, 3800.0, {}, {}}};
  profile.edge_force = edge_force;
  return profile;
}

Machine machine(double rpm = 6000.0) {
  Machine machine;
  machine.spindle_speed = rpm * units::rpm;
  machine.servo = numerics::SecondOrderLag{118.0, 0.7};
  return machine;
}

/// A feed that changes with place and time, so that the servo always has something to follow.
std::vector<Step> mill(const Machine& on, const LineProfile& profile, double force_limit = 30.0) {
  LineProfileWorkpiece workpiece(profile);
  Milling milling(workpiece, on, force_limit);
  for (int i = 0; !milling.finished(); ++i) {
    milling.advance({(4.0 + 3.0 * std::sin(0.02 * i)) * 1e-3, 0, false});
  }
  return milling.steps();
}

TEST(Milling, ConstantFeedTakesThePathsLengthOverTheFeed) {
  LineProfileWorkpiece workpiece(cortical());
  Milling milling(workpiece, machine(), 30.0);
  while (!milling.finished()) milling.advance({3e-3, 0, false});
  const Summary summary = summarise(milling.steps(), 3, Status::finished);
  // Contact to exit, two changes of line that each wait for the end of a control period.
  const double path = 3 * (66.0 + std::sqrt(7.0) * 1.0) + 2 * (10.35 + 8.0);
  EXPECT_NEAR(summary.cutting_time, path / 3.0, 2 * 10e-3);
  // 80 samples a revolution hit the crest of the ripple of each of the two teeth.
  EXPECT_NEAR(summary.peak_force, 2.0 * 3.8 * 3.0, 1e-9);
  EXPECT_NEAR(summary.line_times[1], (66.0 + std::sqrt(7.0)) / 3.0, 2.0 / 8000.0);
  EXPECT_NEAR(summary.max_feed, 3e-3, 1e-12);
  EXPECT_TRUE(summary.saturated_intervals.empty());
}

TEST(Milling, ForceMaterialAndRemovalAreNowhereInAir) {
  int air = 0;
  for (const Step& step : mill(machine(), cortical(5.0))) {
    if (step.samples_in_contact > 0) continue;
    ++air;
    EXPECT_EQ(step.peak_force, 0.0);
    EXPECT_EQ(step.removed_volume, 0.0);
    EXPECT_EQ(step.material, 0.0);
    EXPECT_EQ(step.feed_work, 0.0);
  }
  EXPECT_GT(air, 100);
}

TEST(Milling, RemovesTheCrossSectionTimesTheLengthWhateverTheFeed) {
  const LineProfile profile = cortical();
  const Summary summary = summarise(mill(machine(), profile), 3, Status::finished);
  // 8 kHz at 7 mm/s: 0.9 um a sample, at each of 80 jumps of the share by 1/40: below 1e-5.
  EXPECT_NEAR(summary.removed_volume / (3 * 66e-3 * cross_section(profile)), 1.0, 1e-5);
}

TEST(Milling, WorkIsTheForceTimesTheVelocityOverTheRecord) {
  const std::vector<Step> steps = mill(machine(), cortical());
  const Summary summary = summarise(steps, 3, Status::finished);
  double work = 0.0;
  double last_position = 0.0;
  for (const Step& step : steps) {
    work -= step.mean_force_W.x() * (step.position - last_position);
    last_position = step.position;
  }
  // The product of means differs from the mean of products by the change of feed in a period,
  // at most 7 mm/s x 0.02 per period, squared over 12, against 16 mm²/s².
  EXPECT_NEAR(work / summary.feed_work, 1.0, 1e-4);
  EXPECT_EQ(summary.spindle_work, 0.0);
}

TEST(Milling, TheSensorsMeanDoesNotSeeTheTooth) {
  // In full engagement at constant feed the reported mean force is that of the law, for a spindle
  // whose revolution is as long as, shorter and longer than the control period.
  for (const double rpm : {6000.0, 12000.0, 3000.0}) {
    LineProfileWorkpiece workpiece(cortical());
    Milling milling(workpiece, machine(rpm), 30.0);
    Report report;
    for (int i = 0; i < 1000; ++i) report = milling.advance({3e-3, 0, false});
    EXPECT_NEAR(report.mean_force, 3.8 * 3.0, 1e-9) << rpm;
  }
}

TEST(Milling, TheSpectrumHasTheToothAndNoLineAtTheSpindle) {
  LineProfileWorkpiece workpiece(cortical());
  Milling milling(workpiece, machine(), 30.0);
  Report report;
  for (int i = 0; i < 1000; ++i) report = milling.advance({3e-3, 0, false});
  // The ripple is 1 + (2 - 1) cos: its amplitude is the mean force.
  EXPECT_NEAR(report.tooth_line, 3.8 * 3.0, 1e-6);
  EXPECT_NEAR(report.revolution_line, 0.0, 1e-6);
}

TEST(Milling, DelayAndNoiseAreInTheReportAndNotInTheRecord) {
  Machine noisy = machine();
  noisy.force_noise = 1.0;
  noisy.delay_updates = 3;
  LineProfileWorkpiece workpiece(cortical());
  Milling milling(workpiece, noisy, 30.0);
  std::vector<double> reported;
  while (milling.steps().size() < 2000) {
    reported.push_back(milling.advance({3e-3, 0, false}).mean_force);
  }
  const std::vector<Step>& steps = milling.steps();
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 2; i < steps.size(); ++i) {
    const double noise = reported[i] - steps[i - 2].mean_force;
    sum += noise;
    squares += noise * noise;
  }
  const double count = static_cast<double>(steps.size() - 2);
  EXPECT_NEAR(sum / count, 0.0, 4.0 / std::sqrt(count));            // four standard errors
  EXPECT_NEAR(squares / count, 1.0, 4.0 * std::sqrt(2.0 / count));  // likewise
}

TEST(Milling, TheSameInputGivesTheSameRunBitForBit) {
  Machine noisy = machine();
  noisy.force_noise = 1.0;
  const std::vector<Step> first = mill(noisy, cortical());
  const std::vector<Step> again = mill(noisy, cortical());
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    ASSERT_EQ(first[i].position, again[i].position);
    ASSERT_EQ(first[i].mean_force, again[i].mean_force);
  }
}

TEST(Milling, RefusesWhatIsNoMachine) {
  LineProfileWorkpiece workpiece(cortical());
  const auto broken = [&](auto change) {
    Machine made = machine();
    change(made);
    return made;
  };
  EXPECT_NO_THROW(check(machine()));
  EXPECT_THROW(check(broken([](Machine& m) { m.spindle_speed = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Machine& m) { m.period = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Machine& m) { m.sample_rate = 8050.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Machine& m) { m.delay_updates = 0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Machine& m) { m.force_noise = -1.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Machine& m) { m.servo->damping_ratio = 0.0; })), InvalidInput);
  EXPECT_THROW(Milling(workpiece, machine(), 0.0), InvalidInput);
  Milling milling(workpiece, machine(), 30.0);
  EXPECT_THROW(milling.advance({-1e-3, 0, false}), InvalidInput);
  EXPECT_THROW(milling.advance({std::nan(""), 0, false}), InvalidInput);
}

TEST(Summary, SaysThatItWasNotRun) {
  EXPECT_STREQ(name(Summary{}.status), "not run");
  EXPECT_EQ(summarise({}, 3, Status::stopped).cutting_time, 0.0);
}

TEST(Summary, SaturationCountsOnlyInBoneAndOnlyWhenItLasts) {
  std::vector<Step> steps(100);
  for (int i = 0; i < 100; ++i) {
    Step& step = steps[i];
    step.time = 0.01 * (i + 1);
    step.saturated = i < 50 || i == 70;
    if (i >= 20) {
      step.samples_in_contact = 80;
      step.first_contact = 0.01 * i + 1.0 / 8000.0;
      step.last_contact = step.time;
    }
  }
  const Summary summary = summarise(steps, 1, Status::finished);
  ASSERT_EQ(summary.saturated_intervals.size(), 1u);
  EXPECT_NEAR(summary.saturated_intervals[0][0], 0.0, 1e-3);
  EXPECT_NEAR(summary.saturated_intervals[0][1], 0.3, 1e-3);
}

TEST(Milling, ASpindleThatTurnsFasterCutsThinnerChipsAndTakesLessForce) {
  LineProfile bone;
  bone.lines = 1;
  bone.zones = {{0.0, 66e-3, 3800.0, {}, {}}};
  bone.spindle_speed = 600.0;
  Machine machine;
  machine.spindle_speed = 600.0;
  machine.spindle = SpindleDrive{300.0, 1200.0, 0.05};
  LineProfileWorkpiece workpiece(bone);
  Milling milling(workpiece, machine, 30.0);
  double before = 0.0;
  for (int i = 0; i < 1500; ++i) {
    // Asked for more than it has: held at its fastest.
    milling.advance({3e-3, 0, false, i < 750 ? 600.0 : 5000.0});
    if (i == 749) before = milling.steps().back().mean_force;
  }
  EXPECT_NEAR(milling.report().spindle_speed, 1200.0, 1e-6);
  // The ripple does not average out to the last sample of a window of whole samples: 1/52.
  EXPECT_NEAR(milling.steps().back().mean_force / before, 0.5, 0.02);
  machine.spindle->lowest = 700.0;
  EXPECT_THROW(Milling(workpiece, machine, 30.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::simulate
