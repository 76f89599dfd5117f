// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/envelope.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

constexpr double kPi = std::numbers::pi;

/// An offset and a wave of a hundred periods whose amplitude swells and falls once.
Eigen::VectorXd swelling(Eigen::VectorXd& amplitude) {
  const Eigen::Index n = 6000;
  Eigen::VectorXd out(n);
  amplitude.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(n);
    amplitude[i] = 2.0 + std::cos(2.0 * kPi * t);
    out[i] = 5.0 + amplitude[i] * std::sin(2.0 * kPi * 100.0 * t);
  }
  return out;
}

TEST(AnalyticEnvelope, IsTheAmplitudeOfASlowlyModulatedWaveAboutItsMean) {
  Eigen::VectorXd amplitude;
  const Envelope envelope = analytic_envelope(swelling(amplitude));
  // All lines of the wave lie at positive frequencies and the length needs no zeros: exact.
  EXPECT_LT((envelope.upper - (5.0 + amplitude.array()).matrix()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((envelope.lower - (5.0 - amplitude.array()).matrix()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(PeakEnvelope, HoldsTheSignalAndMeetsItsPeaks) {
  Eigen::VectorXd amplitude;
  const Eigen::VectorXd x = swelling(amplitude);
  const Envelope envelope = peak_envelope(x, 61);
  EXPECT_TRUE((envelope.upper.array() >= x.array()).all());
  EXPECT_TRUE((envelope.lower.array() <= x.array()).all());
  // Within a period the amplitude changes by less than 2 pi/100. At the ends half a window may miss
  // the peak.
  const Eigen::VectorXd rest = envelope.upper - (5.0 + amplitude.array()).matrix();
  EXPECT_LT(rest.segment(60, 5880).cwiseAbs().maxCoeff(), 0.07);
}

TEST(PeakEnvelope, IsTheLargestOfEachWindow) {
  Eigen::VectorXd x(7);
  x << 1, 5, 2, 0, 3, 4, -1;
  Eigen::VectorXd upper(7), lower(7);
  upper << 5, 5, 5, 3, 4, 4, 4;
  lower << 1, 1, 0, 0, 0, -1, -1;
  const Envelope envelope = peak_envelope(x, 3);
  EXPECT_EQ(envelope.upper, upper);
  EXPECT_EQ(envelope.lower, lower);
  EXPECT_EQ(peak_envelope(x, 1).upper, x);
}

TEST(MovingRms, IsTheLevelOfAWaveOverWholePeriods) {
  Eigen::MatrixX3d force = Eigen::MatrixX3d::Zero(1000, 3);
  for (Eigen::Index i = 0; i < 1000; ++i) {
    force(i, 0) = 3.0 * std::sin(2.0 * kPi * static_cast<double>(i) / 50.0);
    force(i, 1) = 3.0 * std::cos(2.0 * kPi * static_cast<double>(i) / 50.0);
    force(i, 2) = 4.0;
  }
  // |F| = 5 everywhere, so any window has that level.
  for (const Eigen::Index window : {1, 7, 50, 2000})
    EXPECT_LT((moving_rms(force, window).array() - 5.0).abs().maxCoeff(), 1e-12) << window;
}

TEST(CumulativeMean, EndsAtTheMean) {
  Eigen::VectorXd x(4), means(4);
  x << 4, 0, 5, 7;
  means << 4, 2, 3, 4;
  EXPECT_EQ(cumulative_mean(x), means);
}

TEST(Envelope, RefusesAWindowWithoutASample) {
  EXPECT_THROW(peak_envelope(Eigen::VectorXd::Ones(4), 0), InvalidInput);
  EXPECT_THROW(moving_rms(Eigen::MatrixX3d::Ones(4, 3), 0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::identify
