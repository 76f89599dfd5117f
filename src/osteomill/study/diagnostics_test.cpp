// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/diagnostics.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"

namespace osteomill::study {
namespace {

// W and p of R 4.2's shapiro.test; the first sample is that of Shapiro and Wilk 1965 themselves.
TEST(ShapiroWilk, MeetsR) {
  const std::vector<double> weights = {148, 154, 158, 160, 161, 162, 166, 170, 182, 195, 236};
  EXPECT_NEAR(shapiro_wilk(weights).statistic, 0.7888146948354, 1e-9);
  EXPECT_NEAR(shapiro_wilk(weights).p, 0.0067038140565, 1e-9);
  const std::vector<double> four = {1.2, 0.7, 3.1, 2.2}, three = {1, 2, 4};
  EXPECT_NEAR(shapiro_wilk(four).statistic, 0.9640418775902, 1e-9);
  EXPECT_NEAR(shapiro_wilk(four).p, 0.804312486354, 1e-8);
  EXPECT_NEAR(shapiro_wilk(three).statistic, 0.9642857142857, 1e-12);
  EXPECT_NEAR(shapiro_wilk(three).p, 0.636886845029, 1e-9);
}

TEST(ShapiroWilk, RejectsNormalSamplesAsOftenAsItSays) {
  int rejected = 0;
  for (int r = 0; r < 1000; ++r) {
    Random random(5, r);
    std::vector<double> y(30);
    for (double& value : y) value = random.normal();
    rejected += shapiro_wilk(y).p < 0.05;
  }
  // 50 of 1 000 with a standard deviation of 7.
  EXPECT_NEAR(rejected, 50, 21);
}

TEST(BrownForsythe, IsTheAnalysisOfVarianceOfDistancesFromMedians) {
  const std::vector<double> y = {1.0, 2.0, 4.0, 10.0, 13.0, 19.0, 25.0};
  const std::vector<int> group = {0, 0, 0, 1, 1, 1, 1};
  // Distances: 1 0 2 and 6 3 3 9; means 1 and 5.25.
  const double grand = 24.0 / 7.0;
  const double between = 3 * std::pow(1 - grand, 2) + 4 * std::pow(5.25 - grand, 2);
  const double within = 2.0 + (0.75 * 0.75 + 2.25 * 2.25 * 2 + 3.75 * 3.75);
  EXPECT_NEAR(brown_forsythe(y, group).statistic, between / (within / 5.0), 1e-12);
}

TEST(Bootstrap, IsTheSameForOneSeed) {
  const std::vector<double> y = {0.1, 0.5, -0.3, 1.2, 0.4, -0.9, 0.8, 0.2};
  const std::vector<int> cell(8, 0);
  const Interval a = bootstrap_sd_interval(y, cell, 3), b = bootstrap_sd_interval(y, cell, 3);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  // The bootstrap is what raises the upper end where one value stands far out.
  std::vector<double> far = y;
  far[3] = 12.0;
  EXPECT_NE(bootstrap_sd_interval(far, cell, 3).high, bootstrap_sd_interval(far, cell, 4).high);
}

TEST(BootstrapAnova, AgreesWithFWhenResidualsAreNormal) {
  Random random(8);
  RepeatedMeasures data;
  data.y.resize(40, 1);
  Factor group{"g", {"a", "b"}, {}};
  for (int i = 0; i < 40; ++i) {
    group.level.push_back(i % 2);
    data.y(i) = random.normal() + 0.6 * (i % 2);
  }
  data.between = {group};
  const Anova anova = analyse_variance(data);
  const auto p = bootstrap_anova_p(data, anova, SumOfSquares::kII, 1, 999);
  // Three standard errors of a share near p among 999 draws.
  EXPECT_NEAR(p[0], anova.rows[0].p, 3.0 * std::sqrt(anova.rows[0].p / 999.0) + 0.003);
}

TEST(Diagnostics, RefuseWhatCannotBeTested) {
  EXPECT_THROW(shapiro_wilk(std::vector{1.0, 2.0}), InvalidInput);
  EXPECT_THROW(shapiro_wilk(std::vector{1.0, 1.0, 1.0, 1.0}), InvalidInput);
  EXPECT_THROW(brown_forsythe(std::vector{1.0, 2.0}, std::vector{0, 0}), InvalidInput);
  EXPECT_THROW(bootstrap_sd_interval(std::vector{1.0, 2.0}, std::vector{0, 0}, 1), InvalidInput);
}

}  // namespace
}  // namespace osteomill::study
