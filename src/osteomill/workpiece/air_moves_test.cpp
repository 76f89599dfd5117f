// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/air_moves.hpp"

#include <gtest/gtest.h>

#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/area_paths.hpp"
#include "osteomill/workpiece/phantoms.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;

const CutSettings kCut{3e-3, 628.0};

cutting::Cutter cylinder() {
  cutting::Cutter cutter;
  cutter.radius = 3 * mm;
  cutter.cutting_length = 10 * mm;
  return cutter;
}

Stock two_blocks() {
  const geometry::GridShape shape =
      cubes_over(Vector3(-2, -2, -8) * mm, Vector3(52, 12, 2) * mm, 0.5 * mm);
  return Stock(shape, [](const Vector3& p) {
    const double across = std::max({-p.y(), p.y() - 10 * mm, p.z(), -6 * mm - p.z()});
    const double first = std::max(-p.x(), p.x() - 10 * mm);
    const double second = std::max(40 * mm - p.x(), p.x() - 50 * mm);
    return BoneSample{std::max(across, std::min(first, second)), {1900, 1}};
  });
}

TEST(AirMoves, AreFastWhereNoBoneIsAndLeaveTheSameStock) {
  const ToolPath path = line({-20 * mm, 5 * mm, -2 * mm}, {70 * mm, 5 * mm, -2 * mm}, kCut);
  const ContactMap contact(two_blocks(), cylinder(), path);
  const AirMoves air = rapid_through_air(path, contact, {2 * mm, 12e-3});
  // Bone is met from one radius before a block until the axis is at its end: 17 mm of air before,
  // 27 between and 20 behind, but for clearances of 2 mm, each end to a step of a voxel.
  EXPECT_NEAR(air.length, (15 + 23 + 18) * mm, 4 * 0.5 * mm);
  EXPECT_NEAR(air.time_saved, air.length * (1 / 3e-3 - 1 / 12e-3), 1e-9);
  EXPECT_NEAR(duration(path, 12e-3) - duration(air.path, 12e-3), air.time_saved, 1e-9);
  EXPECT_NEAR(air.path.length(), path.length(), 1e-12);
  // The contact map refuses rapids through bone, and finds the same bone.
  const ContactMap again(two_blocks(), cylinder(), air.path);
  EXPECT_NEAR(again.removed_volume(), contact.removed_volume(), 1e-3 * contact.removed_volume());
  EXPECT_NEAR(again.first_contact(), contact.first_contact(), 1 * mm);
}

TEST(AirMoves, KeepCutsThatAreNoSlowerThanRapids) {
  const ToolPath path = line({-20 * mm, 5 * mm, -2 * mm}, {70 * mm, 5 * mm, -2 * mm}, {20e-3, 628});
  const AirMoves air = rapid_through_air(path, ContactMap(two_blocks(), cylinder(), path), {});
  EXPECT_EQ(air.length, 0.0);
  EXPECT_EQ(air.path.moves().size(), 1u);
}

}  // namespace
}  // namespace osteomill::workpiece
