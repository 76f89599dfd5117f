// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/no_go.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/area_paths.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;

const CutSettings kCut{3e-3, 628.0};
constexpr double kPrecision = 10e-6;  // of nearest_approach, m

cutting::Cutter cylinder() {
  cutting::Cutter cutter;
  cutter.radius = 3 * mm;
  cutter.cutting_length = 10 * mm;
  return cutter;
}

ToolPath pass() { return line({-20 * mm, 0, 0}, {20 * mm, 0, 0}, kCut); }

TEST(NearestApproach, IsThatOfAnalyticCases) {
  struct Case {
    NoGo region;
    double distance;
  };
  const std::vector<Case> cases = {
      // Beside the wall, 5 mm up.
      {no_go_ball("wall", Vector3(7, 10, 5) * mm, 2 * mm, 0), 10 * mm - 3 * mm - 2 * mm},
      // Below the flat end.
      {no_go_ball("floor", Vector3(1, 1, -6) * mm, 2 * mm, 0), 6 * mm - 2 * mm},
      // Past the end of the pass and below: the rim of the end is nearest.
      {no_go_ball("rim", Vector3(27, 0, -3) * mm, 1 * mm, 0), 5 * mm - 1 * mm},
      // High above: the shank goes on without end.
      {no_go_ball("shank", Vector3(0, -9, 200) * mm, 1 * mm, 0), 9 * mm - 3 * mm - 1 * mm},
      // A face along the pass, an edge across it, and one that the tool goes through.
      {no_go_box("face", Vector3(-5, 4, -3) * mm, Vector3(5, 9, 3) * mm, 0), 1 * mm},
      {no_go_box("below", Vector3(-5, -9, -9) * mm, Vector3(5, 9, -2.5) * mm, 0), 2.5 * mm},
  };
  for (const Case& one : cases)
    EXPECT_NEAR(nearest_approach(pass(), cylinder(), one.region).distance, one.distance, kPrecision)
        << one.region.name;
  EXPECT_LE(
      nearest_approach(pass(), cylinder(),
                       no_go_box("through", Vector3(-5, -9, -3) * mm, Vector3(5, 9, 3) * mm, 0))
          .distance,
      0.0);
}

TEST(NearestApproach, CountsTheAxisThatTheToolHas) {
  // Lying along -x, its tip at the origin: a ball beside its shank, and one past its tip.
  Move move{MoveKind::cut, {Vector3(0, 0, 0), Vector3(0, 0, 1 * mm)}, 3e-3, 628.0, 1, {}};
  move.axes_W = {-Vector3::UnitX(), -Vector3::UnitX()};
  const ToolPath path({move});
  EXPECT_NEAR(
      nearest_approach(path, cylinder(), no_go_ball("a", Vector3(-30, 0, 10) * mm, 1 * mm, 0))
          .distance,
      10 * mm - 1 * mm - 3 * mm - 1 * mm, kPrecision);
  EXPECT_NEAR(nearest_approach(path, cylinder(), no_go_ball("b", Vector3(8, 0, 0) * mm, 1 * mm, 0))
                  .distance,
              7 * mm, kPrecision);
}

TEST(NearestApproach, DoesNotDependOnHowThePathIsCutUp) {
  const NoGo region = no_go_box("box", Vector3(2, 5, -8) * mm, Vector3(6, 9, -1) * mm, 0);
  Move pieces{MoveKind::cut, {}, 3e-3, 628.0, 1, {}};
  for (int k = 0; k <= 37; ++k) pieces.points_W.emplace_back(-20 * mm + 40 * mm * k / 37, 0.0, 0.0);
  EXPECT_NEAR(nearest_approach(ToolPath({pieces}), cylinder(), region).distance,
              nearest_approach(pass(), cylinder(), region).distance, kPrecision);
}

TEST(NearestApproach, ToAHalfSpaceIsThatToItsPlane) {
  const auto distance = [](const Vector3& point, const Vector3& normal) {
    return nearest_approach(pass(), cylinder(), no_go_half_space("half", point, normal, 0))
        .distance;
  };
  // Beside the pass, below it, and askew in front of its end; 32-bit corners a metre away.
  const double precision = kPrecision + 1e-7;
  EXPECT_NEAR(distance(Vector3(0, 7, 0) * mm, Vector3::UnitY()), 7 * mm - 3 * mm, precision);
  EXPECT_NEAR(distance(Vector3(0, 0, -2) * mm, -Vector3::UnitZ()), 2 * mm, precision);
  const Vector3 n = Vector3(1, 0, -1).normalized();
  EXPECT_NEAR(distance(Vector3(40, 0, 0) * mm, n), (40 - 23) * mm / std::sqrt(2.0), precision);
  // The tool is in it, or its shank comes into it higher up.
  EXPECT_LE(distance(Vector3(0, -50, 0) * mm, Vector3::UnitY()), 0.0);
  EXPECT_LE(distance(Vector3(0, 0, 60) * mm, Vector3::UnitZ()), 0.0);
  EXPECT_THROW(no_go_half_space("none", Vector3::Zero(), Vector3::Zero(), 0), InvalidInput);
}

