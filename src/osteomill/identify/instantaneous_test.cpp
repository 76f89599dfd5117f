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

TEST(InstantaneousFit, FindsPowerAndLogLawsWithTheirExponents) {
  struct Case {
    std::vector<UnitForce> units;
    Eigen::VectorXd truth;  // factors and edges, then exponents; SI
  };
  const std::vector<Case> cases = {
      {power_law_units(false), Eigen::VectorXd{{20e3, 14e3, 5e3, 0.5, 0.4, 0.6}}},
      {power_law_units(true), Eigen::VectorXd{{40e3, 2e3, 25e3, 3e3, 9e3, 0.5e3, 0.8, 0.7, 0.9}}},
      // [plaskos2006] Table 2.6, along the fibres.
      {log_law_units(), Eigen::VectorXd{{0.42083, 0.62379, -0.19495, 0.58122, -0.06584, 0.43160,
                                         -0.20553, 0.61971, -0.07352}}}};
  for (const Case& one : cases) {
    const auto exponents = static_cast<Eigen::Index>(exponents_of(one.units));
    const auto count = static_cast<Eigen::Index>(one.units.size());
    Eigen::VectorXd factors = one.truth.head(count);
    if (one.units.front().kind == UnitForce::Kind::log) {
      for (double& factor : factors) factor = 1e3 * std::pow(10.0, factor);  // N/m
    }
    RevolutionForces forces{angles(48), {}, {}};
    forces.mean = (EdgeColumns(cutter(), kCondition, kHalf, one.units)
                       .at(forces.angle, kPhase, kRunOut, one.truth.tail(exponents)) *
                   factors)
                      .eval()
                      .reshaped(48, 3);
    InstantaneousOptions options;
    options.units = one.units;
    const InstantaneousFit fit = fit_instantaneous(forces, cutter(), kCondition, kHalf, options);
    for (Eigen::Index i = 0; i < one.truth.size(); ++i) {
      // What the iteration's stopping rule leaves in the flattest direction.
      EXPECT_NEAR(fit.estimates[static_cast<std::size_t>(i)].value, one.truth[i],
                  1e-3 * std::abs(one.truth[i]))
          << fit.estimates[static_cast<std::size_t>(i)].name;
    }
    EXPECT_NEAR(fit.run_out.offset, kRunOut.offset, 1e-8);
    // The law made of it gives the forces of the cutting room, whose own panels stop at no
    // lift-off.
    const cutting::CuttingLaw law = law_of(fit.units, one.truth);
    cutting::Cutter turned = cutter();
    const auto turn = cutting::revolution(turned, law, kCondition, kHalf, 48);
    const Eigen::VectorXd mine = EdgeColumns(turned, kCondition, kHalf, one.units)
                                     .at(turn.angle, 0.0, {}, one.truth.tail(exponents)) *
                                 factors;
    double largest = 0.0;
    for (const cutting::Load& load : turn.loads) largest = std::max(largest, load.force.norm());
    for (Eigen::Index k = 0; k < 48; ++k) {
      const Eigen::Vector3d here(mine[k], mine[48 + k], mine[96 + k]);
      // Both end their panels at entry, where the slope of h^n is infinite.
      EXPECT_LT((here - turn.loads[static_cast<std::size_t>(k)].force).norm(), 3e-3 * largest);
    }
  }
}

