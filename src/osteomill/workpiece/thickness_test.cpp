// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/thickness.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;

/// A ball of 12 mm with a shell.
Stock shelled(double shell) {
  return Stock(cubes_over(Vector3::Constant(-14 * mm), Vector3::Constant(14 * mm), 0.4 * mm),
               [shell](const Vector3& p) {
                 const double d = p.norm() - 12 * mm;
                 return BoneSample{d, {d > -shell ? 1900.0 : 300.0, 1.0}};
               });
}

TEST(CorticalThickness, IsThatOfTheShell) {
  for (double shell : {1.5 * mm, 3 * mm}) {
    const CorticalThickness thickness = cortical_thickness(shelled(shell));
    // Half a voxel.
    EXPECT_NEAR(thickness.median, shell, 0.2 * mm);
    EXPECT_NEAR(thickness.p5, shell, 0.4 * mm);
    EXPECT_NEAR(thickness.p95, shell, 0.4 * mm);
    EXPECT_GT(thickness.share, 0.99);
  }
}

TEST(CorticalThickness, LeavesOutLoneVoxels) {
  // As the streaks around metal make them: dense, with nothing beside them that says what is
  // inside.
  const Vector3 centre = Vector3::Constant(0.2 * mm);
  const Stock speck(
      cubes_over(Vector3::Constant(-2 * mm), Vector3::Constant(2 * mm), 0.4 * mm),
      [&](const Vector3& p) { return BoneSample{(p - centre).norm(), {1900.0, 1.0}}; });
  ASSERT_GT(speck.occupancy(5, 5, 5), 0.25);
  ASSERT_LT(speck.occupancy(5, 5, 5), 0.75);
  EXPECT_EQ(cortical_thickness(speck).places, 0u);
}

/// A share of a step seen by a scanner whose point spread has this standard deviation.
double blurred(double distance, double sigma) {
  return 0.5 * (1.0 + std::erf(distance / (std::sqrt(2.0) * sigma)));
}

TEST(CorticalThickness, IsThatOfAShellThatAScannerBlurs) {
  // 1900 kg/m³ over 300, blurred by 0.5 mm; bone is what reaches 450 kg/m³, 300 HU.
  const double sigma = 0.5 * mm;
  for (double shell : {2 * mm, 3 * mm, 5 * mm}) {
    const auto density = [&](double depth) {
      return 1900.0 * blurred(depth, sigma) - 1600.0 * blurred(depth - shell, sigma);
    };
    double border = -2 * mm;  // depth of the surface by that threshold
    while (density(border) < 450.0) border += 1e-6;
    const Stock stock(cubes_over(Vector3::Constant(-14 * mm), Vector3::Constant(14 * mm), 0.4 * mm),
                      [&](const Vector3& p) {
                        const double depth = 12 * mm - p.norm();
                        return BoneSample{border - depth,
                                          {std::round(std::max(1.0, density(depth))), 1.0}};
                      });
    const CorticalThickness thickness = cortical_thickness(stock);
    // Both ends lie within 0.4 mm of the half of the step; half a voxel beside.
    EXPECT_NEAR(thickness.median, shell, 0.6 * mm) << shell;
    EXPECT_NEAR(thickness.p95, thickness.p5, 0.6 * mm);
    EXPECT_GT(thickness.share, 0.99);
  }
}

TEST(CorticalThickness, IsNothingWithoutCorticalBone) {
  const CorticalThickness thickness = cortical_thickness(shelled(-1 * mm));
  EXPECT_EQ(thickness.places, 0u);
  EXPECT_EQ(thickness.median, 0.0);
}

}  // namespace
}  // namespace osteomill::workpiece
