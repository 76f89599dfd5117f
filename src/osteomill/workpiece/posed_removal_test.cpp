// SPDX-License-Identifier: BSD-3-Clause
// Removal with a tool axis of any direction: see remover_test.cpp for the upright one.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/engaged_force.hpp"
#include "osteomill/workpiece/contact.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/removal_for_test.hpp"
#include "osteomill/workpiece/remover.hpp"
#include "osteomill/workpiece/swing.hpp"

namespace osteomill::workpiece {
namespace {

constexpr double mm = units::mm;
constexpr double kPi = std::numbers::pi;

Removal& operator+=(Removal& sum, const Removal& step) {
  sum.volume += step.volume;
  sum.mass += step.mass;
  sum.scaled_volume += step.scaled_volume;
  sum.buried_volume += step.buried_volume;
  return sum;
}

Removal cut(Remover& remover, const ToolPose& from, const ToolPose& to, int steps) {
  Removal sum;
  for (int k = 0; k < steps; ++k)
    sum += remover.step(between(from, to, static_cast<double>(k) / steps),
                        between(from, to, (k + 1.0) / steps));
  return sum;
}

struct Difference {
  double largest = 0.0;
  int voxels = 0;
};
Difference difference(const Stock& a, const Stock& b) {
  Difference found;
  const geometry::GridShape& shape = a.shape();
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x) {
        const double d = std::abs(a.occupancy(x, y, z) - b.occupancy(x, y, z));
        found.largest = std::max(found.largest, d);
        if (d > 0.0) ++found.voxels;
      }
  return found;
}

Vector3 tilted(double about_x, double about_y) {
  return (Eigen::AngleAxisd(about_y, Vector3::UnitY()) *
          Eigen::AngleAxisd(about_x, Vector3::UnitX()) * Vector3::UnitZ())
      .normalized();
}

TEST(PosedRemoval, OfAnUprightToolIsWhatTheUprightWayDoes) {
  // The smallest tilt that is not upright goes the other way through the code; 1e-9 rad over 30
  // voxels is far below a unit.
  const Vector3 almost = tilted(1e-9, 0.0);
  for (const cutting::Cutter& cutter : {cylinder(4 * mm), ball(5 * mm), bull(5 * mm, 1 * mm)})
    for (const Vector3& to_mm : {Vector3(12, 7, -3), Vector3(12, 7, -5), Vector3(3, 9, -2)}) {
      const Stock whole =
          block({0, 0, -8 * mm}, {16 * mm, 12 * mm, 0}, {1900.0, 1.0}, 0.4 * mm, 0.4 * mm);
      Stock upright = whole, posed = whole;
      Remover by_columns(upright, cutter), by_poses(posed, cutter);
      const Vector3 from(2 * mm, 3 * mm, -3 * mm), to = to_mm * mm;
      const Removal a = cut(by_columns, {from}, {to}, 7);
      const Removal b = cut(by_poses, {from, almost}, {to, almost}, 7);
      const Difference left = difference(upright, posed);
      EXPECT_LE(left.largest, 3.0 / Stock::kFull);  // of the searches on either side
      EXPECT_NEAR(a.volume, b.volume, 1e-5 * a.volume);
      EXPECT_NEAR(a.buried_volume, b.buried_volume, 1e-5 * a.buried_volume);
      const cutting::Engagement& one = by_columns.engagement();
      const cutting::Engagement& other = by_poses.engagement();
      for (std::size_t i = 0; i < one.weights.size(); ++i)
        // Shadows go by 128ths of a cell, which rims divide by their coverage.
        ASSERT_NEAR(one.weights[i], other.weights[i], 1e-2);
    }
}

/// A block of bone, in a frame turned against the grid. The tool's poses are turned along.
struct Turned {
  geometry::Pose X = geometry::Pose::Identity();  // of the block in W
  ToolPose operator()(const Vector3& tip, const Vector3& axis = Vector3::UnitZ()) const {
    return {X * tip, X.linear() * axis};
  }
};

Turned askew() {
  Turned turned;
  turned.X.translate(Vector3(0.013 * mm, 0.037 * mm, -0.021 * mm))
      .rotate(Eigen::AngleAxisd(0.6, Vector3(1.0, -2.0, 0.7).normalized()));
  return turned;
}

/// Bone below z = 0 of the turned frame, and to one side of y = `wall` where there is one.
Stock slab(const Turned& turned, const Vector3& half, double spacing, int side, double wall) {
  const geometry::Pose X_BW = turned.X.inverse();
  return Stock(cubes_over(-half, half, spacing), [=](const Vector3& p_W) {
    const Vector3 p = X_BW * p_W;
    const double beyond = side == 0 ? -1.0 : side > 0 ? wall - p.y() : p.y() - wall;
    return BoneSample{std::max(p.z(), beyond), {1900.0, 1.0}};
  });
}

struct TiltedCase {
  const char* name;
  cutting::Cutter cutter;
  double depth_mm;
  cutting::ImmersionKind kind;
  double radial_depth_mm;
};

class TiltedCut : public testing::TestWithParam<TiltedCase> {};

/// Cuts along x of the turned frame; mean force on the tool, in that frame, and what was removed a
/// way. 20 voxels a radius.
struct Measured {
  Vector3 force_B = Vector3::Zero();
  double area = 0.0;  ///< volume over way, m²
};
Measured measure(const Turned& turned, const TiltedCase& of, const cutting::Condition& condition) {
  const double spacing = of.cutter.radius / 20.0;
  const int side = of.kind == cutting::ImmersionKind::slot ? 0
                   : of.kind == cutting::ImmersionKind::up ? -1
                                                           : 1;
  // Finished wall at +y after up-milling, at -y after down-milling: bone from there inwards.
  const double inner = of.cutter.radius - of.radial_depth_mm * mm;
  Stock stock = slab(turned, Vector3::Constant(6.5 * mm), spacing, side == 0 ? 0 : -side,
                     side < 0 ? inner : -inner);
  Remover remover(stock, of.cutter);
  const auto at = [&](double s) { return turned({s, 0.0, -of.depth_mm * mm}); };
  cut(remover, at(-2.5 * mm), at(0), 30);
  const PatchGrid patches = patches_for(of.cutter, spacing);
  const cutting::EngagedForce model(of.cutter, chip_and_rubbing_law(), patches.angles,
                                    patches.slices, patches.slice_height);
  Measured measured;
  const int steps = 60;
  for (int k = 0; k < steps; ++k) {
    measured.area += remover.step(at(0.3 * spacing * k), at(0.3 * spacing * (k + 1))).volume /
                     (0.3 * spacing * steps);
    const cutting::Load load = model.mean(remover.engagement(), condition);
    measured.force_B += turned.X.linear().transpose() * (remover.R_WT() * load.force) / steps;
  }
  return measured;
}

TEST_P(TiltedCut, GivesTheForcesAndTheVolumeOfTheNominalCut) {
  const TiltedCase& of = GetParam();
  const cutting::Condition condition{6000 * units::rpm, 0.03 * mm};
  const Measured askew_cut = measure(askew(), of, condition);
  const cutting::Immersion immersion{of.kind, of.radial_depth_mm * mm, of.depth_mm * mm};
  const Vector3 exact =
      cutting::mean_load(of.cutter, chip_and_rubbing_law(), condition, immersion).force;
  // The platform's marks at 20 voxels a radius: 1 % of the force, 0.3 % of the volume.
  EXPECT_LT((askew_cut.force_B - exact).norm(), 0.01 * exact.norm());
  const double d = of.depth_mm * mm;
  EXPECT_NEAR(askew_cut.area / (of.radial_depth_mm * mm * d), 1.0, 3e-3);
}

INSTANTIATE_TEST_SUITE_P(Table, TiltedCut,
                         testing::Values(TiltedCase{"cylinder_half_up", cylinder(4 * mm), 3.0,
                                                    cutting::ImmersionKind::up, 2.0},
                                         TiltedCase{"cylinder_half_down", cylinder(4 * mm), 3.0,
                                                    cutting::ImmersionKind::down, 2.0}),
                         [](const auto& of) { return of.param.name; });

TEST(PosedRemoval, OfATiltedBallInAFlatIsThatOfTheUprightOne) {
  // A ball 1 mm deep under a flat cuts the same groove at any tilt that keeps its shank clear.
  const double spacing = 0.2 * mm, R = 4 * mm, d = 1 * mm;
  const double section = R * R * std::acos(1.0 - d / R) - (R - d) * std::sqrt(2.0 * R * d - d * d);
  for (const Vector3& axis : {Vector3(Vector3::UnitZ()), tilted(0.4, 0.0), tilted(-0.3, 0.5)}) {
    Stock stock =
        block({-9 * mm, -5 * mm, -3 * mm}, {9 * mm, 5 * mm, 0}, {1900.0, 1.0}, spacing, 1 * mm);
    Remover remover(stock, ball(2.0 * R));
    // The centre lies R above the lowest point, the tip R along the axis below the centre.
    const auto at = [&](double x) -> ToolPose {
      return {Vector3(x, 0.13 * mm, R - d) - R * axis, axis};
    };
    cut(remover, at(-4 * mm), at(-3 * mm), 5);
    const double groove = cut(remover, at(-3 * mm), at(3 * mm), 30).volume;
    EXPECT_NEAR(groove / (section * 6 * mm), 1.0, 3e-3) << axis.transpose();
  }
}

TEST(PosedRemoval, OfASwingIsTheSectorOfItsPlane) {
  // The guide: the axis lies in the cutting plane and points at a pivot. From an angle on the tip
  // sweeps a sector of a ring between the bone's edge (a circle about the pivot) and the tip's arc,
  // as thick as the cutter.
  const double spacing = 0.3 * mm, R = 3 * mm, edge = 22 * mm, tip = 30 * mm;
  Stock stock(
      cubes_over({0, -22 * mm, -5 * mm}, {34 * mm, 22 * mm, 5 * mm}, spacing),
      [&](const Vector3& p) { return BoneSample{edge - std::hypot(p.x(), p.y()), {1900.0, 1.0}}; });
  Remover remover(stock, cylinder(2.0 * R));
  const auto at = [&](double angle) -> ToolPose {
    const Vector3 out(std::cos(angle), std::sin(angle), 0.0);
    return {tip * out, -out};
  };
  double volume = 0.0;
  for (int k = 0; k < 100; ++k) {
    const double from = -0.6 + 0.01 * k;
    const double part = remover.step(at(from), at(from + 0.01)).volume;
    if (k >= 30) volume += part;
  }
  // From -0.3 to 0.4 rad. Rings about the pivot go, as wide as the angle: from the edge to the
  // circle of the flat end's corners, which at the height z over the plane are sqrt(R² - z²) beside
  // the axis.
  double expected = 0.0;
  const int n = 2000;
  for (int k = 0; k < n; ++k) {
    const double z = R * (2.0 * (k + 0.5) / n - 1.0);
    expected += 2.0 * R / n * 0.5 * (tip * tip + R * R - z * z - edge * edge) * 0.7;
  }
  EXPECT_NEAR(volume / expected, 1.0, 3e-3);
}

struct PosedSplit {
  const char* name;
  cutting::Cutter cutter;
  ToolPose from, to;
};

class PosedSplitting : public testing::TestWithParam<PosedSplit> {};

TEST_P(PosedSplitting, APathInOneTenOrAThousandPiecesLeavesTheSameStock) {
  const Stock whole =
      block({0, 0, -8 * mm}, {16 * mm, 12 * mm, 0}, {1900.0, 1.0}, 0.4 * mm, 0.4 * mm);
  const auto after = [&](int pieces) {
    Stock stock = whole;
    Remover remover(stock, GetParam().cutter);
    cut(remover, GetParam().from, GetParam().to, pieces);
    return stock;
  };
  const Stock one = after(1);
  EXPECT_LT(one.remaining_units(), one.initial_units());
  for (int pieces : {10, 1000}) {
    const Stock many = after(pieces);
    // Turning: the bound on the swept surface. Not turning: the search's end.
    const bool turns = angle_between(GetParam().from.axis_W, GetParam().to.axis_W) > 0.0;
    EXPECT_LE(difference(one, many).largest, turns ? PoseSwath::kError : 2.0 / Stock::kFull);
    EXPECT_NEAR(many.remaining_volume(), one.remaining_volume(),
                1e-4 * (one.initial_volume() - one.remaining_volume()));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Table, PosedSplitting,
    testing::Values(PosedSplit{"tilted_cylinder",
                               cylinder(4 * mm),
                               {{-3 * mm, 2 * mm, -3 * mm}, tilted(0.3, 0.2)},
                               {{11 * mm, 7.3 * mm, -4 * mm}, tilted(0.3, 0.2)}},
                    PosedSplit{"tilted_ball",
                               ball(5 * mm),
                               {{-3 * mm, 2 * mm, -3 * mm}, tilted(-0.4, 0.9)},
                               {{11 * mm, 7.3 * mm, -3 * mm}, tilted(-0.4, 0.9)}},
                    PosedSplit{"lying_bull",
                               bull(5 * mm, 1 * mm),
                               {{14 * mm, -3 * mm, -2 * mm}, Vector3::UnitX()},
                               {{12 * mm, 9 * mm, -4 * mm}, Vector3::UnitX()}},
                    PosedSplit{"turning_cylinder",
                               cylinder(4 * mm),
                               {{2 * mm, 2 * mm, 1 * mm}, tilted(0.0, 0.0)},
                               {{11 * mm, 7.3 * mm, -5 * mm}, tilted(0.5, 0.4)}},
                    PosedSplit{"turning_ball",
                               ball(5 * mm),
                               {{-3 * mm, 2 * mm, -3 * mm}, tilted(-0.6, 0.2)},
                               {{11 * mm, 7.3 * mm, -4 * mm}, tilted(0.5, 0.4)}}),
    [](const auto& of) { return of.param.name; });

TEST(PosedRemoval, BalancesToTheLastUnit) {
  Stock stock = tibia_section({}, 0.4 * mm, 1 * mm);
  const double mass_before = stock.remaining_mass();
  const std::int64_t units_before = stock.remaining_units();
  Remover remover(stock, ball(8 * mm));
  const Removal sum = cut(remover, {{-6 * mm, 3 * mm, -4 * mm}, tilted(0.2, -0.3)},
                          {{30 * mm, 7 * mm, -6 * mm}, tilted(-0.3, 0.4)}, 123);
  EXPECT_GT(sum.volume, 100 * units::mm3);
  const std::int64_t removed = std::llround((sum.volume + sum.buried_volume) / stock.unit_volume());
  EXPECT_EQ(stock.remaining_units() + removed, units_before);
  EXPECT_EQ(sum.buried_volume, 0.0);
  EXPECT_NEAR(stock.remaining_mass() + sum.mass, mass_before, 1e-12 * mass_before);
}

TEST(PosedRemoval, GivesAPatchThatMovesSlowerItsThinnerChip) {
  // A cylinder in full cut that swings about a pivot on its axis: at height z the feed is 1 - z/L
  // of the tip's. The share in contact is 1 there all the same, and the mean force is the integral
  // of the slot's over heights, each with its own chip.
  const double spacing = 0.15 * mm, R = 3 * mm, L = 30 * mm, deep = 6 * mm;
  Stock stock(cubes_over({L - deep, -14 * mm, -4 * mm}, {L + 1 * mm, 14 * mm, 4 * mm}, spacing),
              [&](const Vector3& p) {
                return BoneSample{L - deep - std::hypot(p.x(), p.y()), {1900.0, 1.0}};
              });
  const cutting::Cutter cutter = cylinder(2.0 * R);
  Remover remover(stock, cutter);
  const auto at = [&](double angle) -> ToolPose {
    const Vector3 out(std::cos(angle), std::sin(angle), 0.0);
    return {L * out, -out};
  };
  cut(remover, at(-0.38), at(0.0), 40);
  const PatchGrid patches = patches_for(cutter, spacing);
  const cutting::EngagedForce model(cutter, chip_and_rubbing_law(), patches.angles, patches.slices,
                                    patches.slice_height);
  cutting::Condition condition{6000 * units::rpm, 0.03 * mm};
  Vector3 force = Vector3::Zero();
  double contact = 0.0;
  const int steps = 40;
  const double turn = 0.3 * spacing / L;
  for (int k = 0; k < steps; ++k) {
    remover.step(at(turn * k), at(turn * (k + 1)));
    condition.turn_T = remover.motion().turn_T;
    force += model.mean(remover.engagement(), condition).force / steps;
    contact += model.edge_in_bone(remover.engagement()) / steps;
  }
  Vector3 exact = Vector3::Zero();
  const int n = 60;
  for (int k = 0; k < n; ++k) {
    cutting::Condition here = condition;
    here.turn_T = Vector3::Zero();
    here.feed_per_tooth *= 1.0 - deep * (k + 0.5) / n / L;
    exact += cutting::mean_load(cutter, chip_and_rubbing_law(), here,
                                {cutting::ImmersionKind::slot, 0.0, deep / n})
                 .force;
  }
  EXPECT_NEAR(std::abs(remover.motion().turn_T.y()), 1.0 / L, 1e-3 / L);
  EXPECT_LT((force - exact).norm(), 0.01 * exact.norm());
  // Two flutes, half of each turn in bone: the length of one edge.
  EXPECT_NEAR(contact / (cutter.flutes * 0.5 * deep), 1.0, 0.01);
}

TEST(PosedRemoval, CountsWhatATurnInPlaceMeetsAsBuried) {
  Stock stock = block({0, 0, -8 * mm}, {16 * mm, 12 * mm, 0}, {1900.0, 1.0}, 0.4 * mm, 2 * mm);
  Remover remover(stock, cylinder(4 * mm));
  const ToolPose down{{8 * mm, 6 * mm, -2 * mm}};
  remover.step(ToolPose{{8 * mm, 6 * mm, 1 * mm}}, down);
  const Removal turned = remover.step(down, {down.tip_W, tilted(0.4, 0.0)});
  EXPECT_EQ(turned.volume, 0.0);
  EXPECT_GT(turned.buried_volume, 0.0);
}

TEST(PosedRemoval, AlongTheSwingOfTheGuideKnowsWhereItIsInBone) {
  Swing swing;
  swing.pivot_W = {-25 * mm, 0.0, -3 * mm};
  swing.first_angle = -30 * units::deg;
  swing.last_angle = 30 * units::deg;
  swing.first_insertion = 20 * mm;
  swing.last_insertion = 34 * mm;
  swing.advance = 7 * mm;
  const ToolPath path = swing_and_advance(swing, {5e-3, 600.0});
  const Stock stock =
      block({0, -8 * mm, -8 * mm}, {16 * mm, 8 * mm, 2 * mm}, {1900.0, 1.0}, 0.8 * mm, 0.8 * mm);
  const ContactMap contact(stock, cylinder(6 * mm), path);
  EXPECT_GT(contact.removed_volume(), 300 * units::mm3);
  // The first swing, 20 mm beyond a pivot 25 mm before the bone, meets nothing.
  EXPECT_GT(contact.first_contact(), path.end_of(0));
}

}  // namespace
}  // namespace osteomill::workpiece
