// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/study/forecast.hpp"
#include "osteomill/study/intervals.hpp"

namespace osteomill::study {
namespace {

// R 4.2: power.t.test(delta = 0.5, sd = 1, power = 0.9) asks for 85.03 a group;
// power.t.test(n = 20, delta = 0.5, sd = 1, type = "paired") has power 0.564482896678662. (R leaves
// out the far tail, 2.2e-5 here.)
TEST(Plan, MeetsRsPowerOfTTests) {
  PlanOptions groups{.question = PlanQuestion::kMeansGroups,
                     .difference = 0.5,
                     .within_operator_sd = 1.0,
                     .cuts_per_operator = 1};
  EXPECT_EQ(plan_study(groups).least.operators, 86);
  PlanOptions paired{.question = PlanQuestion::kMeansPaired,
                     .difference = 0.5,
                     .within_operator_sd = std::sqrt(0.5),
                     .cuts_per_operator = 1};
  EXPECT_NEAR(plan_point(paired, 20).power, 0.564482896678662, 3e-5);
}

TEST(Plan, PowerIsWhatASimulatedStudyReaches) {
  PlanOptions o{.question = PlanQuestion::kMeansPaired,
                .difference = 0.6,
                .within_operator_sd = 1.0,
                .operator_by_technique_sd = 0.3,
                .cuts_per_operator = 6};
  const int operators = 8;
  int found = 0, ratio_found = 0;
  PlanOptions ratio{.question = PlanQuestion::kSdRatio,
                    .within_operator_sd = 1.0,
                    .sd_ratio = 0.7,
                    .cuts_per_operator = 6};
  for (int r = 0; r < 1000; ++r) {
    Random random(9, r);
    std::vector<double> difference, old_cuts, new_cuts;
    std::vector<int> cell;
    for (int k = 0; k < operators; ++k) {
      double sum = 0.0;
      for (int c = 0; c < o.cuts_per_operator; ++c) {
        sum += random.normal() - random.normal();
        old_cuts.push_back(random.normal());
        new_cuts.push_back(0.7 * random.normal());
        cell.push_back(k);
      }
      difference.push_back(o.difference + random.normal(0.0, o.operator_by_technique_sd) +
                           sum / o.cuts_per_operator);
    }
    found += one_sample_t_test(moments(difference)).p < o.alpha;
    ratio_found +=
        variance_ratio_test(pooled_within(new_cuts, cell), pooled_within(old_cuts, cell)).p < 0.05;
  }
  // Three standard errors of a share among 1 000.
  EXPECT_NEAR(found / 1000.0, plan_point(o, operators).power, 0.047);
  EXPECT_NEAR(ratio_found / 1000.0, plan_point(ratio, operators).power, 0.047);
}

TEST(Plan, OfAShareOutsideReachesItsPower) {
  PlanOptions o{
      .question = PlanQuestion::kShareOutside, .within_operator_sd = 1.0, .cuts_per_operator = 10};
  const int operators = 4, n = operators * o.cuts_per_operator;
  const double k = tolerance_factor(n, n - 1, 1.0 - o.largest_share, 1.0 - o.alpha);
  int inside = 0;
  for (int r = 0; r < 1000; ++r) {
    Random random(10, r);
    std::vector<double> y(n);
    for (double& value : y) value = random.normal();
    const Moments m = moments(y);
    inside += std::abs(m.mean) + k * m.sd <= o.limit;
  }
  EXPECT_NEAR(inside / 1000.0, plan_point(o, operators).power, 0.047);
}

TEST(Plan, PrecisionIsThatOfTheInterval) {
  PlanOptions o{
      .question = PlanQuestion::kSdPrecision, .relative_half_width = 0.2, .cuts_per_operator = 9};
  const Plan plan = plan_study(o);
  const double df = plan.least.operators * 8.0;
  EXPECT_LE(sd_interval(1.0, df).high, 1.2);
  EXPECT_GT(sd_interval(1.0, df - 8.0).high, 1.2);
}

TEST(Plan, PowerGrowsWithOperatorsAndCuts) {
  PlanOptions o{.difference = 0.5, .within_operator_sd = 1.0};
  double last = 0.0;
  for (int n = 2; n < 12; ++n) {
    const double power = plan_point(o, n).power;
    EXPECT_GT(power, last);
    PlanOptions more = o;
    more.cuts_per_operator *= 2;
    EXPECT_GT(plan_point(more, n).power, power);
    last = power;
  }
}

TEST(Plan, SaysWhenNoStudyIsLargeEnough) {
  PlanOptions o{.difference = 1e-4, .within_operator_sd = 1.0, .most_operators = 50};
  const Plan plan = plan_study(o);
  EXPECT_FALSE(plan.feasible);
  EXPECT_NE(plan.reason.find("50 operators do not reach"), std::string::npos);
}

TEST(Plan, RefusesOptionsThatAskNothing) {
  const auto refused = [](PlanOptions o) { EXPECT_THROW(plan_study(o), InvalidInput); };
  refused({.difference = 0.0});
  refused({.difference = 1.0, .within_operator_sd = 0.0});
  refused({.difference = 1.0, .alpha = 0.0});
  refused({.difference = 1.0, .power = 1.0});
  refused({.difference = 1.0, .cuts_per_operator = 0});
  refused({.question = PlanQuestion::kSdRatio, .sd_ratio = 1.0});
  refused({.question = PlanQuestion::kSdPrecision, .cuts_per_operator = 1});
  refused({.question = PlanQuestion::kShareOutside, .largest_share = 0.0});
}

}  // namespace
}  // namespace osteomill::study
