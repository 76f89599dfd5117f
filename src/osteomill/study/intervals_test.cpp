// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/intervals.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/numerics/distributions.hpp"

namespace osteomill::study {
namespace {

using ::testing::ElementsAre;

struct Printed {
  const char* what;
  PrintedInterval printed;
  int cuts;  // the count that the thesis prints for the group; 0 where it prints none
  std::vector<int> at95, at90;  // first and last whole degrees of freedom, by R 4.2's qchisq
};

// [plaskos2002] 2.3 and 3.3. Its "95 %" intervals follow from more degrees of freedom than it has
// cuts (or from none at all); with 5 % on each side, 90 % intervals, they follow from about n - 1.
// Details in docs/theory/study.md.
TEST(SdInterval, OfTheThesisAsksForMoreDegreesOfFreedomThanItHasCuts) {
  const double h = 0.005, coarse = 0.05;
  const std::vector<Printed> table = {
      {"experts V/V", {0.4, coarse, {0.33, 0.55}, h}, 25, {28, 33}, {20, 23}},
      {"trainees V/V", {0.8, coarse, {0.68, 0.97}, h}, 38, {58, 66}, {41, 46}},
      {"both F/E", {1.3, coarse, {1.13, 1.53}, h}, 63, {81, 89}, {57, 62}},
      {"milling V/V", {0.31, h, {0.27, 0.37}, h}, 50, {65, 96}, {46, 68}},
      {"milling F/E", {0.68, h, {0.58, 0.81}, h}, 50, {65, 76}, {47, 53}},
      {"sawing V/V", {0.99, h, {0.83, 1.25}, h}, 35, {45, 47}, {32, 34}},
      {"sawing F/E", {1.22, h, {1.02, 1.53}, h}, 35, {46, 49}, {33, 35}},
      {"trainees open F/E", {1.52, h, {1.24, 1.98}, h}, 27, {36, 36}, {25, 26}},
      {"trainees slotted F/E", {1.58, h, {1.27, 2.13}, h}, 21, {}, {21, 21}},
      {"experts open F/E", {1.60, h, {1.28, 2.15}, h}, 22, {29, 30}, {21, 21}},
      {"experts slotted F/E", {0.64, h, {0.49, 0.93}, h}, 15, {19, 20}, {14, 14}},
      {"experts open, secondary", {0.8, coarse, {0.57, 1.76}, h}, 0, {}, {5, 5}},
  };
  const auto ends = [](const std::vector<int>& all) {
    return all.empty() ? std::vector<int>{} : std::vector<int>{all.front(), all.back()};
  };
  for (const Printed& row : table) {
    const std::vector<int> at95 = degrees_of_freedom_implied(row.printed, 0.95);
    EXPECT_THAT(ends(at95), row.at95) << row.what;
    EXPECT_THAT(ends(degrees_of_freedom_implied(row.printed, 0.90)), row.at90) << row.what;
    if (!at95.empty()) {
      EXPECT_GT(at95.front(), row.cuts - 1) << row.what;
    }
  }
}

TEST(SdInterval, HoldsTheSdAndShrinksWithDegreesOfFreedom) {
  double last = 1e9;
  for (const double df : {1.0, 2.5, 10.0, 100.0, 1000.0}) {
    const Interval interval = sd_interval(2.0, df);
    EXPECT_LT(interval.low, 2.0);
    EXPECT_GT(interval.high, 2.0);
    EXPECT_LT(interval.high - interval.low, last);
    last = interval.high - interval.low;
  }
}

TEST(RSquaredInterval, TakesTheRootOfTheVarianceThatTheThesisPrints) {
  // 60 primary cuts with guide movement, r2 = 18.3 %. The thesis prints 16.0 to 21.2 %, which is
  // what z +- 1.96/(n-3) gives to a per cent; the variance 1/(n-3) that it states gives 4 to 38 %.
  const double r = std::sqrt(0.183);
  const Interval right = r_squared_interval(r, 60);
  EXPECT_NEAR(right.low, 0.0380, 5e-5);
  EXPECT_NEAR(right.high, 0.3781, 5e-5);
  const double z = std::atanh(r), half = 1.96 / 57.0;
  EXPECT_NEAR(std::pow(std::tanh(z - half), 2.0), 0.160, 0.002);
  EXPECT_NEAR(std::pow(std::tanh(z + half), 2.0), 0.212, 0.006);
  EXPECT_EQ(r_squared_interval(0.05, 20).low, 0.0);
}

// R 4.2: t.test and var.test of MASS::anorexia Postwt, CBT against Cont.
TEST(TwoSamples, MeetRsTests) {
  const Moments cbt{29, 85.6965517241379, 8.351923762934616, 28.0};
  const Moments cont{26, 81.1076923076923, 4.744253203775960, 25.0};
  // R prints 13 digits of t and p.
  const TwoSampleTest welch = welch_t_test(cbt, cont), pooled = pooled_t_test(cbt, cont);
  EXPECT_NEAR(welch.statistic, 2.537248582162, 1e-10);
  EXPECT_NEAR(welch.df1, 45.22108040556, 1e-9);
  EXPECT_NEAR(welch.p, 0.0146899036377, 1e-12);
  EXPECT_NEAR(welch.interval.low, 0.946650138823685, 1e-10);
  EXPECT_NEAR(welch.interval.high, 8.231068694067574, 1e-10);
  EXPECT_NEAR(pooled.statistic, 2.466076431817, 1e-10);
  EXPECT_NEAR(pooled.p, 0.016929759369, 1e-12);
  const TwoSampleTest ratio = variance_ratio_test(cbt, cont);
  EXPECT_NEAR(ratio.statistic, 3.099112371445, 1e-10);
  EXPECT_NEAR(ratio.p, 0.0055429532953, 1e-12);
  EXPECT_NEAR(ratio.interval.low, 1.40920184392014, 1e-10);
  EXPECT_NEAR(ratio.interval.high, 6.69858162376192, 1e-10);
}

TEST(TwoSamples, TellTheSameWhenTheyAreExchanged) {
  const Moments a{12, 0.4, 0.7, 10.0}, b{9, -0.1, 1.1, 8.0};
  EXPECT_DOUBLE_EQ(welch_t_test(a, b).p, welch_t_test(b, a).p);
  EXPECT_NEAR(variance_ratio_test(a, b).p, variance_ratio_test(b, a).p, 1e-12);
  EXPECT_NEAR(variance_ratio_test(a, b).statistic * variance_ratio_test(b, a).statistic, 1.0,
              1e-12);
}

TEST(PooledWithin, TakesOutEachCellsMean) {
  const std::vector<double> y = {1.0, 3.0, 10.0, 14.0, 12.0, 7.0};
  const std::vector<int> cell = {0, 0, 1, 1, 1, 2};
  const Moments m = pooled_within(y, cell);
  EXPECT_EQ(m.degrees_of_freedom, 3.0);  // 1 + 2 + 0
  EXPECT_DOUBLE_EQ(m.sd, std::sqrt((2.0 + 8.0) / 3.0));
  EXPECT_EQ(pooled_within(y, std::vector<int>{0, 1, 2, 3, 4, 5}).degrees_of_freedom, 0.0);
}

// Two-sided tolerance factors, 95 % content with 95 % confidence: exact values of Odeh and Owen
// 1980 table 3, to its three decimals.
TEST(ToleranceFactor, MeetsTheTables) {
  EXPECT_NEAR(tolerance_factor(5, 4, 0.95, 0.95), 5.077, 5e-4);
  EXPECT_NEAR(tolerance_factor(10, 9, 0.95, 0.95), 3.393, 5e-4);
  EXPECT_NEAR(tolerance_factor(20, 19, 0.95, 0.95), 2.760, 5e-4);
  EXPECT_NEAR(tolerance_factor(100, 99, 0.95, 0.95), 2.234, 5e-4);
  // With all known it is the normal quantile: the factor nears it as 1/sqrt(2 df).
  EXPECT_NEAR(tolerance_factor(1e9, 1e9, 0.95, 0.5), 1.959964, 1e-5);
}

TEST(Holm, StepsDownAndKeepsTheOrder) {
  EXPECT_THAT(holm(std::vector{0.01, 0.04, 0.03}), ElementsAre(0.03, 0.06, 0.06));
  EXPECT_THAT(holm(std::vector{0.9, 0.8}), ElementsAre(1.0, 1.0));
}

TEST(Intervals, RefuseWhatCannotBe) {
  EXPECT_THROW(moments(std::vector{1.0}), InvalidInput);
  EXPECT_THROW(sd_interval(1.0, 0.0), InvalidInput);
  EXPECT_THROW(sd_interval(-1.0, 5.0), InvalidInput);
  EXPECT_THROW(sd_interval(1.0, 5.0, 1.0), InvalidInput);
  EXPECT_THROW(r_squared_interval(0.5, 3), InvalidInput);
  EXPECT_THROW(variance_ratio_test({3, 0, 0, 2}, {3, 0, 1, 2}), InvalidInput);
  EXPECT_THROW(welch_t_test({3, 0, 0, 2}, {3, 1, 0, 2}), InvalidInput);
  EXPECT_THROW(tolerance_factor(0, 4, 0.9, 0.9), InvalidInput);
}

}  // namespace
}  // namespace osteomill::study