TEST(InstantaneousFit, HoldsAComponentAtZeroThatALawCannotHave) {
  Eigen::VectorXd truth = Eigen::VectorXd::Zero(6);
  truth << 60e6, 45e6, 12e6, 4e3, 6e3, 1e3;  // axial away from the tip: lateral is negative
  RevolutionForces forces{angles(48), {}, {}};
  forces.mean = (EdgeColumns(cutter(), kCondition, kHalf, linear_law_units())
                     .at(forces.angle, kPhase, kRunOut) *
                 truth)
                    .eval()
                    .reshaped(48, 3);
  InstantaneousOptions options;
  options.units = power_law_units(false);
  const InstantaneousFit fit = fit_instantaneous(forces, cutter(), kCondition, kHalf, options);
  EXPECT_EQ(fit.units.size(), 2U);
  EXPECT_THAT(fit.verdict, testing::Contains(HasSubstr("lateral force would be negative")));
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

TEST(InstantaneousFit, SaysWhatTheDataCannot) {
  // Straight flutes: two of them see one component of the run-out only.
  Cutter straight = cutter();
  straight.helix_angle = 0.0;
  RevolutionForces forces{angles(48), {}, {}};
  const EdgeColumns columns(straight, kCondition, kHalf, linear_law_units());
  forces.mean = Eigen::VectorXd(columns.at(forces.angle, kPhase, kRunOut) * six()).reshaped(48, 3);
  InstantaneousOptions options;
  options.phase = kPhase;
  const InstantaneousFit fit = fit_instantaneous(forces, straight, kCondition, kHalf, options);
  EXPECT_FALSE(fit.estimates[7].determined);
  EXPECT_TRUE(fit.estimates[0].determined);
  EXPECT_THAT(fit.verdict, testing::Contains(HasSubstr("do not determine run_out_y")));

  const InstantaneousFit one = fit_instantaneous(forces, cutter(1), kCondition, kHalf, options);
  EXPECT_THAT(one.verdict, testing::Contains(HasSubstr("one flute takes the same chip")));
}

TEST(InstantaneousFit, WidensItsErrorsWhereTheModelMissesMoreThanNoise) {
  const RevolutionForces right = noisy(forces_at(36, {}), 64, 0.05, 1);
  // Forces that no linear law makes: a tenth more in the middle of the turn.
  RevolutionForces wrong = right;
  for (Eigen::Index i = 0; i < 6; ++i) {
    wrong.mean.row(12 + i) *= 1.1;
    for (Eigen::Index axis = 0; axis < 3; ++axis) wrong.each.col(36 * axis + 12 + i) *= 1.1;
  }
  const InstantaneousFit fit = fit_instantaneous(wrong, cutter(), kCondition, kHalf);
  const InstantaneousFit good = fit_instantaneous(right, cutter(), kCondition, kHalf);
  EXPECT_GT(fit.estimates[0].standard_error, 3.0 * good.estimates[0].standard_error);
  EXPECT_THAT(fit.verdict, testing::Contains(HasSubstr("the model lacks something")));
  EXPECT_THAT(good.verdict, testing::Not(testing::Contains(HasSubstr("lacks"))));
}

TEST(InstantaneousFit, LearnsTheNoiseFromResidualsWhereOnlyTheMeanIsKnown) {
  int covered = 0;
  constexpr int kTrials = 40;
  const Eigen::VectorXd mean = forces_at(72, gains());
  InstantaneousOptions options;
  options.harmonic_gains = gains();
  for (int trial = 0; trial < kTrials; ++trial) {
    RevolutionForces forces = noisy(mean, 16, 0.1, static_cast<std::uint64_t>(trial));
    forces.each.resize(0, 0);
    const InstantaneousFit fit = fit_instantaneous(forces, cutter(), kCondition, kHalf, options);
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Estimate& one = fit.estimates[static_cast<std::size_t>(i)];
      covered += one.low <= six()[i] && six()[i] <= one.high;
    }
  }
  // 95 % of 240 less three binomial deviations; the correlation of the residuals is itself
  // estimated from 72 values.
  EXPECT_GE(covered, 228 - 12);
}

TEST(InstantaneousFit, RefusesWhatItCannotFit) {
  RevolutionForces forces = clean(48);
  forces.mean(3, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(fit_instantaneous(forces, cutter(), kCondition, kHalf), InvalidInput);
  EXPECT_THROW(fit_instantaneous(clean(3), cutter(), kCondition, kHalf), InvalidInput);
  forces = clean(48);
  forces.angle.pop_back();
  EXPECT_THROW(fit_instantaneous(forces, cutter(), kCondition, kHalf), InvalidInput);
  EXPECT_THROW(law_of(linear_law_units(), Eigen::VectorXd::Ones(4)), InvalidInput);
}

}  // namespace
}  // namespace osteomill::identify
