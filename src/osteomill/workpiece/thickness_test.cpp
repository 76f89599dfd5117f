// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/thickness.hpp"

#include <gtest/gtest.h>

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

TEST(CorticalThickness, IsNothingWithoutCorticalBone) {
  const CorticalThickness thickness = cortical_thickness(shelled(-1 * mm));
  EXPECT_EQ(thickness.places, 0u);
  EXPECT_EQ(thickness.median, 0.0);
}

}  // namespace
}  // namespace osteomill::workpiece
