// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/plateau_mean.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

TEST(PlateauMean, OfALineWithAWaveIsTheLineAtItsMiddle) {
  // Periods of 37.3 samples: no batch begins on a sample.
  const double rate = 1000.0, period = 0.0373;
  Eigen::VectorXd x(3730);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double t = static_cast<double>(i) / rate;
    x[i] = 10.0 + 0.5 * t + 4.0 * std::sin(2.0 * std::numbers::pi * t / period + 0.3);
  }
  const PlateauMean mean = plateau_mean(x, rate, period);
  EXPECT_EQ(mean.batches, 100);
  const double middle = 0.5 * (static_cast<double>(x.size()) - 1.0) / rate;
  // A batch that ends within a sample takes that sample's share as constant: an error of at most
  // an eighth of the wave's change in a sample, 4·2π/37.3/8, over 37 samples, and it alternates.
  EXPECT_NEAR(mean.mean, 10.0 + 0.5 * middle, 1e-3);
  EXPECT_NEAR(mean.slope, 0.5, 1e-3);
  EXPECT_LT(mean.standard_error, 1e-3);
}

/// Standard errors against what repeated records show: noise that remembers, over a wave.
TEST(PlateauMean, StandardErrorsAllowForCorrelation) {
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  for (const double memory : {0.0, 0.6, 0.9}) {
    constexpr int kRecords = 300;
    double mean_squares = 0.0, mean_stated = 0.0, slope_squares = 0.0, slope_stated = 0.0;
    int within = 0;
    for (int record = 0; record < kRecords; ++record) {
      // One value a revolution, and a wave of twenty samples on top.
      Eigen::VectorXd x(20 * 400);
      double slow = normal(engine) / std::sqrt(1.0 - memory * memory);
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        if (i % 20 == 0) slow = memory * slow + normal(engine);
        x[i] = slow + 5.0 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / 20.0);
      }
      const PlateauMean mean = plateau_mean(x, 1000.0, 0.02);
      mean_squares += mean.mean * mean.mean;
      mean_stated += mean.standard_error * mean.standard_error;
      slope_squares += mean.slope * mean.slope;
      slope_stated += mean.slope_standard_error * mean.slope_standard_error;
      within += std::abs(mean.mean) < 1.96 * mean.standard_error;
      EXPECT_GT(mean.autocorrelation, memory - 0.2);
    }
    // The deviation of 300 records is known to 4 % (one sigma).
    EXPECT_NEAR(std::sqrt(mean_stated / mean_squares), 1.0, 0.15) << memory;
    EXPECT_NEAR(std::sqrt(slope_stated / slope_squares), 1.0, 0.15) << memory;
    EXPECT_GT(within, 0.88 * kRecords) << memory;
    EXPECT_LT(within, 0.985 * kRecords) << memory;
  }
}

TEST(PlateauMean, WithoutAPeriodTakesBatches) {
  Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(900, 0.0, 899.0);
  const PlateauMean mean = plateau_mean(x, 10.0, 0.0);
  EXPECT_EQ(mean.batches, 30);
  EXPECT_NEAR(mean.mean, 449.5, 1e-9);
  EXPECT_NEAR(mean.slope, 10.0, 1e-9);
  EXPECT_EQ(mean.standard_error, 0.0);
}

TEST(PlateauMean, NeedsThreeBatches) {
  EXPECT_THROW(plateau_mean(Eigen::VectorXd::Ones(100), 100.0, 0.4), InvalidInput);
  EXPECT_THROW(plateau_mean(Eigen::VectorXd::Ones(0), 100.0, 0.0), InvalidInput);
  EXPECT_THROW(plateau_mean(Eigen::VectorXd::Ones(100), 0.0, 0.1), InvalidInput);
  EXPECT_EQ(plateau_mean(Eigen::VectorXd::Ones(120), 100.0, 0.4).mean, 1.0);
}

}  // namespace
}  // namespace osteomill::identify
