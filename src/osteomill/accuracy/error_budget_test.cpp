// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/error_budget.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/accuracy/heat_relation.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::accuracy {
namespace {

TEST(ErrorBudget, TwoCutsHaveRootTwoTimesTheDeviationOfOne) {
  // [plaskos2002] §2.4, §3.4 and abstract: √2 × the upper 95 % limit of one cut, in degrees.
  const struct {
    double one, printed;
  } cuts[] = {{0.55, 0.8}, {0.97, 1.4}, {0.37, 0.6}, {0.81, 1.2}};
  for (const auto& cut : cuts) {
    const Budget two = propagate({{.name = "cut", .spread = cut.one, .times = 2}});
    EXPECT_NEAR(two.standard_deviation, std::sqrt(2.0) * cut.one, 1e-12);
    // Printed with one decimal and "~": within one unit of it.
    EXPECT_NEAR(two.standard_deviation, cut.printed, 0.1);
  }
}

TEST(ErrorBudget, LeavesTheMarginsOfTheRobotsSpecification) {
  // [plaskos2006] §4.2.1: within the 3° window in 95 % of the legs, one cut on each of two bones;
  // registration 0.3°, slotted saw 0.3° frontal and 0.7° sagittal.
  const double leg = allowed_deviation(1.5, 0.95);
  EXPECT_NEAR(leg, 0.765, 5e-4);
  const double bone = leg / std::sqrt(2.0);
  const ErrorSource registration{.name = "registration", .spread = 0.3};
  const double frontal = remaining_deviation({registration, {.name = "saw", .spread = 0.3}}, bone);
  const double sagittal = remaining_deviation({registration, {.name = "saw", .spread = 0.7}}, bone);
  // Printed "~0.4° SD" (ours 0.34) and "virtually no room".
  EXPECT_NEAR(frontal, 0.4, 0.1);
  EXPECT_LT(sagittal, 0.0);
}

TEST(ErrorBudget, SharesOfVarianceAddUpToOne) {
  // Registration below 0.5° and a saw near 1.5° for two cuts: cutting is 90 % of the variance, as
  // [plaskos2002] §1.1.4 quotes.
  const Budget budget = propagate(
      {{.name = "registration", .spread = 0.5}, {.name = "cutting", .spread = 1.06, .times = 2}});
  EXPECT_NEAR(budget.shares[0].share_of_variance + budget.shares[1].share_of_variance, 1.0, 1e-12);
  EXPECT_NEAR(budget.shares[1].share_of_variance, 0.9, 0.01);
}

TEST(ErrorBudget, MonteCarloAgreesWithThePropagation) {
  const std::vector<ErrorSource> sources = {
      {.name = "registration", .bias = 0.1, .spread = 0.3},
      {.name = "guide", .spread = 0.5, .shape = ErrorShape::uniform},
      {.name = "backlash", .spread = 0.4, .shape = ErrorShape::triangular},
      {.name = "cut", .bias = -0.05, .spread = 0.31, .times = 2}};
  const Budget budget = propagate(sources);
  const SampledBudget sampled = sample(sources, 1.5, 100000, 1);
  const double error = budget.standard_deviation / std::sqrt(1e5);
  EXPECT_NEAR(sampled.mean, budget.bias, 4.0 * error);
  EXPECT_NEAR(sampled.standard_deviation, budget.standard_deviation, 4.0 * error);
  EXPECT_LT(sampled.low, sampled.high);
  EXPECT_EQ(sample(sources, 1.5, 1000, 5).mean, sample(sources, 1.5, 1000, 5).mean);
}

TEST(ErrorBudget, ComplianceTurnsLoadIntoError) {
  // 22 N on the fixation of 125 N/mm: 0.18 mm.
  const ErrorSource source = source_from_compliance("fixation", 22.0, 4.4, 1.0 / 125.0);
  EXPECT_NEAR(source.bias, 0.176, 1e-12);
  EXPECT_NEAR(source.spread, 0.0352, 1e-12);
}

TEST(ErrorBudget, BadInputsAreNamed) {
  EXPECT_THROW(propagate({}), InvalidInput);
  EXPECT_THROW(propagate({{.name = "a", .spread = -1.0}}), InvalidInput);
  EXPECT_THROW(propagate({{.name = "a", .spread = 1.0, .times = 0}}), InvalidInput);
  EXPECT_THROW(sample({{.name = "a", .spread = 1.0}}, 1.0, 10, 1), InvalidInput);
  EXPECT_THROW(allowed_deviation(1.5, 1.0), InvalidInput);
}

TEST(HeatRelation, DependsOnTheFeedPerToothAlone) {
  const HeatRelation relation{.coefficient = 0.005, .start = 25.0};
  const double a = temperature(relation, 5e-3, 1000.0, 2, 1e-3);
  EXPECT_NEAR(temperature(relation, 5e-3, 2000.0, 2, 2e-3), a, 1e-12);
  EXPECT_NEAR(temperature(relation, 5e-3, 1000.0, 4, 2e-3), a, 1e-12);
  EXPECT_GT(temperature(relation, 5e-3, 2000.0, 2, 1e-3), a);
  EXPECT_GT(temperature(relation, 10e-3, 1000.0, 2, 1e-3), a);
}

TEST(HeatRelation, CalibrationFindsTheCoefficientThatMadeTheData) {
  const HeatRelation truth{.coefficient = 0.004, .start = 22.0};
  std::vector<HeatObservation> observations;
  for (const double feed : {1e-3, 2e-3, 4e-3}) {
    observations.push_back({5e-3, 1000.0, 2, feed, temperature(truth, 5e-3, 1000.0, 2, feed)});
  }
  const HeatCalibration exact = calibrate(observations, 22.0);
  EXPECT_NEAR(exact.relation.coefficient, 0.004, 1e-15);
  EXPECT_NEAR(exact.residual_rms, 0.0, 1e-12);
  observations[1].temperature += 2.0;
  EXPECT_GT(calibrate(observations, 22.0).coefficient_error, 0.0);
  EXPECT_THROW(calibrate({}, 22.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::accuracy
