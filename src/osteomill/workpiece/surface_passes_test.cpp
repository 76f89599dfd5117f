// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/surface_passes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;
using units::um;

const CutSettings kCut{3e-3, 628.0};

SurfacePasses cup() {
  SurfacePasses passes;
  passes.keep = outside(ball({0, 0, 0}, 20 * mm));
  passes.lower = {-10 * mm, -10 * mm};
  passes.upper = {10 * mm, 10 * mm};
  passes.top = 1 * mm;
  passes.bottom = -25 * mm;
  passes.ball_radius = 4 * mm;
  passes.scallop = 50 * um;
  passes.clearance_z = 5 * mm;
  passes.sample = 1 * mm;
  return passes;
}

/// Points of each pass.
std::vector<std::vector<Vector3>> passes_of(const ToolPath& path) {
  std::vector<std::vector<Vector3>> passes;
  for (const Move& move : path.moves())
    if (move.kind == MoveKind::cut && move.points_W.size() > 2) passes.push_back(move.points_W);
  return passes;
}

TEST(Scallop, StepAndHeightAreInverse) {
  for (double h : {1 * um, 20 * um, 500 * um})
    EXPECT_NEAR(scallop_height(4 * mm, step_over_for(4 * mm, h)), h, 1e-9 * mm);
  EXPECT_DOUBLE_EQ(scallop_height(4 * mm, 8 * mm), 4 * mm);
  // Small steps: s²/8R.
  EXPECT_NEAR(scallop_height(4 * mm, 0.1 * mm) / (0.01 / 32 * mm), 1.0, 1e-3);
  EXPECT_THROW(step_over_for(4 * mm, 5 * mm), InvalidInput);
  EXPECT_THROW(scallop_height(4 * mm, 9 * mm), InvalidInput);
}

TEST(SurfacePasses, RollTheBallOnTheSurface) {
  for (const auto& pass : passes_of(surface_passes(cup(), kCut)))
    for (std::size_t i = 1; i < pass.size(); ++i) {
      const Vector3 centre = pass[i] + 4 * mm * Vector3::UnitZ();
      // Let down to within half a micrometre.
      EXPECT_NEAR(centre.norm(), 16 * mm, 1e-6);
    }
}

TEST(SurfacePasses, LeaveRidgesBelowTheirLimitOnConcaveAndConvexSurfaces) {
  SurfacePasses dome = cup();
  dome.keep = ball({0, 0, -20 * mm}, 20 * mm);
  for (const SurfacePasses& surface : {cup(), dome}) {
    const bool concave = surface.keep({0, 0, 0}) > 0.0;
    const double rho = concave ? 16 * mm : 24 * mm;  // of the centres of the ball
    std::vector<std::vector<Vector3>> passes = passes_of(surface_passes(surface, kCut));
    ASSERT_GT(passes.size(), 10u);
    double highest = 0.0;
    for (std::size_t n = 1; n < passes.size(); ++n) {
      // Neighbours run against each other; the first point of a pass is the last of the one before.
      const Vector3 a = passes[n - 1][passes[n - 1].size() / 2] + 4 * mm * Vector3::UnitZ();
      Vector3 b = passes[n].back();
      for (const Vector3& p : passes[n])
        if (std::abs(p.x() - a.x()) < std::abs(b.x() - a.x())) b = p;
      b += 4 * mm * Vector3::UnitZ();
      // Two balls of 4 mm at this distance: their intersection stands above the surface by h.
      const double half = 0.5 * (a - b).norm();
      const double out = std::sqrt(rho * rho - half * half);
      const double ridge = std::sqrt(16 * mm * mm - half * half);
      highest = std::max(highest, concave ? 20 * mm - out - ridge : out - ridge - 20 * mm);
    }
    EXPECT_LE(highest, 50 * um);
    EXPECT_GT(highest, 25 * um) << "far finer than it has to be";
  }
}

TEST(SurfacePasses, RefuseAnAreaWithoutExtent) {
  SurfacePasses surface = cup();
  surface.upper.x() = surface.lower.x();
  EXPECT_THROW(surface_passes(surface, kCut), InvalidInput);
  surface = cup();
  surface.clearance_z = 0.0;
  EXPECT_THROW(surface_passes(surface, kCut), InvalidInput);
}

}  // namespace
}  // namespace osteomill::workpiece
