// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/cut_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/remover.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;
constexpr double kSpacing = 0.25 * mm;

geometry::GridShape grid() {
  return cubes_over({-6 * mm, -6 * mm, -5 * mm}, {6 * mm, 6 * mm, 3 * mm}, kSpacing);
}
Stock cut_by(const std::function<double(const Vector3&)>& distance) {
  return Stock(grid(), [&](const Vector3& p) {
    const double block =
        std::max({std::abs(p.x()) - 5 * mm, std::abs(p.y()) - 5 * mm, p.z() - 2 * mm});
    return BoneSample{std::max(block, distance(p)), {1000.0, 1.0}};
  });
}
Stock whole() {
  return cut_by([](const Vector3&) { return -1.0; });
}

TEST(CutSurface, LiesOnAPlaneAtAnyTiltAndHeight) {
  const Stock before = whole();
  for (const double tilt : {0.0, 0.5, 3.0, 7.0, 20.0, 45.0})
    for (const double height : {0.0, 0.06, 0.125, 0.2}) {
      const double a = tilt * units::deg;
      const Vector3 n(std::sin(a) * 0.8, std::sin(a) * 0.6, std::cos(a));
      const Stock after = cut_by([&](const Vector3& p) { return n.dot(p) - height * mm; });
      const std::vector<CutPoint> points = cut_surface(before, after);
      // A point for each voxel of the surface; the rim goes.
      EXPECT_GT(points.size(), 0.8 * 10 * 10 * mm * mm / (kSpacing * kSpacing));
      for (const CutPoint& point : points)
        ASSERT_NEAR(n.dot(point.p_W), height * mm, 0.01 * kSpacing) << tilt << " " << height;
    }
}

TEST(CutSurface, OfABallPassIsThatBall) {
  Stock stock = whole();
  const Stock before = stock;
  cutting::Cutter ball;
  ball.shape = cutting::CutterShape::ball;
  ball.radius = 3 * mm;
  ball.cutting_length = 6 * mm;
  Remover remover(stock, ball);
  remover.step({-10 * mm, 0.03 * mm, 0.5 * mm}, {10 * mm, 0.03 * mm, 0.5 * mm});
  const std::vector<CutPoint> points = cut_surface(before, stock);
  ASSERT_GT(points.size(), 500U);
  for (const CutPoint& point : points) {
    const double radius = std::hypot(point.p_W.y() - 0.03 * mm, point.p_W.z() - 3.5 * mm);
    // The normal's error over half a voxel, and h²/8r between the voxel's centre and its surface.
    EXPECT_NEAR(radius, 3 * mm, 0.02 * kSpacing);
  }
}

TEST(CutSurface, IsNothingWhereNothingWasCut) {
  const Stock stock = whole();
  EXPECT_TRUE(cut_surface(stock, stock).empty());
  const Stock other = block({0, 0, 0}, {mm, mm, mm}, {1000.0, 1.0}, kSpacing);
  EXPECT_THROW(cut_surface(stock, other), InvalidInput);
}

}  // namespace
}  // namespace osteomill::workpiece
