// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/stability.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/vibration/chatter_simulation.hpp"
#include "osteomill/vibration/floquet.hpp"
#include "osteomill/vibration/frequency_domain.hpp"
#include "osteomill/vibration/time_domain_maps.hpp"

namespace osteomill::vibration {
namespace {

using units::mm;
using units::rpm;
constexpr double kPi = std::numbers::pi;
constexpr EdgeStiffness kMetal{.tangential = 6e8, .radial = 2e8};

enum class Immersion { slot, up, down };

Regeneration cut(Immersion immersion, double lag = 0.0) {
  switch (immersion) {
    case Immersion::slot:
      return {2, 0.0, kPi, lag, kMetal};
    case Immersion::up:
      return {2, 0.0, kPi / 2, lag, kMetal};
    default:
      return {2, kPi / 2, kPi, lag, kMetal};
  }
}

// The published one-degree-of-freedom mill: 922 Hz, 1.1 %, 0.03993 kg, along the feed.
RegenerativeSystem one_direction(Immersion immersion, double lag = 0.0) {
  return {{{922.0, 0.011, 0.03993, 1.0, 0.0}}, cut(immersion, lag)};
}

RegenerativeSystem two_directions(Immersion immersion) {
  return {{{922.0, 0.011, 0.03993, 1.0, 0.0}, {922.0, 0.011, 0.03993, 0.0, 1.0}}, cut(immersion)};
}

struct Published {
  Immersion immersion;
  double speed_rpm;
  double depth_mm;
  Bifurcation bifurcation;
};

const std::vector<Published> kPublished = {{Immersion::slot, 5000, 0.40863, Bifurcation::hopf},
                                           {Immersion::slot, 10000, 0.32238, Bifurcation::hopf},
                                           {Immersion::slot, 15000, 0.38659, Bifurcation::hopf},
                                           {Immersion::slot, 20000, 1.41751, Bifurcation::flip},
                                           {Immersion::up, 5000, 0.26028, Bifurcation::hopf},
                                           {Immersion::up, 10000, 0.21353, Bifurcation::hopf},
                                           {Immersion::up, 15000, 0.25887, Bifurcation::hopf},
                                           {Immersion::up, 20000, 1.18530, Bifurcation::hopf},
                                           {Immersion::down, 5000, 0.84720, Bifurcation::hopf},
                                           {Immersion::down, 10000, 2.10469, Bifurcation::flip},
                                           {Immersion::down, 15000, 2.59624, Bifurcation::flip},
                                           {Immersion::down, 20000, 0.71964, Bifurcation::hopf}};

void expect_published(StabilityMethod method, int steps, double tolerance) {
  for (const Published& p : kPublished) {
    const RegenerativeSystem system = one_direction(p.immersion);
    const LobePoint point = lobes(system, {p.speed_rpm * rpm},
                                  {.method = method, .steps = steps, .max_depth = 10 * mm})[0];
    EXPECT_NEAR(point.limit_depth / mm, p.depth_mm, tolerance * p.depth_mm) << p.speed_rpm;
    EXPECT_EQ(point.bifurcation, p.bifurcation) << p.speed_rpm;
  }
}

TEST(Stability, SemiDiscretisationMeetsThePublishedLimitsWithinHalfAPercentByDefault) {
  expect_published(StabilityMethod::semi_discretisation, 0, 5e-3);
}

TEST(Stability, FullDiscretisationMeetsThemToo) {
  expect_published(StabilityMethod::full_discretisation, 0, 5e-3);
}

TEST(Stability, MultiFrequencyMeetsThemWithFiveHarmonics) {
  // Cut off at five harmonics beyond the mode: 1/5² of the shares that decay as 1/r³.
  expect_published(StabilityMethod::multi_frequency, 0, 2e-3);
}

TEST(Stability, CollocationMeetsTheConvergedDigits) {
  // Two methods of unlike kind, both converged, agree on the published five digits.
  expect_published(StabilityMethod::collocation, 240, 1e-4);
}

TEST(Stability, BothDiscretisationsConvergeWithSecondOrder) {
  const RegenerativeSystem system = one_direction(Immersion::slot);
  const double exact = std::abs(collocation_multiplier(system, 10000 * rpm, 0.3 * mm, 80).value);
  const auto miss = [&](auto method, int steps) {
    return std::abs(dominant_multiplier(method(system, 10000 * rpm, 0.3 * mm, steps)).value) -
           exact;
  };
  EXPECT_NEAR(std::log2(miss(semi_discretisation, 80) / miss(semi_discretisation, 160)), 2.0, 0.1);
  EXPECT_NEAR(std::log2(miss(full_discretisation, 80) / miss(full_discretisation, 160)), 2.0, 0.1);
}

TEST(Stability, ArnoldiFindsTheMultiplierOfTheWholeMatrix) {
  const RegenerativeSystem system = two_directions(Immersion::up);
  for (const double speed : {3000.0, 11000.0, 21000.0}) {
    for (const double depth : {0.01, 0.3, 3.0}) {
      const DelayMap map = semi_discretisation(system, speed * rpm, depth * mm, 60);
      const double dense = std::abs(dominant_multiplier_dense(map).value);
      EXPECT_NEAR(std::abs(dominant_multiplier(map).value), dense, 1e-6 * dense);
    }
  }
}

TEST(Stability, ZeroOrderHasTheKnownMinima) {
  const struct {
    Immersion immersion;
    double depth_mm, frequency_hz;
  } known[] = {{Immersion::slot, 0.29805, 932.09},
               {Immersion::up, 0.20486, 932.09},
               {Immersion::down, 0.64091, 911.80}};
  for (const auto& k : known) {
    const auto minimum = ZeroOrder(one_direction(k.immersion)).absolute_minimum();
    EXPECT_NEAR(minimum.depth / mm, k.depth_mm, 5e-6) << k.depth_mm;
    EXPECT_NEAR(minimum.chatter_frequency_hz, k.frequency_hz, 5e-3);
  }
}

TEST(Stability, ZeroOrderIsRightForManyTeethAndWrongForFewAtLowImmersion) {
  // Sixteen edges in a slot: the directional coefficients hardly vary.
  const RegenerativeSystem smooth({{922.0, 0.011, 0.03993, 1.0, 0.0}},
                                  Regeneration(16, 0.0, kPi, 0.0, kMetal));
  const StabilityOptions semi{.steps = 200, .max_depth = 10 * mm};
  const StabilityOptions zero{.method = StabilityMethod::zero_order, .max_depth = 10 * mm};
  const double a = lobes(smooth, {3000 * rpm}, semi)[0].limit_depth;
  EXPECT_NEAR(lobes(smooth, {3000 * rpm}, zero)[0].limit_depth, a, 0.01 * a);
  // Half immersion down at 15 000 rpm: it promises twice the depth at which flip chatter begins.
  const RegenerativeSystem few = one_direction(Immersion::down);
  EXPECT_GT(lobes(few, {15000 * rpm}, zero)[0].limit_depth,
            1.9 * lobes(few, {15000 * rpm}, semi)[0].limit_depth);
}

TEST(Stability, UpEqualsDownWhenBothDirectionsAreAlike) {
  // Half immersions are each other's image under a quarter turn, which an isotropic tool ignores.
  for (const double speed : {5000.0, 9000.0, 17000.0}) {
    const auto limit = [&](Immersion immersion) {
      return lobes(two_directions(immersion), {speed * rpm}, {.max_depth = 10 * mm})[0].limit_depth;
    };
    EXPECT_NEAR(limit(Immersion::up), limit(Immersion::down), 1e-5 * limit(Immersion::up));
  }
}

TEST(Stability, HelixWithoutAngleChangesNothingAndAPitchLongHelixIsolatesTheTeeth) {
  const StabilityOptions options{.max_depth = 10 * mm};
  const double straight = lobes(one_direction(Immersion::up), {8000 * rpm}, options)[0].limit_depth;
  EXPECT_NEAR(lobes(one_direction(Immersion::up, 1e-3), {8000 * rpm}, options)[0].limit_depth,
              straight, 1e-4 * straight);
  // When the depth spans a whole pitch of the helix the edges' sum is constant: zero-order is
  // exact.
  const double depth = 0.5 * mm;
  const RegenerativeSystem whole = one_direction(Immersion::up, kPi / depth);
  const Eigen::Matrix2d w = whole.cut().at(0.3, depth), v = whole.cut().at(2.1, depth);
  EXPECT_LT((w - v).norm(), 1e-12 * w.norm());
  EXPECT_LT((w / depth - whole.cut().harmonic(0).real()).norm(), 1e-12 * w.norm() / depth);
}

TEST(Stability, HelixEntersEveryMethodAlike) {
  // A usual helix, and one that turns the edge by a pitch over 2 mm of depth.
  for (const double lag : {400.0, kPi / (2.0 * mm)}) {
    for (const Immersion immersion : {Immersion::slot, Immersion::down}) {
      const RegenerativeSystem system = one_direction(immersion, lag);
      for (const double speed : {9000.0, 20000.0}) {
        const auto limit = [&](StabilityMethod method, int steps) {
          return lobes(system, {speed * rpm},
                       {.method = method, .steps = steps, .max_depth = 4 * mm})[0];
        };
        const LobePoint exact = limit(StabilityMethod::collocation, 96);
        const LobePoint hill = limit(StabilityMethod::multi_frequency, 0);
        const LobePoint semi = limit(StabilityMethod::semi_discretisation, 0);
        ASSERT_EQ(std::isfinite(exact.limit_depth), std::isfinite(hill.limit_depth)) << speed;
        if (!std::isfinite(exact.limit_depth)) continue;
        // As for straight flutes: five harmonics, and the default steps.
        EXPECT_NEAR(hill.limit_depth, exact.limit_depth, 2e-3 * exact.limit_depth) << speed;
        EXPECT_NEAR(semi.limit_depth, exact.limit_depth, 5e-3 * exact.limit_depth) << speed;
        EXPECT_EQ(hill.bifurcation, exact.bifurcation) << speed;
      }
    }
  }
}

TEST(Stability, MultiFrequencyLeavesOutTheLinesOfModesTooStiffToChatter) {
  // A mode at 9 kHz, forty times as stiff: 54 harmonics of the tooth passing away.
  const double mass = 40.0 * 0.03993 * std::pow(922.0 / 9000.0, 2);
  const RegenerativeSystem system(
      {{922.0, 0.011, 0.03993, 1.0, 0.0}, {9000.0, 0.011, mass, 1.0, 0.0}}, cut(Immersion::slot));
  const auto limit = [&](StabilityMethod method) {
    return lobes(system, {5000 * rpm}, {.method = method, .max_depth = 2 * mm})[0].limit_depth;
  };
  const double semi = limit(StabilityMethod::semi_discretisation);
  EXPECT_NEAR(limit(StabilityMethod::multi_frequency), semi, 5e-3 * semi);
}

TEST(Stability, FrequencyDomainMethodsTakeAMeasuredReceptance) {
  const RegenerativeSystem modal = one_direction(Immersion::slot);
  // A structure of twice the stiffness, measured: it doubles every limit, whatever the modes say.
  const RegenerativeSystem measured(modal.modes(), modal.cut(), [&](double f) {
    const TipReceptance h = tip_receptance(modal.modes(), f);
    return TipReceptance{0.5 * h.xx, 0.5 * h.xy, 0.5 * h.yy};
  });
  for (const auto method : {StabilityMethod::zero_order, StabilityMethod::multi_frequency}) {
    const StabilityOptions options{.method = method, .max_depth = 10 * mm};
    const double a = lobes(modal, {10000 * rpm}, options)[0].limit_depth;
    EXPECT_NEAR(lobes(measured, {10000 * rpm}, options)[0].limit_depth, 2.0 * a, 1e-6 * a);
  }
}

TEST(Stability, MeanOfTheDirectionalMatrixIsItsIntegral) {
  for (const double lag : {0.0, 300.0}) {
    const Regeneration r = cut(Immersion::up, lag);
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    const int n = 20000;
    for (int i = 0; i < n; ++i) sum += r.at(0.4 + 2.0 * (i + 0.5) / n, 2 * mm) / n;
    Eigen::Matrix2d fine = Eigen::Matrix2d::Zero();
    for (int i = 0; i < 50; ++i) fine += r.mean(0.4 + 0.04 * i, 0.4 + 0.04 * (i + 1), 2 * mm) / 50;
    // Midpoint rule over a jump: half a step of 2/20000 of the peak.
    EXPECT_LT((fine - sum).norm(), 2e-4 * sum.norm()) << lag;
  }
}

TEST(Stability, AngleDependentLawWithConstantSlopesIsTheLinearOne) {
  const RegenerativeSystem table({{922.0, 0.011, 0.03993, 1.0, 0.0}},
                                 Regeneration(2, 0.0, kPi / 2, 0.0, [](double) { return kMetal; }));
  const StabilityOptions options{.max_depth = 10 * mm};
  EXPECT_NEAR(lobes(table, {10000 * rpm}, options)[0].limit_depth,
              lobes(one_direction(Immersion::up), {10000 * rpm}, options)[0].limit_depth, 1e-12);
}

TEST(Stability, ContinuationFindsTheScannedBoundary) {
  const RegenerativeSystem system = two_directions(Immersion::up);
  std::vector<double> speeds;
  for (int i = 0; i < 40; ++i) speeds.push_back((8000 + 150 * i) * rpm);
  const StabilityOptions options{.steps = 40, .max_depth = 5 * mm};
  const auto scanned = lobes(system, speeds, options);
  const auto followed = lobes_by_continuation(system, speeds, options);
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    // Both end on the root of one function to 1e-7.
    EXPECT_NEAR(followed[i].limit_depth, scanned[i].limit_depth, 1e-6 * scanned[i].limit_depth);
  }
}

TEST(Stability, MapIsBelowOneUnderTheLobesAndAboveOneOverThem) {
  const RegenerativeSystem system = one_direction(Immersion::slot);
  const StabilityOptions options{.steps = 60, .max_depth = 5 * mm};
  const std::vector<double> speeds = {9000 * rpm, 12000 * rpm};
  const auto limits = lobes(system, speeds, options);
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const double a = limits[i].limit_depth;
    const auto radii = stability_map(system, {speeds[i]}, {0.98 * a, 1.02 * a}, options);
    EXPECT_LT(radii[0], 1.0);
    EXPECT_GT(radii[1], 1.0);
  }
}

