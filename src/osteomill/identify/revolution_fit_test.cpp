// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/revolution_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::identify {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kRate = 8000.0;
// No whole number of samples a turn: 96.85.
constexpr double kSpeed = 4956.0 * units::rpm;
constexpr double kPhase = 1.4;

const cutting::Cutter kCutter{
    .radius = 3.175e-3, .flutes = 2, .helix_angle = 0.52, .cutting_length = 10e-3};
const cutting::Condition kCondition{.spindle_speed = kSpeed, .feed_per_tooth = 20e-6};
const cutting::Immersion kImmersion{cutting::ImmersionKind::down, 3.175e-3, 4e-3};
const cutting::RunOut kRunOut{7e-6, 2.1, 0.0, 0.0};

Eigen::VectorXd truth() {
  Eigen::VectorXd values(9);
  values << 60e6, 45e6, 12e6, 4e3, 6e3, -1e3, kRunOut.offset * std::cos(kRunOut.offset_angle),
      kRunOut.offset * std::sin(kRunOut.offset_angle), kPhase;
  return values;
}

/// Forces over a turn in steps of a quarter degree; records are drawn from it.
const Eigen::MatrixX3d& turn() {
  static const Eigen::MatrixX3d forces = [] {
    std::vector<double> angle;
    for (int i = 0; i < 1440; ++i) angle.push_back(kTurn * i / 1440);
    const EdgeColumns columns(kCutter, kCondition, kImmersion, linear_law_units());
    const Eigen::VectorXd all = columns.at(angle, kPhase, kRunOut) * truth().head(6);
    return Eigen::MatrixX3d(all.reshaped(1440, 3));
  }();
  return forces;
}

struct Trial {
  double idle = 0.15;                        ///< before and after the cut, s
  double cut = 0.6;                          ///< s
  double noise = 2.0;                        ///< N
  geometry::Vector3 weight{0.0, 0.0, -6.0};  ///< of what hangs on the sensor, N
  geometry::Vector3 drift{1.5, -2.0, 0.8};   ///< N/s
};

/// A cut between two idle parts, with a tachometer whose wave has its zero at angle 0.
ForceRecord record_of(const Trial& trial, std::uint64_t seed) {
  Random random(seed);
  ForceRecord record;
  record.rate = kRate;
  const auto samples = static_cast<Eigen::Index>((2.0 * trial.idle + trial.cut) * kRate);
  record.force.resize(samples, 3);
  record.tacho.resize(samples);
  // The spindle starts anywhere.
  const double start = random.uniform(0.0, kTurn);
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double t = static_cast<double>(i) / kRate;
    const double angle = start + kSpeed * t;
    record.tacho[i] = std::sin(angle);
    const bool cutting = t >= trial.idle && t < trial.idle + trial.cut;
    const double place = std::fmod(angle, kTurn) / kTurn * 1440.0;
    const auto low = static_cast<Eigen::Index>(place) % 1440;
    const double share = place - std::floor(place);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      record.force(i, axis) =
          trial.weight[axis] + trial.drift[axis] * t + trial.noise * random.normal();
      if (!cutting) continue;
      record.force(i, axis) +=
          (1.0 - share) * turn()(low, axis) + share * turn()((low + 1) % 1440, axis);
    }
  }
  return record;
}

const SignalChain kChain{.segments = {.guard = 0.02},
                         .baseline = BaselineKind::drift,
                         .filter_order = 4,
                         .cutoff_hz = 1000.0,
                         .bins = 48};
constexpr CutOfRecord kCut{.spindle_speed = kSpeed, .flutes = 2};

TEST(RevolutionFit, GivesBackWhatARecordWasMadeOfWithNoiseRunOutGravityAndDrift) {
  int within = 0;
  int covered = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const ForceRecord record = record_of({}, static_cast<std::uint64_t>(trial));
    const InstantaneousFit fit =
        fit_processed(process(record, kCut, kChain), kChain, kCutter, kCondition, kImmersion);
    bool whole = true;
    for (Eigen::Index i = 0; i < 9; ++i) {
      const Estimate& one = fit.estimates[static_cast<std::size_t>(i)];
      whole = whole && std::abs(one.value - truth()[i]) <= 3.0 * one.standard_error;
      covered += one.low <= truth()[i] && truth()[i] <= one.high;
    }
    within += whole;
  }
  // All nine unknowns of a trial at once.
  EXPECT_GE(within, 190);
  // 93 to 97 % of 1800 intervals; their count has a binomial deviation of 9.
  EXPECT_GE(covered, 1674);
  EXPECT_LE(covered, 1746);
}

TEST(RevolutionFit, ReadsTheSameFromASensorWithoutFilter) {
  Trial clean;
  clean.noise = 1e-3;
  clean.drift.setZero();
  SignalChain chain = kChain;
  chain.filter_order = 0;
  chain.bins = 36;
  const InstantaneousFit fit = fit_processed(process(record_of(clean, 1), kCut, chain), chain,
                                             kCutter, kCondition, kImmersion);
  for (Eigen::Index i = 0; i < 6; ++i) {
    // The average over ten degrees is modelled by three nodes, which miss the kinks at entry.
    EXPECT_NEAR(fit.estimates[static_cast<std::size_t>(i)].value, truth()[i],
                2e-2 * std::abs(truth()[i]));
  }
  EXPECT_NEAR(fit.run_out.offset, kRunOut.offset, 2e-2 * kRunOut.offset);
}

TEST(RevolutionFit, RefusesARecordWithoutRotationAndOneWhoseFlutesWereAveraged) {
  const ForceRecord record = record_of({}, 0);
  SignalChain still = kChain;
  still.rotation = RotationSource::none;
  EXPECT_THROW(fit_processed(process(record, kCut, still), still, kCutter, kCondition, kImmersion),
               InvalidInput);
  SignalChain averaged = kChain;
  averaged.average_flutes = true;
  EXPECT_THROW(
      fit_processed(process(record, kCut, averaged), averaged, kCutter, kCondition, kImmersion),
      InvalidInput);
  EXPECT_THROW(gather_revolutions(record.force.topRows(100), rotation_of_speed(100, kRate, kSpeed)),
               InvalidInput);
}

}  // namespace
}  // namespace osteomill::identify
