// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/accuracy/plate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::accuracy {
namespace {

std::vector<SurfacePoint> grid(double (*height)(double, double)) {
  std::vector<SurfacePoint> points;
  for (int i = -10; i <= 10; ++i) {
    for (int k = -10; k <= 10; ++k) {
      points.push_back({0.002 * i, 0.003 * k, height(0.002 * i, 0.003 * k)});
    }
  }
  return points;
}

TEST(Plate, OnAPlaneTakesItsAngles) {
  const auto points = grid([](double x, double y) { return 1e-4 + 0.01 * x - 0.02 * y; });
  for (const PlatePose& pose : {resting_plate(points), fitted_plate(points)}) {
    EXPECT_NEAR(pose.offset, 1e-4, 1e-12);
    EXPECT_NEAR(pose.varus_valgus, std::atan(-0.02), 1e-9);
    EXPECT_NEAR(pose.flexion_extension, -std::atan(0.01), 1e-9);
    EXPECT_NEAR(pose.largest_gap, 0.0, 1e-12);
    EXPECT_DOUBLE_EQ(pose.share_tight, 1.0);
  }
}

TEST(Plate, RestsAboveEveryPointAndTouchesThree) {
  Random random(7);
  std::vector<SurfacePoint> points;
  for (int i = 0; i < 400; ++i) {
    points.push_back(
        {random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03), random.normal(0.0, 1e-4)});
  }
  const PlatePose pose = resting_plate(points);
  int touching = 0;
  double height_at_middle = 0.0, mx = 0.0, my = 0.0;
  for (const SurfacePoint& p : points) {
    const double gap = pose.offset + pose.slope_x * p.x + pose.slope_y * p.y - p.height;
    EXPECT_GE(gap, -1e-11);
    touching += gap < 1e-10;
    mx += p.x / 400.0;
    my += p.y / 400.0;
  }
  EXPECT_EQ(touching, 3);
  height_at_middle = pose.offset + pose.slope_x * mx + pose.slope_y * my;
  // No other plane above the points is lower at the middle: tilting about the touching points only
  // lifts it.
  for (const double tilt : {-1e-3, 1e-3}) {
    double lift = -1.0;
    for (const SurfacePoint& p : points) {
      lift =
          std::max(lift, p.height - (pose.slope_x + tilt) * (p.x - mx) - pose.slope_y * (p.y - my));
    }
    EXPECT_GE(lift, height_at_middle - 1e-12);
  }
}

TEST(Plate, RidgeAtOneEndTiltsIt) {
  // Bone left at the back (−x), as open guides do: the plate comes to lie flexed.
  const auto points = grid([](double x, double) { return x < -0.019 ? 5e-4 : 0.0; });
  const PlatePose pose = resting_plate(points);
  EXPECT_NEAR(pose.flexion_extension, std::atan(5e-4 / 0.04), 1e-6);
  EXPECT_NEAR(pose.varus_valgus, 0.0, 1e-9);
  EXPECT_GT(pose.largest_gap, 4e-4);
  EXPECT_LT(pose.share_tight, 0.9);
}

TEST(Plate, OppositeFeedsOnTheTwoSidesMakeVarus) {
  // Milling outwards from the middle: bone left on one side, taken on the other (§4.5.2).
  SurfaceError left{.axial_position = {0.0, 0.02, 0.04}, .error = {2e-4, 2e-4, 2e-4}};
  SurfaceError right = left;
  for (double& e : right.error) e = -e;
  const auto points =
      milled_surface({{.y_from = 0.0, .y_to = 0.03, .error = left, .tip_x = -0.02},
                      {.y_from = 0.0, .y_to = -0.03, .error = right, .tip_x = -0.02}});
  EXPECT_GT(fitted_plate(points).varus_valgus, 0.0);
  EXPECT_NEAR(fitted_plate(points).flexion_extension, 0.0, 1e-12);
}

TEST(Plate, NeedsAnArea) {
  EXPECT_THROW(resting_plate({{0, 0, 0}, {1, 0, 0}}), InvalidInput);
  EXPECT_THROW(fitted_plate({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {3, 3, 0}}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::accuracy
