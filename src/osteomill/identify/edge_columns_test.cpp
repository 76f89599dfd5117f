// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/edge_columns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/identify/instantaneous.hpp"

namespace osteomill::identify {
namespace {

using cutting::Condition;
using cutting::Cutter;
using cutting::Immersion;
using cutting::ImmersionKind;

constexpr double kTurn = 2.0 * std::numbers::pi;

Cutter cylinder(int flutes) {
  return {.radius = 3.175e-3, .flutes = flutes, .helix_angle = 0.52, .cutting_length = 10e-3};
}

std::vector<double> angles(int count) {
  std::vector<double> result;
  for (int i = 0; i < count; ++i) result.push_back(kTurn * i / count);
  return result;
}

Eigen::VectorXd six() {
  return (Eigen::VectorXd(6) << 60e6, 45e6, 12e6, 4e3, 6e3, -1e3).finished();
}

/// Largest difference from the force model itself with the law of the coefficients.
double largest_difference(const Cutter& cutter, const Condition& condition,
                          const Immersion& immersion, const std::vector<UnitForce>& units,
                          const Eigen::VectorXd& values, double& peak) {
  const int steps = 90;
  const cutting::Revolution truth =
      cutting::revolution(cutter, law_of(units, values), condition, immersion, steps);
  const EdgeColumns columns(cutter, condition, immersion, units);
  const Eigen::VectorXd force = columns.at(angles(steps), 0.0, cutter.run_out) * values;
  double largest = 0.0;
  peak = 0.0;
  for (int i = 0; i < steps; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double exact = truth.loads[static_cast<std::size_t>(i)].force[axis];
      largest = std::max(largest, std::abs(exact - force[axis * steps + i]));
      peak = std::max(peak, std::abs(exact));
    }
  }
  return largest;
}

TEST(EdgeColumns, TimesCoefficientsAreTheForcesOfTheLaw) {
  const Condition condition{.spindle_speed = 500.0, .feed_per_tooth = 20e-6};
  const Condition rising{.spindle_speed = 500.0, .feed_per_tooth = 20e-6, .feed_elevation = -0.2};
  for (const Condition& one : {condition, rising}) {
    for (const Immersion& immersion :
         {Immersion{ImmersionKind::slot, 0.0, 2.5e-3}, Immersion{ImmersionKind::up, 1e-3, 2.5e-3},
          Immersion{ImmersionKind::down, 2e-3, 2.5e-3}}) {
      double peak = 0.0;
      // Both integrate smooth pieces between the same exact ends, ours on panels three times as
      // wide: sixth order in pi/18.
      const double miss =
          largest_difference(cylinder(3), one, immersion, linear_law_units(), six(), peak);
      EXPECT_LT(miss, 1e-6 * peak);
    }
  }
  Cutter ball = cylinder(2);
  ball.shape = cutting::CutterShape::ball;
  const Eigen::VectorXd polynomial =
      (Eigen::VectorXd(12) << 60e6, -20e6, 5e6, 40e6, 3e6, -2e6, 10e6, 2e6, 1e6, 4e3, 6e3, -1e3)
          .finished();
  double peak = 0.0;
  const double miss = largest_difference(ball, condition, {ImmersionKind::slot, 0.0, 2e-3},
                                         polynomial_law_units(2, 0), polynomial, peak);
  // Near the tip of a ball kappa grows as the root of the height; the panels follow kappa.
  EXPECT_LT(miss, 1e-6 * peak);
}

TEST(EdgeColumns, AgreeWithTheForceModelUnderRunOutAsFarAsItResolvesTheEndOfAChip) {
  const Condition condition{.spindle_speed = 500.0, .feed_per_tooth = 10e-6};
  Cutter cutter = cylinder(2);
  cutter.run_out = {6e-6, 0.8, 2e-4, 1.9};
  double peak = 0.0;
  const double miss = largest_difference(cutter, condition, {ImmersionKind::slot, 0.0, 6e-3},
                                         linear_law_units(), six(), peak);
  // The force model ends a chip at one of its nodes, a degree apart: a degree of the edge's lag
  // (3.2e-3/tan(30 deg) m/rad of height) with the edge force of 7 N/mm is 0.7 N.
  EXPECT_LT(miss, 0.7);
  EXPECT_GT(peak, 20.0);
}

TEST(EdgeColumns, ChangeSmoothlyWithRunOut) {
  const EdgeColumns columns(cylinder(2), {.spindle_speed = 500.0, .feed_per_tooth = 10e-6},
                            {ImmersionKind::slot, 0.0, 6e-3}, linear_law_units());
  const auto at = [&](double offset) -> Eigen::VectorXd {
    return columns.at(angles(60), 0.3, {offset, 0.7, 0.0, 0.0}) * six();
  };
  // Derivatives over steps of 1e-3 and 1e-4 of the feed agree: no jump is hidden between them, only
  // the kinks where the chip passes from one flute before to another.
  const auto slope = [&](double step) -> Eigen::VectorXd {
    return (at(6e-6 + step) - at(6e-6 - step)) / (2.0 * step);
  };
  EXPECT_LT((slope(1e-8) - slope(1e-9)).norm(), 1e-2 * slope(1e-9).norm());
}

}  // namespace
}  // namespace osteomill::identify
