// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/rotation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/record_for_test.hpp"
#include "osteomill/identify/revolution.hpp"

namespace osteomill::identify {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

RecordForTest cut_only() {
  RecordForTest truth;
  truth.idle = 0.0;
  return truth;
}

TEST(Rotation, FromThePulseIsTheAngleOfTheSpindle) {
  for (const double wander : {0.0, 0.01}) {
    RecordForTest truth = cut_only();
    truth.speed = 5013.0;
    truth.wander = wander;
    truth.tacho = true;
    const ForceRecord record = truth.make();
    const Rotation rotation = rotation_from_tacho(record.tacho, record.rate);
    EXPECT_TRUE(rotation.absolute);
    // The first pulse counts as 0; the truth counts from its own.
    const double shift = kTurn * std::round((truth.turn(0.0) - rotation.angle[0]) / kTurn);
    double worst = 0.0;
    for (Eigen::Index i = 0; i < rotation.angle.size(); ++i) {
      const double t = static_cast<double>(i) / record.rate;
      worst = std::max(worst, std::abs(rotation.angle[i] + shift - truth.turn(t)));
    }
    // Straight lines between pulses: the flank is straight too; a wander of 1 % at 1 Hz bends the
    // angle by ω·2π·1 %/8 of a squared revolution of 12 ms.
    EXPECT_LT(worst, wander > 0.0 ? 2e-2 : 1e-6) << wander;
    if (wander == 0.0) {
      EXPECT_NEAR(rotation.spindle_speed / units::rpm, 5013.0, 1e-4);
    } else {
      // A sine of 1 % has a standard deviation of 1 %/√2.
      EXPECT_NEAR(rotation.speed_deviation / rotation.spindle_speed, 0.01 / std::sqrt(2.0), 5e-4);
    }
  }
}

/// Largest difference from the truth once the unknown zero is taken out.
double angle_error(const Rotation& rotation, const RecordForTest& truth, double rate) {
  Eigen::VectorXd rest(rotation.angle.size());
  for (Eigen::Index i = 0; i < rest.size(); ++i)
    rest[i] = rotation.angle[i] - truth.turn(static_cast<double>(i) / rate);
  return (rest.array() - rest.mean()).abs().maxCoeff();
}

TEST(Rotation, FromTheToothPassingLineFollowsTheSpindle) {
  for (const int flutes : {1, 2, 4}) {
    RecordForTest truth = cut_only();
    truth.flutes = flutes;
    truth.cut = 6.0;
    truth.speed = 5117.0;  // nominal: 5000
    truth.noise = 2.0;
    truth.run_out = flutes == 1 ? 0.0 : 0.3;
    const ForceRecord record = truth.make();
    const Rotation rotation = rotation_from_line(record, 5000.0 * units::rpm, flutes);
    EXPECT_FALSE(rotation.absolute);
    EXPECT_NEAR(rotation.spindle_speed / units::rpm, 5117.0, 0.5) << flutes;
    // The phase of a block of 40 teeth in noise of 2 N about a line of 11 N: 0.01 rad a line.
    EXPECT_LT(angle_error(rotation, truth, record.rate), 0.03) << flutes;
  }
}

TEST(Rotation, FromTheLineFollowsASpeedThatWanders) {
  RecordForTest truth = cut_only();
  truth.cut = 4.0;
  truth.wander = 0.003;
  truth.noise = 0.5;
  const ForceRecord record = truth.make();
  const Rotation rotation = rotation_from_line(record, 5000.0 * units::rpm, 2);
  // Against 1.5 rad by which a constant speed would be wrong.
  EXPECT_LT(angle_error(rotation, truth, record.rate), 0.1);
}

TEST(Rotation, OfAGivenSpeedIsALine) {
  const Rotation rotation = rotation_of_speed(81, 8000.0, 6000.0 * units::rpm);
  EXPECT_NEAR(rotation.angle[80], kTurn, 1e-12);
}

TEST(Rotation, NamesWhatItCannotFollow) {
  Eigen::VectorXd pulses = Eigen::VectorXd::Zero(1000);
  EXPECT_THROW(rotation_from_tacho(pulses, 1000.0), InvalidInput);
  for (Eigen::Index i = 10; i < 1000; i += 50) pulses[i] = 5.0;
  EXPECT_NO_THROW(rotation_from_tacho(pulses, 1000.0));
  Eigen::VectorXd missing = pulses;
  missing[510] = 0.0;
  try {
    rotation_from_tacho(missing, 1000.0);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(error.faults().front().value.find("0.1 s at 0.4"), std::string::npos) << error.what();
  }
  EXPECT_THROW(rotation_from_tacho({}, 1000.0), InvalidInput);

  RecordForTest truth = cut_only();
  truth.noise = 1.0;
  const ForceRecord record = truth.make();
  EXPECT_THROW(rotation_from_line(record, 8000.0 * units::rpm, 2), InvalidInput);   // elsewhere
  EXPECT_THROW(rotation_from_line(record, 60000.0 * units::rpm, 4), InvalidInput);  // aliased
  EXPECT_THROW(rotation_from_line(record, 20.0 * units::rpm, 2), InvalidInput);     // too short
}

TEST(RevolutionAverage, IsTheForceOverTheAngle) {
  for (const double speed : {5000.0, 5117.3}) {  // locked to the sampling, and not
    RecordForTest truth = cut_only();
    truth.speed = speed;
    truth.run_out = 0.5;
    truth.tacho = true;
    const ForceRecord record = truth.make();
    const Rotation rotation = rotation_from_tacho(record.tacho, record.rate);
    const RevolutionAverage average = average_revolution(record.force, rotation);
    EXPECT_GE(average.angle.size(), 90);
    for (Eigen::Index k = 0; k < average.angle.size(); ++k) {
      const Eigen::Vector3d here = average.force.row(k).transpose();
      // A bin of 1/96 turn averages the fourth order (the tooth's second) over its width: sinc
      // takes 0.3 % of 9 N off.
      EXPECT_LT((here - truth.at(average.angle[k])).norm(), 0.05) << speed << " bin " << k;
    }
    EXPECT_LT((average.mean - truth.mean).norm(), 1e-3) << speed;
    EXPECT_EQ(average.revolutions, static_cast<int>(2.0 * speed / 60.0 + 1e-6));
  }
}

TEST(RevolutionAverage, StatesTheErrorThatNoiseLeaves) {
  RecordForTest truth = cut_only();
  truth.noise = 1.5;
  truth.cut = 10.0;
  const ForceRecord record = truth.make();
  const Rotation rotation =
      rotation_of_speed(record.force.rows(), record.rate, truth.speed * units::rpm);
  const RevolutionAverage average = average_revolution(record.force, rotation);
  // 833 revolutions, one sample of each in a bin.
  const double expected = 1.5 / std::sqrt(833.0);
  EXPECT_NEAR(average.standard_error.mean(), expected, 0.03 * expected);
  double squares = 0.0;
  for (Eigen::Index k = 0; k < average.angle.size(); ++k) {
    squares +=
        (average.force.row(k).transpose() - truth.at(average.angle[k] + truth.start)).squaredNorm();
  }
  const double seen = std::sqrt(squares / static_cast<double>(3 * average.angle.size()));
  // 288 values: their deviation is known to 4 %.
  EXPECT_NEAR(seen, expected, 0.12 * expected);
}

TEST(PitchAverage, OfTwoFlutesIsTheMeanOfTheHalves) {
  RecordForTest truth = cut_only();
  truth.run_out = 0.8;
  truth.noise = 0.3;
  const ForceRecord record = truth.make();
  const Rotation rotation =
      rotation_of_speed(record.force.rows(), record.rate, truth.speed * units::rpm);
  const RevolutionAverage whole = average_revolution(record.force, rotation, 96);
  const RevolutionAverage halves = average_pitch(record.force, rotation, 2, 96);
  for (Eigen::Index k = 0; k < 48; ++k) {
    const Eigen::RowVector3d mean = 0.5 * (whole.force.row(k) + whole.force.row(k + 48));
    EXPECT_LT((halves.force.row(k) - mean).norm(), 1e-12);
    EXPECT_EQ(halves.force.row(k), halves.force.row(k + 48));
  }
}

TEST(PitchAverage, TakesEveryOrderOfRunOutAway) {
  for (const int flutes : {1, 2, 3, 8}) {
    RecordForTest truth = cut_only();
    truth.flutes = flutes;
    truth.rate = 48000.0;
    truth.run_out = flutes == 1 ? 0.0 : 0.8;
    const ForceRecord record = truth.make();
    const Rotation rotation =
        rotation_of_speed(record.force.rows(), record.rate, truth.speed * units::rpm);
    const RevolutionAverage average = average_pitch(record.force, rotation, flutes, 288);
    EXPECT_EQ(average.angle.size() % flutes, 0);
    truth.run_out = 0.0;
    for (Eigen::Index k = 0; k < average.angle.size(); ++k) {
      // Averaging within bins of 1/288 turn takes 0.5 % off order 16 of 8 flutes.
      EXPECT_LT(
          (average.force.row(k).transpose() - truth.at(average.angle[k] + truth.start)).norm(),
          0.06)
          << flutes;
    }
  }
}

TEST(RotationHarmonics, AreTheAmplitudesThatWereMade) {
  RecordForTest truth = cut_only();
  truth.run_out = 0.25;
  const ForceRecord record = truth.make();
  const Rotation rotation =
      rotation_of_speed(record.force.rows(), record.rate, truth.speed * units::rpm);
  const auto harmonics = rotation_harmonics(record.force, rotation, 6);
  // Bins of 1/8192 turn: 1e-5 of the amplitudes.
  EXPECT_LT((harmonics[0].amplitude - 0.25 * truth.ripple).norm(), 1e-3);
  EXPECT_LT((harmonics[1].amplitude - Eigen::Vector3d(6.0, 9.0, 0.0)).norm(), 1e-3);
  EXPECT_LT((harmonics[3].amplitude - Eigen::Vector3d(0.0, 0.0, 2.0)).norm(), 1e-3);
  EXPECT_LT(harmonics[2].amplitude.norm() + harmonics[4].amplitude.norm(), 1e-3);
  EXPECT_NEAR(harmonics[1].phase[0], std::remainder(2.0 * truth.start, kTurn), 1e-3);
}

TEST(RevolutionAverage, RefusesLessThanARevolution) {
  const Rotation rotation = rotation_of_speed(50, 8000.0, 5000.0 * units::rpm);
  EXPECT_THROW(average_revolution(Eigen::MatrixX3d::Zero(50, 3), rotation), InvalidInput);
  EXPECT_THROW(average_revolution(Eigen::MatrixX3d::Zero(40, 3), rotation), InvalidInput);
  EXPECT_THROW(average_revolution(Eigen::MatrixX3d::Zero(0, 3), {}), InvalidInput);
  const Rotation some = rotation_of_speed(200, 8000.0, 5000.0 * units::rpm);
  // More bins than samples: flutes cannot be averaged over empty ones.
  EXPECT_THROW(average_pitch(Eigen::MatrixX3d::Zero(200, 3), some, 2, 4000), InvalidInput);
  EXPECT_THROW(average_pitch(Eigen::MatrixX3d::Zero(200, 3), some, 0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::identify
