// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/instantaneous.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::identify {
namespace {

using cutting::Condition;
using cutting::Cutter;
using cutting::Immersion;
using cutting::ImmersionKind;
using cutting::RunOut;
using testing::HasSubstr;

constexpr double kTurn = 2.0 * std::numbers::pi;

Cutter cutter(int flutes = 2) {
  return {.radius = 3.175e-3, .flutes = flutes, .helix_angle = 0.52, .cutting_length = 10e-3};
}
const Condition kCondition{.spindle_speed = 523.6, .feed_per_tooth = 20e-6};
const Immersion kHalf{ImmersionKind::down, 3.175e-3, 4e-3};
const RunOut kRunOut{7e-6, 2.1, 0.0, 0.0};
constexpr double kPhase = 0.9;

Eigen::VectorXd six() {
  return (Eigen::VectorXd(6) << 60e6, 45e6, 12e6, 4e3, 6e3, -1e3).finished();
}

std::vector<double> angles(int count) {
  std::vector<double> result;
  for (int i = 0; i < count; ++i) result.push_back(kTurn * i / count);
  return result;
}

/// Forces of the truth at `count` angles, stacked; with gains, after these harmonics are all that
/// is left: worked out on 1440 steps as a Fourier sum.
Eigen::VectorXd forces_at(int count, const std::vector<double>& gains) {
  constexpr int kFine = 1440;
  const int steps = gains.empty() ? count : kFine;
  const Eigen::VectorXd fine = EdgeColumns(cutter(), kCondition, kHalf, linear_law_units())
                                   .at(angles(steps), kPhase, kRunOut) *
                               six();
  if (gains.empty()) return fine;
  Eigen::VectorXd result = Eigen::VectorXd::Zero(3 * count);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t h = 0; h < gains.size(); ++h) {
      const auto order = static_cast<double>(h);
      double cosine = 0.0, sine = 0.0;
      for (int i = 0; i < kFine; ++i) {
        cosine += fine[axis * kFine + i] * std::cos(order * kTurn * i / kFine);
        sine += fine[axis * kFine + i] * std::sin(order * kTurn * i / kFine);
      }
      const double scale = gains[h] * (h == 0 ? 1.0 : 2.0) / kFine;
      for (int k = 0; k < count; ++k) {
        result[axis * count + k] += scale * (cosine * std::cos(order * kTurn * k / count) +
                                             sine * std::sin(order * kTurn * k / count));
      }
    }
  }
  return result;
}

/// What a fourth-order zero-phase Butterworth filter at the eighth harmonic leaves.
std::vector<double> gains() {
  std::vector<double> result;
  for (int h = 0; h <= 20; ++h) result.push_back(1.0 / (1.0 + std::pow(h / 8.0, 8)));
  return result;
}

/// Averaged forces without noise.
RevolutionForces clean(int count, const std::vector<double>& left = {}) {
  RevolutionForces forces{angles(count), {}, {}};
  forces.mean = forces_at(count, left).reshaped(count, 3);
  return forces;
}

TEST(InstantaneousFit, FindsCoefficientsRunOutAndPhaseOfCleanForces) {
  const InstantaneousFit fit = fit_instantaneous(clean(48), cutter(), kCondition, kHalf);
  EXPECT_EQ(fit.status, FitStatus::converged);
  const Eigen::VectorXd truth = six();
  // What the iteration's stopping rule leaves.
  for (Eigen::Index i = 0; i < 6; ++i) {
    EXPECT_NEAR(fit.estimates[static_cast<std::size_t>(i)].value, truth[i],
                1e-5 * std::abs(truth[i]))
        << fit.estimates[static_cast<std::size_t>(i)].name;
  }
  EXPECT_NEAR(fit.run_out.offset, kRunOut.offset, 1e-10);
  EXPECT_NEAR(fit.run_out.offset_angle, kRunOut.offset_angle, 1e-5);
  EXPECT_NEAR(fit.phase, kPhase, 1e-5);
  EXPECT_LT(fit.residual_rms.norm(), 1e-5);
}

/// `count` revolutions with noise that goes together at neighbouring angles.
RevolutionForces noisy(const Eigen::VectorXd& truth, int count, double noise, std::uint64_t seed) {
  const auto steps = static_cast<int>(truth.size() / 3);
  Random random(seed);
  RevolutionForces forces{angles(steps), {}, {}};
  forces.each.resize(count, truth.size());
  for (Eigen::Index i = 0; i < forces.each.rows(); ++i) {
    double before = random.normal();
    for (Eigen::Index k = 0; k < truth.size(); ++k) {
      const double now = random.normal();
      forces.each(i, k) = truth[k] + noise * (now + before);
      before = now;
    }
  }
  forces.mean = forces.each.colwise().mean().transpose().reshaped(steps, 3);
  return forces;
}

TEST(InstantaneousFit, StatesIntervalsThatCoverUnderCorrelatedNoise) {
  int within = 0;
  int covered = 0;
  Eigen::VectorXd truth(9);
  truth << six(), kRunOut.offset * std::cos(kRunOut.offset_angle),
      kRunOut.offset * std::sin(kRunOut.offset_angle), kPhase;
  const Eigen::VectorXd mean = forces_at(36, gains());
  InstantaneousOptions options;
  options.harmonic_gains = gains();
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const RevolutionForces forces = noisy(mean, 64, 0.4, static_cast<std::uint64_t>(trial));
    const InstantaneousFit fit = fit_instantaneous(forces, cutter(), kCondition, kHalf, options);
    bool whole = true;
    for (Eigen::Index i = 0; i < truth.size(); ++i) {
      const Estimate& one = fit.estimates[static_cast<std::size_t>(i)];
      whole = whole && std::abs(one.value - truth[i]) <= 3.0 * one.standard_error;
      covered += one.low <= truth[i] && truth[i] <= one.high;
    }
    within += whole;
  }
  // All nine unknowns of a trial at once.
  EXPECT_GE(within, 190);
  // 1800 intervals; their count has a binomial deviation of 9.
  EXPECT_GE(covered, 1674);
  EXPECT_LE(covered, 1746);
}

}  // namespace
}  // namespace osteomill::identify
