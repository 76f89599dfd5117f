// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/signal_chain.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/record_check.hpp"
#include "osteomill/identify/record_for_test.hpp"

namespace osteomill::identify {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr CutOfRecord kCut{.spindle_speed = 5000.0 * units::rpm, .flutes = 2};

TEST(SignalChain, FindsTheMeanUnderNoiseRunOutOffsetAndDrift) {
  RecordForTest truth;
  truth.cut = 6.0;
  truth.speed = 5040.0;
  truth.noise = 1.0;
  truth.run_out = 0.4;
  truth.offset = {30.0, -12.0, 7.0};
  truth.drift = {0.4, -0.8, 0.2};
  const ProcessedRecord out =
      process(truth.make(), kCut, {.baseline = BaselineKind::drift, .filter_order = 9});
  for (int axis = 0; axis < 3; ++axis) {
    const PlateauMean& mean = out.mean[static_cast<std::size_t>(axis)];
    // White noise of 1 N over 6 s at 8 kHz leaves 0.005 N in the cut; the idle ends of 4000
    // samples leave 0.016 N each.
    EXPECT_NEAR(mean.mean, truth.mean[axis], 0.06) << axis;
    EXPECT_NEAR(mean.standard_error, 1.0 / std::sqrt(48000.0), 0.001) << axis;
  }
  EXPECT_NEAR(out.rotation->spindle_speed / units::rpm, 5040.0, 0.5);
  EXPECT_NEAR(out.run_out_ratio, 0.4, 0.03);
  EXPECT_THAT(out.warnings, IsEmpty());
  EXPECT_EQ(out.steps.size(), 8u);
  EXPECT_THAT(out.steps[3], HasSubstr("order 9 forward and backward, 1666.7 Hz = 10 × tooth"));
}

TEST(SignalChain, EveryStepCanBeLeftOut) {
  const ProcessedRecord out =
      process(RecordForTest{}.make(), kCut, {.rotation = RotationSource::none});
  EXPECT_FALSE(out.rotation);
  EXPECT_FALSE(out.revolution);
  EXPECT_THAT(out.envelope, IsEmpty());
  EXPECT_EQ(out.steps.size(), 3u);  // cuts, plateau, mean
}

TEST(SignalChain, ThePulseIsTakenWhereThereIsOne) {
  RecordForTest truth;
  truth.tacho = true;
  const ProcessedRecord out = process(truth.make(), kCut, {.average_flutes = true});
  EXPECT_TRUE(out.rotation->absolute);
  EXPECT_EQ(out.revolution->angle.size() % 2, 0);
}

TEST(SignalChain, SaysWhatIsOddAboutARecord) {
  RecordForTest truth;
  truth.tacho = true;
  const auto fast = process(truth.make(), {.spindle_speed = 4000.0 * units::rpm, .flutes = 2}, {});
  ASSERT_EQ(fast.warnings.size(), 1u);
  EXPECT_THAT(fast.warnings[0], HasSubstr("turned with 5000.0 rpm, not with 4000.0 rpm"));

  truth.tacho = false;
  truth.rate = 1000.0;
  truth.flutes = 8;
  const auto aliased =
      process(truth.make(), {.spindle_speed = 5000.0 * units::rpm, .flutes = 8}, {});
  ASSERT_EQ(aliased.warnings.size(), 2u);
  EXPECT_THAT(aliased.warnings[0], HasSubstr("666.7 Hz"));
  EXPECT_THAT(aliased.warnings[0], HasSubstr("shows at 333.3 Hz"));
  EXPECT_FALSE(aliased.revolution);
  EXPECT_NEAR(aliased.mean[1].mean, truth.mean[1], 0.05);

  truth = RecordForTest{.noise = 0.1};
  ForceRecord rising = truth.make();
  for (Eigen::Index i = 4000; i < 20000; ++i) rising.force(i, 1) -= 3e-4 * static_cast<double>(i);
  const auto drifting = process(rising, kCut, {});
  ASSERT_FALSE(drifting.warnings.empty());
  EXPECT_THAT(drifting.warnings.back(), HasSubstr("Fy goes by"));
}

TEST(SignalChain, NamesTheStepThatCannotBeDone) {
  struct Bad {
    SignalChain chain;
    const char* field;
  };
  RecordForTest whole;
  whole.idle = 0.0;
  const ForceRecord record = whole.make();
  for (const Bad& bad : {Bad{{.baseline = BaselineKind::tare}, "signals.baseline"},
                         {{.filter_order = 4, .cutoff_hz = 5000.0}, "signals.cutoff_hz"},
                         {{.rotation = RotationSource::tacho}, "record.tacho"},
                         {{.dynamometer = DynamometerResponse{}}, "signals.dynamometer_frf"}}) {
    try {
      process(record, kCut, bad.chain);
      ADD_FAILURE() << bad.field;
    } catch (const InvalidInput& error) {
      EXPECT_EQ(error.faults().front().field, bad.field);
    }
  }
}

TEST(Saturation, IsSeenWhereTheRangeIsKnownAndWhereItIsNot) {
  RecordForTest truth;
  truth.noise = 0.2;
  ForceRecord record = truth.make();
  EXPECT_THAT(find_saturation(record), IsEmpty());
  record.force.col(1) = record.force.col(1).cwiseMax(-28.0);
  const auto blind = find_saturation(record);
  ASSERT_EQ(blind.size(), 1u);
  EXPECT_EQ(blind[0].axis, 1);
  EXPECT_EQ(blind[0].level, -28.0);
  EXPECT_GT(blind[0].runs.size(), 100u);
  EXPECT_EQ(find_saturation(record, {100.0, 28.0, 100.0}).size(), 1u);
  EXPECT_THAT(find_saturation(record, {100.0, 100.0, 100.0}), IsEmpty());
}

TEST(CheckTime, FindsRateAndGaps) {
  Eigen::VectorXd time(1000);
  for (Eigen::Index i = 0; i < 1000; ++i)
    time[i] = static_cast<double>(i < 400 ? i : i + 7) / 2000.0;
  const TimeCheck check = check_time(time);
  EXPECT_NEAR(check.rate, 2000.0, 1e-6);
  ASSERT_EQ(check.gaps.size(), 1u);
  EXPECT_EQ(check.gaps[0].begin, 399);
  EXPECT_EQ(check.missing, 7.0);
}

TEST(CheckTime, MakesNothingOfTimesWithFewDigits) {
  // 8 kHz printed to four decimals: steps of 0.1 and 0.2 ms.
  Eigen::VectorXd time(8000);
  for (Eigen::Index i = 0; i < 8000; ++i)
    time[i] = std::round(static_cast<double>(i) / 8000.0 * 1e4) / 1e4;
  EXPECT_THAT(check_time(time).gaps, IsEmpty());
  EXPECT_NEAR(check_time(time).rate, 8000.0, 1.0);
}

TEST(CheckTime, RefusesATimeThatStandsOrFalls) {
  Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(10, 0.0, 1.0);
  time[5] = time[4];
  EXPECT_THROW(check_time(time), InvalidInput);
  time[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(check_time(time), InvalidInput);
  EXPECT_THROW(check_time(Eigen::VectorXd::Zero(2)), InvalidInput);
}

}  // namespace
}  // namespace osteomill::identify
