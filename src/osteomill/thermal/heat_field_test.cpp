// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/thermal/heat_field.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::thermal {
namespace {

using geometry::GridShape;
using geometry::Vector3;
constexpr double mm = units::mm;

GridShape cubes(int x, int y, int z, double spacing) {
  GridShape shape;
  shape.size = {x, y, z};
  shape.spacing = Vector3::Constant(spacing);
  return shape;
}

HeatOptions insulated() {
  HeatOptions options;
  options.convection = 0.0;
  return options;
}

ThermalMaterial bone(int, int, int) { return kCorticalBone; }

TEST(HeatField, OfAHalfSpaceUnderConstantFluxIsTheAnalyticOne) {
  // 10⁴ W/m² into the top; 40 mm deep is out of reach for 60 s (4 sqrt(at) = 15 mm).
  const double spacing = 0.1 * mm, flux = 1e4, step = 0.02;
  HeatField field(cubes(1, 1, 400, spacing), bone, insulated());
  const double start = field.temperature(0, 0, 0);
  const auto rise = [&](double depth) {
    if (depth == 0.0)  // the surface lies half a voxel above the first centre
      return field.temperature(0, 0, 0) - start + flux * 0.5 * spacing / kCorticalBone.conductivity;
    const double at = depth / spacing - 0.5;
    const int low = static_cast<int>(std::floor(at));
    const double part = at - low;
    return (1.0 - part) * field.temperature(0, 0, low) + part * field.temperature(0, 0, low + 1) -
           start;
  };
  int steps = 0;
  for (const auto& [time, surface] : {std::pair{1.0, 9.681}, {10.0, 30.614}, {60.0, 74.990}}) {
    for (; steps * step < time - 1e-9; ++steps) {
      field.add_heat(0, 0, 0, flux * spacing * spacing * step);
      field.advance(step);
    }
    EXPECT_NEAR(half_space_rise(kCorticalBone, flux, 0.0, time), surface, 6e-4);
    // The mark is 1 %.
    EXPECT_NEAR(rise(0.0), surface, 0.01 * surface);
    if (time == 10.0)
      for (const auto& [depth, expected] :
           {std::pair{0.5 * mm, 22.379}, {1.0 * mm, 15.807}, {2.0 * mm, 7.056}}) {
        EXPECT_NEAR(half_space_rise(kCorticalBone, flux, depth, time), expected, 6e-4);
        EXPECT_NEAR(rise(depth), expected, 0.01 * expected);
      }
  }
}

TEST(HeatField, UnderAMovingStripComesWithinTwoPercentOfJaeger) {
  // L = v l/(2a) = 1 at 1 mm/s; 18 voxels in the strip, run until it is quasi steady.
  const double speed = 1e-3, flux = 1e5;
  const double a = kCorticalBone.diffusivity();
  const double half_length = 2.0 * a / speed;
  const double spacing = half_length / 9.0, step = 0.25 * spacing / speed;
  const double run = 12.0 * half_length;
  HeatField field(cubes(160, 1, 80, spacing), bone, insulated());
  const double first = 20.0 * spacing;
  const double heat_per_length = flux * spacing * step;  // J per m of x
  double hottest = 0.0;
  for (double front = 0.0; front < run; front += speed * step) {
    const double low = first + front, high = low + 2.0 * half_length;
    for (int x = 0; x < 160; ++x) {
      const double covered = std::min(high, (x + 1) * spacing) - std::max(low, x * spacing);
      if (covered > 0.0) field.add_heat(x, 0, 0, heat_per_length * covered);
    }
    field.advance(step);
    hottest = field.hottest();
  }
  const double surface = hottest - 310.15 + flux * 0.5 * spacing / kCorticalBone.conductivity;
  const double theta =
      surface * std::numbers::pi * kCorticalBone.conductivity * speed / (2.0 * a * flux);
  EXPECT_NEAR(jaeger_strip_maximum(1.0), 3.11599, 1e-5);
  EXPECT_NEAR(jaeger_strip_maximum(5.0), 7.61271, 1e-5);
  EXPECT_NEAR(theta, 3.11599, 0.02 * 3.11599);
}

/// A block with a notch, two materials and air around.
ThermalMaterial notched(int x, int y, int z) {
  if (x < 2 || y < 1 || z > 16 || (x > 8 && z > 10)) return {};
  return y > 9 ? ThermalMaterial{0.29, 400.0 * 1300.0} : kCorticalBone;
}

TEST(HeatField, ConservesEnergy) {
  HeatField field(cubes(21, 18, 19, 0.2 * mm), notched, insulated());
  EXPECT_FALSE(field.add_heat(0, 0, 0, 1.0));
  for (int k = 0; k < 200; ++k) {
    field.add_heat(3 + k / 20, 5, 10, 1e-3);
    field.advance(k % 2 == 0 ? 0.01 : 0.5);
  }
  EXPECT_NEAR(field.energy(), 0.2, 1e-6 * 0.2);
  // Cut voxels take their heat along, and no more flows through them.
  const double before = field.energy();
  for (int y = 1; y < 18; ++y) field.remove(5, y, 10);
  field.advance(0.1);
  EXPECT_GT(field.cut_energy(), 0.0);
  EXPECT_NEAR(field.energy() + field.cut_energy(), before, 1e-6 * before);
  EXPECT_FALSE(field.is_bone(5, 5, 10));
}

TEST(HeatField, StaysWithinTheTemperaturesBeforeItAtAnyStep) {
  for (const double step : {1e-3, 1.0, 1e4}) {
    HeatOptions options;
    options.convection = 2000.0;
    options.perfusion = 4e4;
    HeatField field(cubes(21, 18, 19, 0.2 * mm), notched, options);
    field.add_heat(4, 5, 8, 0.01);
    const double highest = field.hottest();
    for (int k = 0; k < 4; ++k) {
      field.advance(step);
      for (int z = 0; z < 19; ++z)
        for (int y = 0; y < 18; ++y)
          for (int x = 0; x < 21; ++x) {
            // A millikelvin for the rounding of the elimination.
            EXPECT_LE(field.temperature(x, y, z), highest + 1e-3);
            EXPECT_GE(field.temperature(x, y, z), options.coolant_temperature - 1e-3);
          }
    }
  }
}

TEST(HeatField, OfASmallCubeInACoolantDecaysExponentially) {
  // Biot number h L/k = 0.005: the cube cools as one, with h A/(C).
  GridShape shape = cubes(7, 7, 7, 0.1 * mm);
  HeatOptions options;
  options.convection = 10.0;
  const auto cube = [](int x, int y, int z) {
    const bool in = std::min({x, y, z}) > 0 && std::max({x, y, z}) < 6;
    return in ? kCorticalBone : ThermalMaterial{};
  };
  HeatField field(shape, cube, options);
  const double side = 0.5 * mm;
  const double rate = 10.0 * 6.0 / (side * kCorticalBone.heat_capacity);
  const double before = field.temperature(3, 3, 3) - options.coolant_temperature;
  for (int k = 0; k < 200; ++k) field.advance(0.1);
  const double after = field.temperature(3, 3, 3) - options.coolant_temperature;
  // First order: half a step of 200, rate 0.05/s, is 0.5 % of the decay; the Biot number 0.3 %.
  EXPECT_NEAR(after / before, std::exp(-20.0 * rate), 0.01);
}

TEST(HeatField, IsTheSameForAnyNumberOfThreads) {
  const auto run = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    HeatField field(cubes(40, 33, 37, 0.2 * mm), notched, {});
    for (int k = 0; k < 10; ++k) {
      field.add_heat(4, 5, 8, 0.01);
      field.advance(0.05);
    }
    return field;
  };
  const HeatField one = run(1), two = run(2);
  for (int z = 0; z < 37; ++z)
    for (int y = 0; y < 33; ++y)
      for (int x = 0; x < 40; ++x) ASSERT_EQ(one.temperature(x, y, z), two.temperature(x, y, z));
}

TEST(HeatField, RefusesWhatIsNoBone) {
  const auto with = [](HeatOptions options) { HeatField(cubes(2, 2, 2, 1 * mm), bone, options); };
  HeatOptions options;
  options.convection = -1.0;
  EXPECT_THROW(with(options), InvalidInput);
  options = {};
  options.initial_temperature = 0.0;
  EXPECT_THROW(with(options), InvalidInput);
  EXPECT_THROW(HeatField(cubes(2, 0, 2, 1 * mm), bone, {}), InvalidInput);
  EXPECT_THROW(HeatField(cubes(2, 2, 2, 0.0), bone, {}), InvalidInput);
  HeatField field(cubes(2, 2, 2, 1 * mm), bone, {});
  EXPECT_THROW(field.advance(0.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::thermal
