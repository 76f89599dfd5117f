// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/dynamometer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// A dynamometer that rings at 1200 Hz.
std::complex<double> ringing(double f) {
  const double r = f / 1200.0;
  return 1.0 / std::complex<double>(1.0 - r * r, 2.0 * 0.05 * r);
}

DynamometerResponse measured(double highest) {
  DynamometerResponse out;
  for (double f = 5.0; f <= highest; f += 5.0) out.frequency_hz.push_back(f);
  out.response.resize(static_cast<Eigen::Index>(out.frequency_hz.size()), 3);
  for (std::size_t k = 0; k < out.frequency_hz.size(); ++k)
    out.response.row(static_cast<Eigen::Index>(k)).setConstant(ringing(out.frequency_hz[k]));
  return out;
}

TEST(Compensation, GivesBackTheAppliedForce) {
  const double rate = 16000.0;
  const Eigen::Index n = 16000;
  ForceRecord shown{.rate = rate, .force = Eigen::MatrixX3d::Zero(n, 3), .tacho = {}, .torque = {}};
  Eigen::MatrixX3d applied = shown.force;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate;
    for (int axis = 0; axis < 3; ++axis) {
      applied(i, axis) = shown.force(i, axis) = 10.0 + axis;
      for (const double f : {165.0, 330.0, 1155.0}) {
        applied(i, axis) += 3.0 * std::cos(kTurn * f * t + axis);
        shown.force(i, axis) +=
            3.0 * std::abs(ringing(f)) * std::cos(kTurn * f * t + axis + std::arg(ringing(f)));
      }
    }
  }
  const ForceRecord out = compensate(shown, measured(3000.0));
  const auto middle = [](const Eigen::MatrixX3d& x) { return x.middleRows(4000, 8000); };
  EXPECT_GT((middle(shown.force) - middle(applied)).cwiseAbs().maxCoeff(), 10.0);
  // Straight lines between the measured lines and what the ends leave: parts in a thousand of the
  // 28 N that are shown at 1155 Hz.
  EXPECT_LT((middle(out.force) - middle(applied)).cwiseAbs().maxCoeff(), 0.1);
}

TEST(Compensation, KeepsAConstantAndATrendAtTheEnds) {
  ForceRecord record{.rate = 4000.0, .force = Eigen::MatrixX3d(3000, 3), .tacho = {}, .torque = {}};
  for (Eigen::Index i = 0; i < 3000; ++i)
    record.force.row(i).setConstant(5.0 + 1e-3 * static_cast<double>(i));
  const ForceRecord out = compensate(record, measured(1500.0));
  // Taken out as a straight line: rounding.
  EXPECT_LT((out.force - record.force).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Compensation, DoesNotAmplifyBeyondTheNoiseFloor) {
  // Beyond the resonance |H| falls to 0.19 at 3 kHz; a floor of 0.5 bounds the gain by 2.
  const double rate = 16000.0, f = 2500.0;
  const Eigen::Index n = 8000;
  ForceRecord shown{.rate = rate, .force = Eigen::MatrixX3d::Zero(n, 3), .tacho = {}, .torque = {}};
  for (Eigen::Index i = 0; i < n; ++i)
    shown.force.row(i).setConstant(std::cos(kTurn * f * static_cast<double>(i) / rate));
  const double h = std::abs(ringing(f));
  ASSERT_LT(h, 0.5);
  const auto peak = [](const ForceRecord& record) {
    return record.force.middleRows(3000, 2000).cwiseAbs().maxCoeff();
  };
  EXPECT_NEAR(peak(compensate(shown, measured(3000.0), {.noise_floor = 0.5})), h / 0.25, 0.01);
  EXPECT_NEAR(peak(compensate(shown, measured(3000.0), {.noise_floor = 0.01})), 1.0 / h, 0.02);
  // Above the highest frequency nothing is left.
  EXPECT_LT(peak(compensate(shown, measured(3000.0), {.noise_floor = 0.01, .highest_hz = 2000.0})),
            1e-3);
}

TEST(Compensation, RefusesAResponseThatIsNone) {
  const ForceRecord record{
      .rate = 4000.0, .force = Eigen::MatrixX3d::Zero(3000, 3), .tacho = {}, .torque = {}};
  EXPECT_THROW(compensate(record, {}), InvalidInput);
  DynamometerResponse falling = measured(100.0);
  std::swap(falling.frequency_hz[3], falling.frequency_hz[4]);
  EXPECT_THROW(compensate(record, falling), InvalidInput);
  DynamometerResponse broken = measured(100.0);
  broken.response(2, 1) = std::nan("");
  EXPECT_THROW(compensate(record, broken), InvalidInput);
  EXPECT_THROW(compensate(record, measured(100.0), {.noise_floor = 0.0}), InvalidInput);
  EXPECT_THROW(compensate(record, measured(100.0), {.highest_hz = 500.0}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::identify
