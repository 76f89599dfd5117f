// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/combined_records.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/random.hpp"

namespace osteomill::identify {
namespace {

const std::vector<UnitForce> kUnits{{ForceComponent::tangential, UnitForce::Kind::shear, 0},
                                    {ForceComponent::tangential, UnitForce::Kind::edge, 0}};

InstantaneousFit fit_of(double a, double b, double error_a, double error_b) {
  InstantaneousFit fit;
  fit.degrees_of_freedom = 20.0;
  fit.units = kUnits;
  fit.covariance = Eigen::Vector3d(error_a * error_a, error_b * error_b, 1.0).asDiagonal();
  for (const auto& [name, value, error] :
       {std::tuple{"Ktc", a, error_a}, {"Kte", b, error_b}, {"phase", 0.0, 1.0}}) {
    Estimate one;
    one.name = name;
    one.value = value;
    one.standard_error = error;
    fit.estimates.push_back(one);
  }
  return fit;
}

TEST(CombinedRecords, AreTheMeanWeightedByInverseVariances) {
  const auto both = combine_records({fit_of(1e8, 10.0, 2e6, 1.0), fit_of(1.1e8, 16.0, 4e6, 1.0)},
                                    {"1", "2"}, kUnits);
  ASSERT_EQ(both.coefficients.size(), 2U);
  EXPECT_NEAR(both.coefficients[0].value, (1e8 * 4.0 + 1.1e8) / 5.0, 1.0);
  EXPECT_NEAR(both.coefficients[1].value, 13.0, 1e-9);
  // chi²: differences squared over the sums of the variances, 1e14/2e13 and 36/2; 2 degrees.
  EXPECT_NEAR(both.birge_ratio, std::sqrt((5.0 + 18.0) / 2.0), 1e-9);
  EXPECT_NEAR(both.coefficients[1].standard_error, std::sqrt(0.5) * both.birge_ratio, 1e-9);
}

TEST(CombinedRecords, LeaveOutACutThatDoesNotDetermineACoefficient) {
  InstantaneousFit open = fit_of(5e8, 3.0, 1.0, 1.0);
  open.estimates[0].determined = false;
  const auto one = combine_records({fit_of(1e8, 10.0, 2e6, 1.0), open}, {"good", "open"}, kUnits);
  EXPECT_EQ(one.records, 1);
  EXPECT_EQ(one.left_out, std::vector<std::string>{"open"});
  EXPECT_DOUBLE_EQ(one.coefficients[0].value, 1e8);
  EXPECT_TRUE(combine_records({open}, {"open"}, kUnits).coefficients.empty());
}

TEST(CombinedRecords, IntervalsHoldTheTruthAsOftenAsTheySay) {
  int inside = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    Random random(seed);
    std::vector<InstantaneousFit> fits;
    for (int i = 0; i < 5; ++i) {
      fits.push_back(fit_of(1e8 + 2e6 * random.normal(), 10.0 + random.normal(), 2e6, 1.0));
    }
    const auto all = combine_records(fits, {"1", "2", "3", "4", "5"}, kUnits);
    inside += all.coefficients[0].low <= 1e8 && 1e8 <= all.coefficients[0].high ? 1 : 0;
    ++count;
  }
  // Errors are widened when the scatter is large by chance and never narrowed: at least 95 %, less
  // three standard deviations of the count.
  EXPECT_GT(static_cast<double>(inside) / count, 0.935);
}

TEST(CombinedRecords, NameTheCutThatTheOthersDoNotExpect) {
  const auto all = combine_records({fit_of(1.00e8, 10.0, 1e6, 1.0), fit_of(1.01e8, 10.5, 1e6, 1.0),
                                    fit_of(0.99e8, 9.5, 1e6, 1.0), fit_of(1.10e8, 10.0, 1e6, 1.0)},
                                   {"1", "2", "3", "4"}, kUnits);
  ASSERT_EQ(all.leave_one.size(), 4U);
  // Ten errors off in one of two coefficients: 10 / sqrt(1 + 1/3) over the root of two.
  EXPECT_NEAR(all.leave_one[3].ratio, 10.0 / std::sqrt(4.0 / 3.0) / std::sqrt(2.0), 1e-6);
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(all.leave_one[i].ratio, all.leave_one[3].ratio);
    EXPECT_LT(all.leave_one[i].influence, all.leave_one[3].influence);
  }
  // What the law of a mean gives: the shift is a quarter of the distance to the others.
  const double shift = 0.25 * 10.0;
  EXPECT_NEAR(all.leave_one[3].influence,
              shift * shift * 4.0 / 2.0 / (all.birge_ratio * all.birge_ratio), 1e-6);
}

TEST(CombinedRecords, AGroupLeftOutIsTheCutThatStandsForIt) {
  // Two cuts of one bone are together as good as one of half the variances at their mean.
  const std::vector<InstantaneousFit> four{
      fit_of(1.00e8, 10.0, 1e6, 1.0), fit_of(1.02e8, 10.0, 1e6, 1.0),
      fit_of(1.06e8, 12.0, 1e6, 1.0), fit_of(1.04e8, 14.0, 1e6, 1.0)};
  const double half = std::sqrt(0.5);
  const std::vector<InstantaneousFit> two{fit_of(1.01e8, 10.0, half * 1e6, half),
                                          fit_of(1.05e8, 13.0, half * 1e6, half)};
  const auto grouped =
      combine_records(four, {"1", "2", "3", "4"}, kUnits, 0.95, {"left", "left", "right", "right"});
  const auto single = combine_records(two, {"left", "right"}, kUnits);
  ASSERT_EQ(grouped.leave_group.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(grouped.leave_group[i].name, single.leave_one[i].name);
    EXPECT_NEAR(grouped.leave_group[i].ratio, single.leave_one[i].ratio, 1e-9);
  }
  EXPECT_TRUE(combine_records(four, {"1", "2", "3", "4"}, kUnits, 0.95, {"a", "a", "a", "a"})
                  .leave_group.empty());
}

}  // namespace
}  // namespace osteomill::identify