TEST(Stability, TimeDomainSimulationAgreesOnBothSidesOfTheLobes) {
  Random random(2002);
  for (int i = 0; i < 20; ++i) {
    const double speed = random.uniform(4000.0, 22000.0) * rpm;
    const Immersion immersion = static_cast<Immersion>(random.bits() % 3);
    const RegenerativeSystem system =
        i % 2 == 0 ? one_direction(immersion) : two_directions(immersion);
    const double limit = lobes(system, {speed}, {.max_depth = 20 * mm})[0].limit_depth;
    ASSERT_TRUE(std::isfinite(limit)) << i;
    // 7 %: the simulation puts an entry jump on its nearest step, which shifts the limit by 1-2 %.
    for (const double share : {0.93, 1.07}) {
      const ChatterSimulation simulated =
          simulate_chatter(system, speed, share * limit, 0.1 * mm, {.edges_may_leave = false});
      EXPECT_EQ(simulated.unstable, share > 1.0) << i << " growth " << simulated.growth;
      const double radius = spectral_radius(system, speed, share * limit, {.max_depth = 20 * mm});
      EXPECT_NEAR(simulated.growth, radius, 0.01) << i;
    }
  }
}

TEST(Stability, ChatterStopsGrowingWhenTheEdgesLeaveTheCut) {
  const RegenerativeSystem system = two_directions(Immersion::down);
  const double limit = lobes(system, {10000 * rpm}, {.max_depth = 20 * mm})[0].limit_depth;
  const auto free = simulate_chatter(system, 10000 * rpm, 1.3 * limit, 0.1 * mm, {});
  const auto kept =
      simulate_chatter(system, 10000 * rpm, 1.3 * limit, 0.1 * mm, {.edges_may_leave = false});
  EXPECT_TRUE(free.unstable);
  EXPECT_TRUE(kept.unstable);
  EXPECT_GT(kept.peak_to_peak_x, 20.0 * free.peak_to_peak_x);
  const auto calm = simulate_chatter(system, 10000 * rpm, 0.9 * limit, 0.1 * mm, {});
  EXPECT_FALSE(calm.unstable);
  EXPECT_LT(5.0 * calm.peak_to_peak_x, free.peak_to_peak_x);
}

