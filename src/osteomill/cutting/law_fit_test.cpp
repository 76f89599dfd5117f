// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/law_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

const double kThicknesses[] = {2.5, 5, 10, 25, 50, 75, 100, 150, 200};

std::vector<OrthogonalCut> cuts_of(const EdgeForce& law, double noise = 0.0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, noise);
  std::vector<OrthogonalCut> cuts;
  for (const double um : kThicknesses) {
    for (int repeat = 0; repeat < 3; ++repeat) {
      const double h = um * units::um;
      cuts.push_back({h, force_per_width(law, h) + normal(random)});
    }
  }
  return cuts;
}

TEST(FitPowerLaw, RecoversTheLawThatMadeTheCuts) {
  for (const PowerLaw& law : {PowerLaw{60e3, 0.6, 0.0}, PowerLaw{80e3, 0.9, 2e3}}) {
    const PowerFit fit = fit_power_law(cuts_of(law));
    EXPECT_EQ(fit.status, "fitted");
    // Brent's search ends near the root of the machine's precision in n.
    EXPECT_NEAR(fit.law.exponent, law.exponent, 1e-5);
    EXPECT_NEAR(fit.law.at_1_mm, law.at_1_mm, 1e-4 * law.at_1_mm);
    EXPECT_NEAR(fit.law.edge, law.edge, 1.0);
    EXPECT_DOUBLE_EQ(fit.law.range.high, 200e-6);
  }
}

TEST(FitPowerLaw, HoldsTheEdgeForceAtZeroWhereItWouldBeNegative) {
  std::vector<OrthogonalCut> cuts = cuts_of(PowerLaw{80e3, 0.9, 0.0});
  for (OrthogonalCut& cut : cuts) cut.force = std::max(10.0, cut.force - 300.0);
  const PowerFit fit = fit_power_law(cuts);
  EXPECT_TRUE(fit.edge_at_bound);
  EXPECT_EQ(fit.law.edge, 0.0);
  EXPECT_EQ(fit.standard_errors[2], 0.0);
}

TEST(FitPowerLaw, IsAConstantWhereTheForceFallsWithTheChip) {
  const PowerFit fit = fit_power_law(cuts_of(LogLaw{0.7, 0.0, -0.1}));
  EXPECT_TRUE(fit.constant);
  EXPECT_EQ(fit.law.at_1_mm, 0.0);
  EXPECT_GT(fit.law.edge, 0.0);
  EXPECT_GT(fit.standard_errors[2], 0.0);
  for (const double error : fit.standard_errors) EXPECT_TRUE(std::isfinite(error));
}

TEST(FitLogLaw, RecoversTheLawThatMadeTheCuts) {
  const LogLaw law{0.42083, 0.58122, -0.06584};
  const LogFit fit = fit_log_law(cuts_of(law));
  EXPECT_NEAR(fit.law.k1, law.k1, 1e-12);
  EXPECT_NEAR(fit.law.k2, law.k2, 1e-12);
  EXPECT_NEAR(fit.law.k3, law.k3, 1e-12);
}

TEST(Fits, StateStandardErrorsThatCoverTheTruth) {
  const PowerLaw power{60e3, 0.6, 1e3};
  const LogLaw log{0.42, 0.58, -0.066};
  int covered_n = 0, covered_k3 = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto seed = static_cast<unsigned>(trial + 1);
    const PowerFit p = fit_power_law(cuts_of(power, 300.0, seed));
    covered_n += std::abs(p.law.exponent - power.exponent) < 2.06 * p.standard_errors[1] ? 1 : 0;
    std::vector<OrthogonalCut> cuts = cuts_of(log);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, 0.03);
    for (OrthogonalCut& cut : cuts) cut.force *= std::pow(10.0, normal(random));
    const LogFit l = fit_log_law(cuts);
    covered_k3 += std::abs(l.law.k3 - log.k3) < 2.06 * l.standard_errors[2] ? 1 : 0;
  }
  // 95 % of 200 are 190; four standard deviations of that binomial are 12.
  EXPECT_NEAR(covered_n, 190, 12);
  EXPECT_NEAR(covered_k3, 190, 12);
}

TEST(Fits, PreferTheLogLawForARadialForceThatPeaks) {
  // [plaskos2006] 2.4: F_r peaks near 15 um; a power law cannot.
  const auto cuts = cuts_of(LogLaw{0.55, 0.42, -0.18}, 60.0);
  EXPECT_LT(fit_log_law(cuts).quality.aicc, fit_power_law(cuts).quality.aicc - 10.0);
}

TEST(Fits, OfAveragedCutsAreThoseOfTheMeans) {
  const std::vector<OrthogonalCut> cuts = {{10e-6, 3e3}, {5e-6, 2e3}, {10e-6, 5e3}, {5e-6, 2.4e3}};
  const auto means = averaged(cuts);
  ASSERT_EQ(means.size(), 2u);
  EXPECT_DOUBLE_EQ(means[0].h, 5e-6);
  EXPECT_DOUBLE_EQ(means[0].force, 2.2e3);
  EXPECT_DOUBLE_EQ(means[1].force, 4e3);
}

TEST(SpeedEffect, IsStudentsUnpairedTest) {
  // R: t.test(c(5.1, 5.3, 5.0, 5.4), c(4.2, 4.0, 4.5), var.equal = TRUE): t = 5.944420,
  // df = 5, p = 0.00192457.
  std::vector<OrthogonalCut> slow, fast;
  for (const double f : {4.2, 4.0, 4.5}) slow.push_back({2.54e-6, f * 1e3});
  for (const double f : {5.1, 5.3, 5.0, 5.4}) fast.push_back({2.54e-6, f * 1e3});
  slow.push_back({10e-6, 1e3});  // a single cut tells nothing
  fast.push_back({10e-6, 2e3});
  const auto effects = speed_effects(slow, fast);
  ASSERT_EQ(effects.size(), 1u);
  EXPECT_DOUBLE_EQ(effects[0].degrees_of_freedom, 5.0);
  EXPECT_NEAR(effects[0].t, 5.944420, 1e-6);
  EXPECT_NEAR(effects[0].p, 0.00192457, 1e-8);
  EXPECT_TRUE(speed_effects(slow, {}).empty());
}

TEST(Fits, RefuseTooFewOrImpossibleCuts) {
  const auto cuts = cuts_of(PowerLaw{60e3, 0.6, 0.0});
  EXPECT_THROW(fit_power_law({cuts[0], cuts[3], cuts[6]}), InvalidInput);
  EXPECT_THROW(fit_log_law({cuts[0], cuts[1], cuts[2], cuts[3]}), InvalidInput);
  auto negative = cuts;
  negative[2].force = -1.0;
  EXPECT_THROW(fit_log_law(negative), InvalidInput);
  negative[2] = {0.0, 1.0};
  EXPECT_THROW(fit_power_law(negative), InvalidInput);
}

}  // namespace
}  // namespace osteomill::cutting
