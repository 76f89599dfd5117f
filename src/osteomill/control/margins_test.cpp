// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/margins.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::control {
namespace {

const double kCritical = 2.0 * std::pow(std::sin(std::numbers::pi / 10.0), 2);  // 0.190983

/// Largest |eigenvalue| of the closed loop written out in time: two servo states, the accumulator,
/// the five taps and what the delay keeps. Independent of the frequency response. A gain that is
/// complex turns the loop by its angle, at every frequency alike.
double spectral_radius(const LinearPlant& plant, std::complex<double> gain) {
  const numerics::HeldLag held(*plant.servo, plant.period);
  const std::complex<double> loop = gain * plant.force_gain;
  // State: servo value and rate, v_ref, mean feeds of the last periods, newest first.
  const int waits = plant.delay_updates - 1;
  const int count = 8 + waits;
  Eigen::MatrixXcd a = Eigen::MatrixXcd::Zero(count, count);
  Eigen::RowVectorXcd reference = Eigen::RowVectorXcd::Zero(count);
  reference[2] = 1.0;
  reference.segment(3 + waits, 5).array() -= loop;
  const Eigen::Matrix3cd f = held.transition().cast<std::complex<double>>();
  const Eigen::Vector3cd b = held.input().cast<std::complex<double>>();
  a.block(0, 0, 2, 2) = f.bottomRightCorner(2, 2);
  a.topRows(2) += b.tail(2) * reference;
  a.row(2) = reference;
  a.block(3, 0, 1, 2) = f.row(0).tail(2) / plant.period;
  a.row(3) += b[0] / plant.period * reference;
  for (int tap = 4; tap < count; ++tap) a(tap, tap - 1) = 1.0;
  return a.eigenvalues().cwiseAbs().maxCoeff();
}

TEST(Margins, CriticalGainOfTheBarePublishedLoopIsTwiceTheSquareOfSinPiOverTen) {
  const LinearPlant plant{3800.0, std::nullopt, 10e-3, 1};
  const Margins found = margins(plant, 1e-5);
  // Rounding of the root finder: 50 bits of an angle near 0.6.
  EXPECT_NEAR(found.critical_loop_gain, kCritical, 1e-12);
  EXPECT_NEAR(found.critical_frequency, std::numbers::pi / 5.0 / 10e-3, 1e-9);
  EXPECT_NEAR(found.gain_margin, kCritical / 0.038, 1e-9);
}

TEST(Margins, AtTheCriticalGainTheClosedLoopHasAnEigenvalueOnTheUnitCircle) {
  for (const double w : {30.0, 62.8, 118.0}) {
    const LinearPlant plant{3800.0, numerics::SecondOrderLag{w, 0.7}, 10e-3, 1};
    const double critical = margins(plant, 1e-6).critical_loop_gain / plant.force_gain;
    EXPECT_NEAR(spectral_radius(plant, critical), 1.0, 1e-9) << w;
    EXPECT_LT(spectral_radius(plant, 0.98 * critical), 1.0) << w;
    EXPECT_GT(spectral_radius(plant, 1.02 * critical), 1.0) << w;
  }
}

TEST(Margins, GainAndPhaseMarginBringTheLoopInTimeToTheUnitCircleForSoftAndHardBone) {
  for (const double bone : {620.0, 3250.0, 14300.0}) {
    for (const int delay : {1, 3}) {
      const LinearPlant plant{bone, numerics::SecondOrderLag{118.0, 0.7}, 10e-3, delay};
      SugitaLoop loop;
      const double gain = gain_on_sum(loop, 0.3 * loop.gain_up);  // stable in all of them
      const Margins found = margins(plant, gain);
      const auto turned = [&](double angle) {
        return spectral_radius(plant, std::polar(gain, -angle));
      };
      EXPECT_NEAR(spectral_radius(plant, found.gain_margin * gain), 1.0, 1e-9) << bone;
      EXPECT_NEAR(turned(found.phase_margin), 1.0, 1e-9) << bone << " " << delay;
      EXPECT_LT(turned(0.98 * found.phase_margin), 1.0) << bone << " " << delay;
      EXPECT_GT(turned(1.02 * found.phase_margin), 1.0) << bone << " " << delay;
    }
  }
}

TEST(Margins, AStifferServoAndLessDelayAllowMoreGain) {
  const auto critical = [](double w, int delay) {
    return margins({3800.0, numerics::SecondOrderLag{w, 0.7}, 10e-3, delay}, 1e-6)
        .critical_loop_gain;
  };
  EXPECT_LT(critical(62.8, 1), critical(118.0, 1));
  EXPECT_LT(critical(118.0, 1), critical(1e4, 1));
  EXPECT_NEAR(critical(1e6, 1), kCritical, 1e-4 * kCritical);  // lag 2 eta/w_n = 1.4 us of 10 ms
  EXPECT_LT(critical(118.0, 3), critical(118.0, 1));
}

TEST(Margins, PhaseMarginIsZeroWhereTheGainMarginIsOne) {
  const LinearPlant plant{3800.0, numerics::SecondOrderLag{118.0, 0.7}, 10e-3, 1};
  const double critical = margins(plant, 1e-6).critical_loop_gain / plant.force_gain;
  const Margins at = margins(plant, critical * (1.0 - 1e-9));
  EXPECT_NEAR(at.gain_margin, 1.0, 1e-8);
  EXPECT_NEAR(at.phase_margin, 0.0, 1e-6);
}

TEST(Margins, TheLiteralSumIsUnstableForAnyBoneThatGivesTwelveNewtonNearThreeMillimetresASecond) {
  SugitaLoop loop;
  loop.reading = SumReading::sum;
  const LinearPlant plant{12.0 / 3e-3, numerics::SecondOrderLag{118.0, 0.7}, 10e-3, 1};
  EXPECT_LT(margins(plant, gain_on_sum(loop, loop.gain_up)).gain_margin, 1.0);
  loop.reading = SumReading::override;
  EXPECT_GT(margins(plant, gain_on_sum(loop, loop.gain_down)).gain_margin, 1.0);
}

TEST(Margins, RefusesWhatIsNoLoop) {
  const LinearPlant plant{3800.0, std::nullopt, 10e-3, 1};
  EXPECT_THROW(margins(plant, 0.0), InvalidInput);
  EXPECT_THROW(margins({0.0, std::nullopt, 10e-3, 1}, 1e-5), InvalidInput);
  EXPECT_THROW(margins({3800.0, std::nullopt, 10e-3, 0}, 1e-5), InvalidInput);
}

}  // namespace
}  // namespace osteomill::control
