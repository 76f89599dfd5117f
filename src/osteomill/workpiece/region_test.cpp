// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/region.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/remover.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;

TEST(Region, DistancesAreThoseOfGeometry) {
  const Region cube = box(Vector3(-1, -1, -1), Vector3(1, 1, 1));
  EXPECT_DOUBLE_EQ(cube({0.5, 0, 0}), -0.5);
  EXPECT_DOUBLE_EQ(cube({4, 5, 0}), 5.0);
  const Region up = half_space({0, 0, 2}, {0, 0, 3});
  EXPECT_DOUBLE_EQ(up({5, 5, 3}), -1.0);
  EXPECT_DOUBLE_EQ(outside(up)({5, 5, 3}), 1.0);
  EXPECT_DOUBLE_EQ(ball({1, 0, 0}, 2.0)({1, 3, 0}), 1.0);
  // A prism over a square is a box, to the 10 nm of outlines.
  const Region column = prism(rectangle({-1e-2, -1e-2}, {1e-2, 1e-2}), -1e-2, 1e-2);
  const Region same = box(Vector3::Constant(-1e-2), Vector3::Constant(1e-2));
  for (const Vector3& p : {Vector3(2e-3, 1e-3, 0), Vector3(3e-2, 2e-2, 1.5e-2),
                           Vector3(0, 0, 1.2e-2), Vector3(9e-3, 0, -1.1e-2)})
    EXPECT_NEAR(column(p), same(p), 2e-8);
}

TEST(Region, UnionAndIntersectionKeepTheSide) {
  const Region two = any_of({ball({0, 0, 0}, 1.0), ball({3, 0, 0}, 1.0)});
  EXPECT_LT(two({3, 0.5, 0}), 0.0);
  EXPECT_GT(two({1.5, 0, 0}), 0.0);
  const Region lens = all_of({ball({0, 0, 0}, 2.0), ball({3, 0, 0}, 2.0)});
  EXPECT_LT(lens({1.5, 0, 0}), 0.0);
  EXPECT_GT(lens({0, 0, 0}), 0.0);
  EXPECT_THROW(any_of({}), InvalidInput);
}

TEST(Compare, BooksEveryVolumeOfACut) {
  const auto fresh = [] {
    return block({0, 0, -6 * mm}, {24 * mm, 16 * mm, 0}, {1900, 1}, 0.5 * mm, 2 * mm);
  };
  const Stock before = fresh();
  Stock after = fresh();
  cutting::Cutter cutter;
  cutter.radius = 3 * mm;
  cutter.cutting_length = 10 * mm;
  Remover remover(after, cutter);
  // A slot 6 mm wide and 4 mm deep where 6 mm and 3 mm were planned, over half the length.
  remover.step({-4 * mm, 8 * mm, -4 * mm}, {40 * mm, 8 * mm, -4 * mm});
  const Region plan = box(Vector3(-1, 5, -3) * mm, Vector3(12, 11, 1) * mm);
  const PlanResult result = compare(before, after, plan);
  const double mm3 = units::mm3;
  // Walls and floors lie on faces of voxels, where shares are exact to rounding.
  EXPECT_NEAR(result.planned_volume / mm3, 12 * 6 * 3, 0.1);
  EXPECT_NEAR(result.uncut_volume / mm3, 0.0, 0.1);
  EXPECT_NEAR(result.removed_volume / mm3, 12 * 6 * 3, 0.1);
  EXPECT_NEAR(result.over_cut_volume / mm3, 24 * 6 * 4 - 12 * 6 * 3, 0.1);
  // Removed in all = of the plan + beside it.
  EXPECT_NEAR(result.removed_volume + result.over_cut_volume,
              before.remaining_volume() - after.remaining_volume(), 1e-6 * mm3);
  // The farthest is at the far end, half a voxel inside the last face: 12 mm from the plan.
  EXPECT_NEAR(result.over_cut_depth, 11.5 * mm, 0.6 * mm);
  const PlanResult nothing = compare(before, before, plan);
  EXPECT_NEAR(nothing.uncut_volume / mm3, 12 * 6 * 3, 0.1);
  // The middle of the plan's 4 mm lies in bone; half a voxel is taken off, and half is rounding.
  EXPECT_NEAR(nothing.uncut_height, 2 * mm, 0.51 * mm);
}

}  // namespace
}  // namespace osteomill::workpiece