TEST(Stability, SimulatedGrowthIsTheSpectralRadius) {
  const RegenerativeSystem system = one_direction(Immersion::slot);
  const double expected = spectral_radius(system, 10000 * rpm, 0.25 * mm, {.max_depth = 5 * mm});
  const auto simulated = simulate_chatter(system, 10000 * rpm, 0.25 * mm, 0.1 * mm, {});
  EXPECT_NEAR(simulated.growth, expected, 3e-3);
}

TEST(DelayEquation, HayesRootIsReproduced) {
  // x' = −x − x(t − 1): λ = −0.6050 ± 1.7882 i, |e^λ| = 0.5460630043605.
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  const auto radius = [&](int steps) {
    return std::abs(dominant_multiplier(semi_discretise(1.0, steps, one, [&](int) {
                      return DelayCoefficients{-one, -one};
                    })).value);
  };
  const double exact = 0.5460630043605;
  EXPECT_NEAR(radius(400), exact, 1e-6);
  EXPECT_NEAR((radius(100) - exact) / (radius(200) - exact), 4.0, 0.1);
}

TEST(DelayEquation, DelayedMathieuEquationIsReproduced) {
  // x'' + 0.1 x' + (3 + 2 cos t) x = −0.15 x(t − 2π): ρ = 0.5120522841.
  const double delta = 3.0, epsilon = 2.0, b0 = -0.15, a1 = 0.1, period = 2.0 * kPi;
  Eigen::MatrixXd output(1, 2);
  output << 1.0, 0.0;
  const auto radius = [&](int steps) {
    return std::abs(dominant_multiplier(semi_discretise(period, steps, output, [&](int i) {
                      const double h = period / steps;
                      const double cosine =
                          (std::sin((i + 1) * h) - std::sin(i * h)) / h;  // mean of the step
                      DelayCoefficients c{Eigen::MatrixXd(2, 2), Eigen::MatrixXd(2, 1)};
                      c.a << 0.0, 1.0, -(delta + epsilon * cosine), -a1;
                      c.b << 0.0, b0;
                      return c;
                    })).value);
  };
  const double exact = 0.5120522841;
  EXPECT_NEAR(radius(1000), exact, 2e-5);
  EXPECT_NEAR((radius(250) - exact) / (radius(500) - exact), 4.0, 0.2);
}