TEST(Forbidden, ByAHalfSpaceIsWhereItRisesAboveTheTip) {
  // Rises with x: at the tip's height from x = 5 mm on, less radius and margin.
  const NoGo slope = no_go_half_space("slope", Vector3(5, 0, 0) * mm, Vector3(1, 0, -1), 1 * mm);
  const Outline all = rectangle({-30 * mm, -20 * mm}, {30 * mm, 20 * mm});
  const Outline left = without(all, forbidden(slope, cylinder(), 0.0));
  double most = -1.0;
  for (const Polygon& polygon : left.polygons)
    for (const Vector2& p : polygon) most = std::max(most, p.x());
  // What lies within the margin below the tip counts too; a hundredth of a millimetre to spare.
  EXPECT_NEAR(most, (5 - 1 - 3 - 1 - 0.01) * mm, 1e-6);
}

TEST(AreaPaths, LeaveOutAtEachLevelWhatIsInTheWayThere) {
  // A step: the region reaches -2 mm, above that it is in nobody's way.
  const NoGo low = no_go_box("low", Vector3(10, -30, -9) * mm, Vector3(40, 30, -2) * mm, 0.5 * mm);
  AreaCut cut;
  cut.outline = rectangle({-30 * mm, -20 * mm}, {30 * mm, 20 * mm});
  cut.levels = {-1 * mm, -4 * mm};
  cut.step_over = 2 * mm;
  cut.clearance_z = 10 * mm;
  for (const double level : cut.levels)
    cut.outline_at.push_back(without(cut.outline, forbidden(low, cylinder(), level)));
  for (const ToolPath& path : {raster(cut, {0.0, true}, kCut), contour_parallel(cut, true, kCut)}) {
    EXPECT_NO_THROW(check_no_go(path, cylinder(), {low}));
    double upper = -1.0, lower = -1.0;
    for (const Move& move : path.moves())
      for (const Vector3& p : move.points_W) {
        if (p.z() < -3 * mm) lower = std::max(lower, p.x());
        if (p.z() < 0.0) upper = std::max(upper, p.x());
      }
    EXPECT_NEAR(upper, 30 * mm, 2.1 * mm);  // a step over
    EXPECT_NEAR(lower, (10 - 3 - 0.5) * mm, 2.1 * mm);
  }
}

TEST(NoGo, NamesEveryRegionThatThePathEntersWithPlaceAndDepth) {
  const std::vector<NoGo> regions = {
      no_go_ball("vessel", Vector3(7, 6, 5) * mm, 2 * mm, 2 * mm),
      no_go_ball("far", Vector3(7, 40, 5) * mm, 2 * mm, 2 * mm),
      no_go_box("ligament", Vector3(-5, -9, -3) * mm, Vector3(5, -2, 3) * mm, 1 * mm)};
  try {
    check_no_go(pass(), cylinder(), regions);
    FAIL();
  } catch (const InvalidInput& error) {
    ASSERT_EQ(error.faults().size(), 2u);
    EXPECT_EQ(error.faults()[0].field, "no_go.vessel");
    EXPECT_THAT(error.faults()[0].value, testing::HasSubstr("within 1.00 mm"));
    EXPECT_THAT(error.faults()[0].value, testing::HasSubstr("tip near (7.00, 0.00, 0.00) mm"));
    EXPECT_THAT(error.faults()[0].rule, testing::HasSubstr("1.00 mm are missing"));
    EXPECT_EQ(error.faults()[1].field, "no_go.ligament");
  }
  EXPECT_EQ(check_no_go(pass(), cylinder(), {regions[1]}).size(), 1u);
}

TEST(Forbidden, LeavesAPathThatKeepsTheMargin) {
  const NoGo ball = no_go_ball("ball", Vector3(4, 3, 2) * mm, 3 * mm, 1.5 * mm);
  const NoGo box = no_go_box("box", Vector3(-30, -14, -8) * mm, Vector3(-10, 4, 30) * mm, 2 * mm);
  AreaCut cut;
  cut.outline = rectangle({-30 * mm, -20 * mm}, {30 * mm, 20 * mm});
  for (const NoGo& region : {ball, box})
    cut.outline = without(cut.outline, forbidden(region, cylinder(), -4 * mm));
  cut.levels = {-4 * mm};
  cut.step_over = 2 * mm;
  cut.clearance_z = 40 * mm;
  EXPECT_NO_THROW(check_no_go(raster(cut, {0.3, true}, kCut), cylinder(), {ball, box}));
  EXPECT_NO_THROW(check_no_go(contour_parallel(cut, true, kCut), cylinder(), {ball, box}));
  // What lies below the tip forbids nothing.
  EXPECT_TRUE(forbidden(ball, cylinder(), 8 * mm).empty());
}

