// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/frequency_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"

namespace osteomill::vibration {
namespace {

constexpr double kPi = std::numbers::pi;

struct TrueMode {
  double frequency_hz, damping_ratio, stiffness;
};

/// The answer of the modes to a half-sine blow, by the exact response to a force that is linear
/// over fine steps, then sampled, with noise on both channels.
ImpactRecord blow(const std::vector<TrueMode>& modes, Random& random, double noise,
                  Response response = Response::displacement) {
  constexpr double rate = 25600.0, width = 0.6e-3;
  constexpr int count = 8192, fine = 16;
  ImpactRecord record{.sample_rate = rate,
                      .force = std::vector<double>(count),
                      .response = std::vector<double>(count)};
  const double dt = 1.0 / rate / fine;
  const double start = 20.0 / rate, peak = random.uniform(40.0, 60.0);
  const auto force = [&](double t) {
    const double s = (t - start) / width;
    return s > 0.0 && s < 1.0 ? peak * std::pow(std::sin(kPi * s), 2) : 0.0;
  };
  for (const TrueMode& mode : modes) {
    const double omega = 2.0 * kPi * mode.frequency_hz, mass = mode.stiffness / (omega * omega);
    double q = 0.0, v = 0.0;
    for (int i = 0; i < count * fine; ++i) {
      const auto acceleration = [&](double t, double at, double speed) {
        return force(t) / mass - 2.0 * mode.damping_ratio * omega * speed - omega * omega * at;
      };
      const double t = i * dt;
      if (i % fine == 0) {
        record.response[static_cast<std::size_t>(i / fine)] +=
            response == Response::displacement ? q : acceleration(t, q, v);
      }
      // Runge and Kutta, fourth order: (ω dt)⁵ ~ 1e-8 a step.
      const double k1 = acceleration(t, q, v);
      const double k2 = acceleration(t + dt / 2, q + dt / 2 * v, v + dt / 2 * k1);
      const double k3 =
          acceleration(t + dt / 2, q + dt / 2 * v + dt * dt / 4 * k1, v + dt / 2 * k2);
      const double k4 = acceleration(t + dt, q + dt * v + dt * dt / 2 * k2, v + dt * k3);
      q += dt * v + dt * dt / 6 * (k1 + k2 + k3);
      v += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
  }
  double largest = 0.0;
  for (const double x : record.response) largest = std::max(largest, std::abs(x));
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    record.force[k] = force(i / rate) + noise * peak * 0.1 * random.normal();
    record.response[k] += noise * largest * random.normal();
  }
  return record;
}

const std::vector<TrueMode> kTool = {{1034.0, 0.02, 29e3}};

TEST(ImpactTest, NoiselessBlowGivesTheModeBack) {
  Random random(1);
  const MeasuredFrf frf = estimate_frf({blow(kTool, random, 0.0)});
  const ModalFit fit = fit_modes(frf, {.low_hz = 500.0, .high_hz = 1600.0});
  ASSERT_TRUE(fit.converged) << fit.status;
  // What sampling folds back: 1e-4 of the blow.
  EXPECT_NEAR(fit.modes[0].frequency_hz.value, 1034.0, 0.05);
  EXPECT_NEAR(fit.modes[0].damping_ratio.value, 0.02, 1e-5);
  EXPECT_NEAR(fit.modes[0].stiffness.value, 29e3, 30.0);
}

TEST(ImpactTest, NoisyBlowsGiveTheModeWithinTheStatedIntervals) {
  // Twenty tests of five blows each with 2 % noise: three standard errors hold nearly always.
  int outside = 0;
  for (std::uint64_t test = 0; test < 20; ++test) {
    Random random(2002, test);
    std::vector<ImpactRecord> records;
    for (int i = 0; i < 5; ++i) records.push_back(blow(kTool, random, 0.02));
    const MeasuredFrf frf = estimate_frf(records, {.force_window = 1e-3});
    const ModalFit fit = fit_modes(frf, {.low_hz = 700.0, .high_hz = 1400.0});
    ASSERT_TRUE(fit.converged);
    const auto miss = [&](const Estimate& e, double truth) {
      EXPECT_GT(e.standard_error, 0.0);
      outside += std::abs(e.value - truth) > 3.0 * e.standard_error;
    };
    miss(fit.modes[0].frequency_hz, 1034.0);
    miss(fit.modes[0].damping_ratio, 0.02);
    miss(fit.modes[0].stiffness, 29e3);
    EXPECT_NEAR(fit.modes[0].frequency_hz.value, 1034.0, 2.0);
    EXPECT_NEAR(fit.modes[0].damping_ratio.value, 0.02, 1e-3);
  }
  // Of 60 values 0.3 % are expected outside three errors; two leave room for chance.
  EXPECT_LE(outside, 2);
}

TEST(ImpactTest, TwoModesAreToldApart) {
  Random random(3);
  const std::vector<TrueMode> two = {{900.0, 0.015, 30e3}, {1500.0, 0.02, 80e3}};
  const ModalFit fit = fit_modes(estimate_frf({blow(two, random, 1e-4)}),
                                 {.low_hz = 400.0, .high_hz = 2200.0, .modes = 2});
  ASSERT_TRUE(fit.converged);
  for (std::size_t m = 0; m < 2; ++m) {
    EXPECT_NEAR(fit.modes[m].frequency_hz.value, two[m].frequency_hz, 1.0);
    EXPECT_NEAR(fit.modes[m].damping_ratio.value, two[m].damping_ratio, 2e-4);
    EXPECT_NEAR(fit.modes[m].stiffness.value, two[m].stiffness, 0.02 * two[m].stiffness);
  }
}

TEST(ImpactTest, AccelerationGivesTheSameReceptance) {
  Random random(4);
  const MeasuredFrf frf = estimate_frf({blow(kTool, random, 0.0, Response::acceleration)},
                                       {.response = Response::acceleration});
  const ModalFit fit = fit_modes(frf, {.low_hz = 500.0, .high_hz = 1600.0});
  EXPECT_NEAR(fit.modes[0].frequency_hz.value, 1034.0, 0.5);
  EXPECT_NEAR(fit.modes[0].stiffness.value, 29e3, 300.0);
}

TEST(ImpactTest, ExponentialWindowAddsNoDampingToTheResult) {
  Random random(5);
  const std::vector<TrueMode> slow = {{300.0, 0.001, 29e3}};  // not decayed in 0.32 s
  const auto fitted = [&](double end) {
    const MeasuredFrf frf = estimate_frf({blow(slow, random, 0.0)}, {.window_end = end});
    return fit_modes(frf, {.low_hz = 200.0, .high_hz = 400.0}).modes[0];
  };
  const FittedMode windowed = fitted(0.001);
  EXPECT_NEAR(windowed.damping_ratio.value, 0.001, 2e-5);
  EXPECT_NEAR(windowed.stiffness.value, 29e3, 0.01 * 29e3);
  // Cut off at half its height the decay leaks: the peak is too low.
  EXPECT_GT(std::abs(fitted(1.0).stiffness.value - 29e3), 0.05 * 29e3);
}

TEST(ImpactTest, MeasuredReceptanceIsItsLinesInTheBandAndTheFitBeyond) {
  Random random(9);
  const MeasuredFrf frf = estimate_frf({blow(kTool, random, 1e-3)});
  const ModalFitOptions band{.low_hz = 800.0, .high_hz = 1300.0};
  const ModalFit fit = fit_modes(frf, band);
  const auto h = receptance_of(frf, fit, band);
  for (std::size_t i = 0; i < frf.frequency_hz.size(); ++i) {
    if (frf.frequency_hz[i] < 800.0 || frf.frequency_hz[i] > 1300.0) continue;
    EXPECT_LT(std::abs(h(frf.frequency_hz[i]) - frf.receptance[i]), 1e-12 * std::abs(h(1034.0)));
  }
  const double omega = 2.0 * kPi * 1034.0;
  const std::vector<Mode> truth = {{1034.0, 0.02, 29e3 / (omega * omega), 1.0, 0.0}};
  for (const double f : {0.0, 300.0, 2500.0, 8000.0}) {
    // The residual flexibility takes up what the noise of 0.1 % leaves.
    EXPECT_LT(std::abs(h(f) - tip_receptance(truth, f).xx), 0.01 / 29e3) << f;
  }
}

TEST(ImpactTest, MeasuredReceptanceKeepsThePeakBetweenCoarseLines) {
  const double omega = 2.0 * kPi * 922.0;
  const std::vector<Mode> truth = {{922.0, 0.011, 1340e3 / (omega * omega), 1.0, 0.0}};
  MeasuredFrf frf;
  frf.blows = 1;
  for (double f = 701.0; f < 1150.0; f += 6.0) {
    frf.frequency_hz.push_back(f);
    // A ripple of two per mille: no fit in the form of a mode and a constant.
    frf.receptance.push_back(tip_receptance(truth, f).xx * (1.0 + 0.002 * std::sin(f / 40.0)));
  }
  frf.coherence.assign(frf.frequency_hz.size(), 1.0);
  const auto h = receptance_of(frf, fit_modes(frf));
  for (double f = 702.0; f < 1140.0; f += 1.0) {
    const auto exact = tip_receptance(truth, f).xx * (1.0 + 0.002 * std::sin(f / 40.0));
    // Straight lines over 6 Hz of a peak 20 Hz wide would miss it by 9 %.
    EXPECT_LT(std::abs(h(f) - exact), 2e-4 * std::abs(exact)) << f;
  }
}

TEST(ImpactTest, MeasuredReceptanceIsFreeOfTheWindowsDamping) {
  Random random(10);
  const std::vector<TrueMode> slow = {{300.0, 0.001, 29e3}};
  const MeasuredFrf frf = estimate_frf({blow(slow, random, 0.0)}, {.window_end = 0.001});
  const ModalFitOptions band{.low_hz = 200.0, .high_hz = 400.0};
  const auto h = receptance_of(frf, fit_modes(frf, band), band);
  const double omega = 2.0 * kPi * 300.0;
  const std::vector<Mode> truth = {{300.0, 0.001, 29e3 / (omega * omega), 1.0, 0.0}};
  // At the lines, spaced by 3.1 Hz; the damping of 0.001 fits to 2 %, the window's own is 0.011.
  for (std::size_t i = 0; i < frf.frequency_hz.size(); ++i) {
    const double f = frf.frequency_hz[i];
    if (f < 250.0 || f > 350.0) continue;
    const double size = std::abs(tip_receptance(truth, f).xx);
    EXPECT_LT(std::abs(h(f) - tip_receptance(truth, f).xx), 0.03 * size) << f;
  }
}

TEST(ImpactTest, CoherenceFallsWithNoiseAndH2LiesAboveH1) {
  Random random(6);
  std::vector<ImpactRecord> records;
  for (int i = 0; i < 8; ++i) records.push_back(blow(kTool, random, 0.05));
  const MeasuredFrf h1 = estimate_frf(records);
  const MeasuredFrf h2 = estimate_frf(records, {.estimator = FrfEstimator::h2});
  for (std::size_t i = 0; i < h1.frequency_hz.size(); i += 7) {
    EXPECT_LE(h1.coherence[i], 1.0);
    // |H1| / |H2| is the coherence.
    EXPECT_NEAR(std::abs(h1.receptance[i]) / std::abs(h2.receptance[i]), h1.coherence[i], 1e-9);
  }
  const auto near_mode = static_cast<std::size_t>(1034.0 / (25600.0 / 8192.0));
  EXPECT_GT(h1.coherence[near_mode], 0.95);
  EXPECT_LT(h1.coherence[3000], 0.9);
}

TEST(ImpactTest, BadRecordsAreNamed) {
  EXPECT_THROW(estimate_frf({}), InvalidInput);
  Random random(7);
  ImpactRecord record = blow(kTool, random, 0.0);
  ImpactRecord shorter = record;
  shorter.force.pop_back();
  EXPECT_THROW(estimate_frf({record, shorter}), InvalidInput);
  ImpactRecord turned = record;
  for (double& f : turned.force) f = -f;
  EXPECT_THROW(estimate_frf({turned}), InvalidInput);
  record.response[5] = std::nan("");
  EXPECT_THROW(estimate_frf({record}), InvalidInput);
  Random again(8);
  const MeasuredFrf frf = estimate_frf({blow(kTool, again, 0.0)});
  EXPECT_THROW(fit_modes(frf, {.low_hz = 1000.0, .high_hz = 1001.0}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::vibration