TEST(Stability, BadInputsAreNamed) {
  const RegenerativeSystem good = one_direction(Immersion::up);
  const auto message = [](auto&& act) -> std::string {
    try {
      act();
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "no fault";
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(message([&] { lobes(good, {0.0}, {.max_depth = 1.0}); }),
              HasSubstr("options.spindle_speeds_rpm"));
  EXPECT_THAT(message([&] { lobes(good, {100.0}, {}); }), HasSubstr("options.max_depth_mm"));
  EXPECT_THAT(message([&] { lobes(good, {100.0}, {.steps = 2, .max_depth = 1.0}); }),
              HasSubstr("options.steps"));
  EXPECT_THAT(message([&] { Regeneration(0, 0.0, 1.0, 0.0, kMetal); }), HasSubstr("cut.flutes"));
  EXPECT_THAT(message([&] { Regeneration(2, 1.0, 1.0, 0.0, kMetal); }),
              HasSubstr("angle of the cut"));
  EXPECT_THAT(
      message([&] { RegenerativeSystem({{922.0, 0.0, 0.04, 1.0, 0.0}}, cut(Immersion::up)); }),
      HasSubstr("damping_ratio"));
  EXPECT_THAT(message([&] { RegenerativeSystem({}, cut(Immersion::up)); }),
              HasSubstr("structure.modes"));
  EXPECT_THAT(message([&] { multi_frequency_limit(good, 100.0, 41, 1.0); }),
              HasSubstr("options.harmonics"));
  EXPECT_THAT(message([&] { simulate_chatter(good, 100.0, 1e-3, 0.0, {}); }),
              HasSubstr("cut.feed_per_tooth_mm"));
  EXPECT_THAT(
      message([&] { spectral_radius(good, 100.0, 1e-3, {.method = StabilityMethod::zero_order}); }),
      HasSubstr("options.method"));
}

}  // namespace
}  // namespace osteomill::vibration
