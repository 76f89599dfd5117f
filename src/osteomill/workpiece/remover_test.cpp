// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/remover.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/engaged_force.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/removal_for_test.hpp"
#include "osteomill/workpiece/swept_tool.hpp"

namespace osteomill::workpiece {
namespace {

constexpr double mm = units::mm;
constexpr double kPi = std::numbers::pi;

cutting::Cutter tapered(double diameter, double corner, double taper) {
  cutting::Cutter cutter = bull(diameter, corner);
  cutter.shape = cutting::CutterShape::tapered;
  cutter.taper_angle = taper;
  return cutter;
}

/// Cuts along a straight line in equal steps; returns the sum.
Removal cut(Remover& remover, const Vector3& from, const Vector3& to, int steps) {
  Removal sum;
  for (int k = 0; k < steps; ++k) {
    const Removal step = remover.step(from + (to - from) * (static_cast<double>(k) / steps),
                                      from + (to - from) * ((k + 1.0) / steps));
    sum.volume += step.volume;
    sum.mass += step.mass;
    sum.scaled_volume += step.scaled_volume;
    sum.buried_volume += step.buried_volume;
  }
  return sum;
}

double slot_error(double spacing) {
  Stock stock = block({0, 0, -8 * mm}, {24 * mm, 20 * mm, 0}, {1900.0, 1.0}, spacing);
  Remover remover(stock, cylinder(3 * mm));
  const Vector3 along(std::cos(0.5), std::sin(0.5), 0.0);
  const Vector3 start(5 * mm, 5 * mm, -5 * mm);
  const Removal slot = cut(remover, start, start + 12 * mm * along, 30);
  const double analytic = 12 * mm * 3 * mm * 5 * mm;
  return slot.volume / analytic - 1.0;
}

TEST(Removal, OfAnObliqueSlotConvergesToItsVolume) {
  // A slot 3 mm wide and 5 mm deep at 28.6 degrees to the grid. The floor of the slot meets its
  // walls in corners that occupancy rounds off: second order in the spacing, below 0.3 % (the
  // platform's mark) at 0.2 mm, which is 7.5 voxels a radius.
  EXPECT_LT(std::abs(slot_error(0.2 * mm)), 3e-3);
  // Order: the error falls at least with the square from 0.6 to 0.2 mm (a factor of 9, half
  // of it asked for), up to the sampling of the
  // walls, which is random below 1e-4.
  EXPECT_LT(std::abs(slot_error(0.2 * mm)), std::abs(slot_error(0.6 * mm)) / 4.5 + 1e-4);
}

TEST(Removal, BalancesToTheLastUnit) {
  Stock stock = tibia_section({}, 0.4 * mm, 1 * mm);
  const double mass_before = stock.remaining_mass();
  const double volume_before = stock.remaining_volume();
  Remover remover(stock, ball(8 * mm));
  Removal sum = cut(remover, {-6 * mm, 3 * mm, -4 * mm}, {30 * mm, 7 * mm, -6 * mm}, 123);
  EXPECT_GT(sum.volume, 100 * units::mm3);
  EXPECT_EQ(sum.buried_volume, 0.0);
  // Volumes are whole numbers of units: only the last product rounds.
  EXPECT_NEAR(stock.remaining_volume() + sum.volume, volume_before, 1e-14 * volume_before);
  EXPECT_EQ(volume_before, stock.initial_volume());
  // Masses are sums of 1e5 products.
  EXPECT_NEAR(stock.remaining_mass() + sum.mass, mass_before, 1e-12 * mass_before);
}

struct SplitCase {
  const char* name;
  cutting::Cutter cutter;
  Vector3 from_mm, to_mm;
};

class Splitting : public testing::TestWithParam<SplitCase> {};

TEST_P(Splitting, APathInOneTenOrAThousandPiecesLeavesTheSameStock) {
  const auto after = [&](int pieces) {
    Stock stock = block({0, 0, -8 * mm}, {16 * mm, 12 * mm, 0}, {1900.0, 1.0}, 0.4 * mm, 0.4 * mm);
    Remover remover(stock, GetParam().cutter);
    cut(remover, GetParam().from_mm * mm, GetParam().to_mm * mm, pieces);
    return stock;
  };
  const Stock one = after(1);
  for (int pieces : {10, 1000}) {
    const Stock many = after(pieces);
    const geometry::GridShape& shape = one.shape();
    int differing = 0;
    for (int z = 0; z < shape.size[2]; ++z)
      for (int y = 0; y < shape.size[1]; ++y)
        for (int x = 0; x < shape.size[0]; ++x) {
          const double difference = std::abs(one.occupancy(x, y, z) - many.occupancy(x, y, z));
          // Rounding may tip a voxel over to the next unit.
          EXPECT_LE(difference, 1.0 / Stock::kFull);
          if (difference > 0.0) ++differing;
        }
    EXPECT_LE(differing, 3) << pieces;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Table, Splitting,
    testing::Values(SplitCase{"cylinder_level", cylinder(4 * mm), {-3, 2, -3}, {11, 7.3, -3}},
                    SplitCase{"cylinder_ramp", cylinder(4 * mm), {-3, 2, 0.5}, {11, 7.3, -3}},
                    SplitCase{"cylinder_ramp_up", cylinder(4 * mm), {-3, 6, -4}, {15, 7.3, 1}},
                    SplitCase{"cylinder_plunge", cylinder(4 * mm), {8, 6, 1}, {8, 6, -5}},
                    SplitCase{"ball_level", ball(5 * mm), {-3, 2, -3}, {11, 7.3, -3}},
                    SplitCase{"ball_ramp", ball(5 * mm), {-3, 2, 0.5}, {11, 7.3, -3}},
                    SplitCase{"ball_ramp_up", ball(5 * mm), {-3, 6, -4}, {15, 7.3, 1}},
                    SplitCase{"bull_level", bull(5 * mm, 1 * mm), {-3, 2, -3}, {11, 7.3, -3}},
                    SplitCase{"bull_ramp", bull(5 * mm, 1 * mm), {-3, 2, 0.5}, {11, 7.3, -3}},
                    SplitCase{
                        "tapered_level", tapered(6 * mm, 1 * mm, 0.4), {-4, 2, -3}, {11, 7.3, -3}},
                    SplitCase{"ball_plunge", ball(5 * mm), {8, 6, 1}, {8, 6, -5}}),
    [](const auto& of) { return of.param.name; });

TEST(Removal, IsWhatTheReferenceDistanceSays) {
  for (const cutting::Cutter& cutter : {cylinder(4 * mm), ball(5 * mm), bull(5 * mm, 1 * mm),
                                        tapered(6 * mm, 1 * mm, 20 * units::deg)})
    for (const Vector3& to_mm : {Vector3(12, 7, -3), Vector3(12, 7, -5), Vector3(3, 9, -2)}) {
      Stock stock = block({0, 0, -8 * mm}, {16 * mm, 12 * mm, 0}, {1900.0, 1.0}, 0.4 * mm);
      const Stock before = stock;
      const Vector3 from(2 * mm, 3 * mm, -3 * mm);
      const Vector3 to = to_mm * mm;
      Remover remover(stock, cutter);
      cut(remover, from, to, 7);
      const Meridian meridian(cutter);
      const SweptTool swept(meridian, from, to);
      const geometry::GridShape& shape = stock.shape();
      for (int z = 0; z < shape.size[2]; ++z)
        for (int y = 0; y < shape.size[1]; ++y)
          for (int x = 0; x < shape.size[0]; ++x) {
            const double d = swept.distance(shape.centre(x, y, z));
            const double expected =
                std::min(before.occupancy(x, y, z), std::clamp(0.5 + d / (0.4 * mm), 0.0, 1.0));
            // Half a unit of rounding.
            ASSERT_NEAR(stock.occupancy(x, y, z), expected, 0.51 / Stock::kFull)
                << x << " " << y << " " << z;
          }
    }
}

TEST(Removal, InAirTakesNothingAndEngagesNothing) {
  Stock stock = block({0, 0, -8 * mm}, {16 * mm, 12 * mm, 0}, {1900.0, 1.0}, 0.4 * mm, 2 * mm);
  Remover remover(stock, ball(5 * mm));
  const Removal above = cut(remover, {2 * mm, 6 * mm, 0.5 * mm}, {14 * mm, 6 * mm, 0.5 * mm}, 20);
  EXPECT_EQ(above.volume, 0.0);
  EXPECT_EQ(above.mass, 0.0);
  for (double weight : remover.engagement().weights) EXPECT_EQ(weight, 0.0);
  // Into the bone, then the same way again: what is gone is gone.
  cut(remover, {14 * mm, 6 * mm, 0.5 * mm}, {14 * mm, 6 * mm, -2 * mm}, 20);
  cut(remover, {14 * mm, 6 * mm, -2 * mm}, {2 * mm, 6 * mm, -2 * mm}, 20);
  const Removal again = cut(remover, {2 * mm, 6 * mm, -2 * mm}, {14 * mm, 6 * mm, -2 * mm}, 20);
  EXPECT_EQ(again.volume, 0.0);
  for (double weight : remover.engagement().weights) EXPECT_EQ(weight, 0.0);
  // No density, material or force where there is air.
  const geometry::GridShape& shape = stock.shape();
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x)
        if (stock.occupancy(x, y, z) == 0.0) {
          ASSERT_EQ(stock.material(x, y, z).density, 0.0);
          ASSERT_EQ(stock.material(x, y, z).force_scale, 0.0);
        }
}

TEST(Removal, CountsBoneAroundTheStartAsBuried) {
  Stock stock = block({0, 0, -8 * mm}, {16 * mm, 12 * mm, 0}, {1900.0, 1.0}, 0.2 * mm);
  Remover remover(stock, cylinder(4 * mm));
  const Removal step = remover.step({8 * mm, 6 * mm, -3 * mm}, {8.1 * mm, 6 * mm, -3 * mm});
  // A cylinder of 10 voxels radius: volume within (1/20)^2 of the exact one, and the floor's
  // corner.
  EXPECT_NEAR(step.buried_volume, kPi * 4 * 3 * units::mm3, 0.005 * kPi * 4 * 3 * units::mm3);
  EXPECT_NEAR(step.volume, 0.1 * 4 * 3 * units::mm3, 0.05 * 0.1 * 4 * 3 * units::mm3);
}

TEST(Removal, RefusesACutterThatTheGridCannotShowOrHold) {
  Stock stock = block({0, 0, -8 * mm}, {16 * mm, 12 * mm, 0}, {1900.0, 1.0}, 0.4 * mm);
  EXPECT_THROW(Remover(stock, cylinder(1 * mm)), InvalidInput);
  EXPECT_THROW(Remover(stock, cylinder(20 * mm)), InvalidInput);
  EXPECT_THROW(Remover(stock, cylinder(-3 * mm)), InvalidInput);
}

// ---- engagement against analytic immersion -----------------------------------------------------

struct ImmersionCase {
  const char* name;
  cutting::Cutter cutter;
  double depth_mm;
  cutting::ImmersionKind kind;
  double radial_depth_mm;
  double heading;  ///< of the feed against the grid, rad
};

class Immersed : public testing::TestWithParam<ImmersionCase> {};

TEST_P(Immersed, GivesTheForcesOfTheNominalCut) {
  const ImmersionCase& of = GetParam();
  const double spacing = of.cutter.radius / 20.0;  // 20 voxels a radius
  const geometry::GridShape shape =
      cubes_over({-8 * mm, -8 * mm, -5 * mm}, {8 * mm, 8 * mm, 0.4 * mm}, spacing);
  const Vector3 along(std::cos(of.heading), std::sin(of.heading), 0.0);
  const Vector3 beside(-along.y(), along.x(), 0.0);
  // The surfaces lie off the layers of voxels on purpose.
  const Vector3 offset(0.013 * mm, 0.037 * mm, -0.021 * mm);
  Stock stock(shape, [&](const Vector3& p_W) {
    const Vector3 p = p_W - offset;
    const double lateral = p.dot(beside);
    // Finished wall at +y after up-milling, at -y after down-milling: bone from there inwards.
    double beyond = -1.0;
    const double inner = of.cutter.radius - of.radial_depth_mm * mm;
    if (of.kind == cutting::ImmersionKind::up) beyond = inner - lateral;
    if (of.kind == cutting::ImmersionKind::down) beyond = lateral + inner;
    return BoneSample{std::max(p.z(), beyond), {1900.0, 1.0}};
  });
  RemoverOptions options;
  options.patches = patches_for(of.cutter, spacing);
  Remover remover(stock, of.cutter, options);
  const auto at = [&](double s) -> Vector3 {
    return offset + s * along - of.depth_mm * mm * Vector3::UnitZ();
  };
  cut(remover, at(-3 * mm), at(0), 100);
  const cutting::Condition condition{6000 * units::rpm, 0.03 * mm};
  const cutting::EngagedForce model(of.cutter, chip_and_rubbing_law(), options.patches.angles,
                                    options.patches.slices, options.patches.slice_height);
  Vector3 force = Vector3::Zero();
  const int steps = 60;
  for (int k = 0; k < steps; ++k) {
    remover.step(at(0.3 * spacing * k), at(0.3 * spacing * (k + 1)));
    force += model.mean(remover.engagement(), condition).force / steps;
  }
  const cutting::Immersion immersion{of.kind, of.radial_depth_mm * mm, of.depth_mm * mm};
  const Vector3 exact =
      cutting::mean_load(of.cutter, chip_and_rubbing_law(), condition, immersion).force;
  // The platform's mark is 1 % at 20 voxels a radius.
  EXPECT_LT((force - exact).norm(), 0.01 * exact.norm());
}

constexpr cutting::ImmersionKind kSlot = cutting::ImmersionKind::slot;
constexpr cutting::ImmersionKind kUp = cutting::ImmersionKind::up;
constexpr cutting::ImmersionKind kDown = cutting::ImmersionKind::down;

INSTANTIATE_TEST_SUITE_P(
    Table, Immersed,
    testing::Values(
        ImmersionCase{"cylinder_slot", cylinder(4 * mm), 3.0, kSlot, 0.0, 0.0},
        ImmersionCase{"cylinder_slot_oblique", cylinder(4 * mm), 3.0, kSlot, 0.0, 0.5},
        ImmersionCase{"cylinder_half_up", cylinder(4 * mm), 3.0, kUp, 2.0, 0.5},
        ImmersionCase{"cylinder_half_down", cylinder(4 * mm), 3.0, kDown, 2.0, 0.5},
        ImmersionCase{"cylinder_half_down_along_y", cylinder(4 * mm), 3.0, kDown, 2.0, kPi / 2},
        ImmersionCase{"cylinder_quarter_up", cylinder(4 * mm), 3.0, kUp, 1.0, 0.3},
        ImmersionCase{"cylinder_shallow_down", cylinder(4 * mm), 3.0, kDown, 0.5, 0.8},
        ImmersionCase{"ball_slot_1_mm", ball(8 * mm), 1.0, kSlot, 0.0, 0.0},
        ImmersionCase{"ball_slot_1_mm_oblique", ball(8 * mm), 1.0, kSlot, 0.0, 0.5},
        ImmersionCase{"ball_half_up", ball(8 * mm), 2.5, kUp, 4.0, 0.5},
        ImmersionCase{"bull_slot", bull(6 * mm, 2 * mm), 3.0, kSlot, 0.0, 0.3},
        ImmersionCase{"bull_half_up", bull(6 * mm, 2 * mm), 3.0, kUp, 3.0, 0.5},
        ImmersionCase{"tapered_slot", tapered(6 * mm, 1 * mm, 0.3), 3.0, kSlot, 0.0, 0.3},
        ImmersionCase{"ball_half_down", ball(8 * mm), 2.5, kDown, 4.0, 0.8}),
    [](const auto& of) { return of.param.name; });

}  // namespace
}  // namespace osteomill::workpiece
