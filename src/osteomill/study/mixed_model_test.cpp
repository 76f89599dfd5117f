// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/mixed_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"

namespace osteomill::study {
namespace {

MixedModelData balanced(int operators, int cuts, double operator_sd, std::uint64_t seed) {
  Random random(seed);
  MixedModelData data;
  data.y.resize(operators * cuts);
  data.x = Eigen::MatrixXd::Ones(operators * cuts, 1);
  Factor who{"operator", std::vector<std::string>(operators, "o"), {}};
  for (int o = 0; o < operators; ++o) {
    const double own = operator_sd * random.normal();
    for (int c = 0; c < cuts; ++c) {
      data.y(o * cuts + c) = 3.0 + own + random.normal();
      who.level.push_back(o);
    }
  }
  data.random.push_back(who);
  return data;
}

struct OneWay {
  double between = 0.0, within = 0.0;
};
OneWay one_way(const MixedModelData& data, int operators, int cuts) {
  const Eigen::MatrixXd y = data.y.reshaped(cuts, operators);
  const Eigen::RowVectorXd mean = y.colwise().mean();
  return {cuts * (mean.array() - mean.mean()).square().sum() / (operators - 1.0),
          (y.rowwise() - mean).squaredNorm() / (operators * (cuts - 1.0))};
}

TEST(MixedModel, OfABalancedOneWayStudyIsItsAnalysisOfVariance) {
  const int operators = 6, cuts = 5;
  const MixedModelData data = balanced(operators, cuts, 0.8, 7);
  const MixedModel fit = fit_mixed_model(data);
  const OneWay ms = one_way(data, operators, cuts);
  ASSERT_GT(ms.between, ms.within);
  ASSERT_TRUE(fit.converged);
  // The optimiser stops within half the digits of theta.
  EXPECT_NEAR(fit.components[1].sd, std::sqrt(ms.within), 1e-5);
  EXPECT_NEAR(fit.components[0].sd, std::sqrt((ms.between - ms.within) / cuts), 1e-5);
  EXPECT_NEAR(fit.beta(0), data.y.mean(), 1e-10);
  EXPECT_NEAR(fit.beta_covariance(0, 0), ms.between / (operators * cuts), 1e-5);
  const MixedModelTest test = test_fixed_effect(data, fit, Eigen::MatrixXd::Identity(1, 1));
  // Numerical second derivatives, to five digits.
  EXPECT_NEAR(test.df2, operators - 1.0, 1e-3);
  const double t = ms.between / ms.within;
  const double part_b = ms.between / cuts, part_w = (cuts - 1.0) / cuts * ms.within;
  EXPECT_NEAR(
      fit.total_degrees_of_freedom,
      (part_b + part_w) * (part_b + part_w) /
          (part_b * part_b / (operators - 1.0) + part_w * part_w / (operators * (cuts - 1.0))),
      1e-2 * t);
}

TEST(MixedModel, PutsAComponentAtZeroWhereOperatorsDifferLessThanCuts) {
  MixedModelData data = balanced(5, 4, 0.0, 1);
  for (int seed = 1; one_way(data, 5, 4).between >= one_way(data, 5, 4).within; ++seed) {
    data = balanced(5, 4, 0.0, seed);
  }
  const MixedModel fit = fit_mixed_model(data);
  EXPECT_TRUE(fit.components[0].at_zero);
  EXPECT_EQ(fit.components[0].sd, 0.0);
  EXPECT_EQ(fit.components[0].sd_interval.low, 0.0);
  EXPECT_GT(fit.components[0].sd_interval.high, 0.0);
  // Without operators it is one sample: SD on n - 1.
  const double n = static_cast<double>(data.y.size());
  EXPECT_NEAR(fit.components[1].sd,
              std::sqrt((data.y.array() - data.y.mean()).square().sum() / (n - 1.0)), 1e-9);
}

TEST(MixedModel, WithoutRandomFactorsIsLeastSquares) {
  MixedModelData data = balanced(5, 4, 0.5, 3);
  data.random.clear();
  const MixedModel fit = fit_mixed_model(data);
  EXPECT_EQ(fit.components.size(), 1u);
  const MixedModelTest test = test_fixed_effect(data, fit, Eigen::MatrixXd::Identity(1, 1));
  EXPECT_NEAR(test.df2, 19.0, 1e-3);
}

TEST(MixedModel, IsUnchangedByShiftAndScale) {
  const MixedModelData data = balanced(6, 5, 0.8, 11);
  MixedModelData moved = data;
  moved.y = (20.0 + 1e-3 * data.y.array()).matrix();
  const MixedModel a = fit_mixed_model(data), b = fit_mixed_model(moved);
  for (size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(b.components[k].sd, 1e-3 * a.components[k].sd, 1e-8);
    EXPECT_NEAR(b.components[k].sd_interval.high, 1e-3 * a.components[k].sd_interval.high, 2e-6);
  }
}

TEST(MixedModel, RefusesMoreColumnsThanRows) {
  MixedModelData data = balanced(2, 2, 1.0, 1);
  data.x = Eigen::MatrixXd::Identity(4, 4);
  EXPECT_THROW(fit_mixed_model(data), InvalidInput);
}

}  // namespace
}  // namespace osteomill::study