TEST(Access, IsTheLeastGapInTheWindow) {
  const AccessWindow round{circle({0, 0}, 25 * mm), 10 * mm};
  // At the ends of the pass the axis is 20 mm from the middle.
  EXPECT_NEAR(check_access(pass(), cylinder(), round), 25 * mm - 20 * mm - 3 * mm, kPrecision);
  EXPECT_THROW(check_access(pass(), cylinder(), {circle({0, 0}, 22 * mm), 10 * mm}), InvalidInput);
  EXPECT_TRUE(std::isinf(check_access(pass(), cylinder(), {circle({0, 0}, 1 * mm), -1 * mm})));
}

/// A pass along y whose axis is the same all along.
ToolPath leaning(const Vector3& axis, double z = 0.0) {
  const Vector3 unit = axis.normalized();
  return ToolPath({{MoveKind::cut,
                    {Vector3(0, -5 * mm, z), Vector3(0, 5 * mm, z)},
                    3e-3,
                    628.0,
                    1,
                    {unit, unit}}});
}

TEST(Access, OfALeaningToolIsThatOfItsSectionWithTheWindow) {
  const double lean = 0.4, height = 10 * mm, radius = 3 * mm;
  const ToolPath path = leaning({std::sin(lean), 0.0, std::cos(lean)});
  // An ellipse around the place where the axis passes, long towards the lean.
  const double middle = height * std::tan(lean), half_length = radius / std::cos(lean);
  const auto window = [&](double low, double high, double side) {
    return AccessWindow{rectangle({low, -side}, {high, side}), height};
  };
  // Sides of the section every 5° of a radius of 3 mm: 3 µm of a rounding.
  EXPECT_NEAR(check_access(path, cylinder(), window(-40 * mm, 12 * mm, 40 * mm)),
              12 * mm - middle - half_length, kPrecision);
  EXPECT_NEAR(check_access(path, cylinder(), window(-2 * mm, 40 * mm, 40 * mm)),
              middle - half_length + 2 * mm, kPrecision);
  EXPECT_NEAR(check_access(path, cylinder(), window(-40 * mm, 40 * mm, 10 * mm)),
              10 * mm - 5 * mm - radius, kPrecision);
  // An upright tool would fit through this one.
  EXPECT_NO_THROW(
      check_access(leaning(Vector3::UnitZ()), cylinder(), window(-4 * mm, 4 * mm, 9 * mm)));
  EXPECT_THROW(check_access(path, cylinder(), window(-4 * mm, 4 * mm, 9 * mm)), InvalidInput);
}

TEST(Access, OfATinyLeanIsThatOfTheUprightTool) {
  const AccessWindow round{circle({0, 0}, 25 * mm), 10 * mm};
  EXPECT_NEAR(check_access(leaning({1e-6, 0.0, 1.0}), cylinder(), round),
              check_access(leaning(Vector3::UnitZ()), cylinder(), round), kPrecision);
}

TEST(Access, SeesTheRimThatALeaningToolDipsBelowTheWindow) {
  // With the tip 0.5 mm above, the rim of the flat end is 3 mm sin(lean) lower.
  const ToolPath path = leaning({std::sin(0.4), 0.0, std::cos(0.4)}, 10.5 * mm);
  const AccessWindow wide{circle({0, 0}, 25 * mm), 10 * mm};
  EXPECT_TRUE(std::isfinite(check_access(path, cylinder(), wide)));
  EXPECT_TRUE(std::isinf(
      check_access(leaning({std::sin(0.4), 0.0, std::cos(0.4)}, 12 * mm), cylinder(), wide)));
}

TEST(Access, RefusesAToolThatLiesInTheWindowAndIgnoresOneThatHangsBelow) {
  const AccessWindow wide{circle({0, 0}, 25 * mm), 10 * mm};
  EXPECT_THROW(check_access(leaning(Vector3::UnitX(), 9 * mm), cylinder(), wide), InvalidInput);
  EXPECT_TRUE(std::isinf(check_access(leaning(-Vector3::UnitZ()), cylinder(), wide)));
}

}  // namespace
}  // namespace osteomill::workpiece
