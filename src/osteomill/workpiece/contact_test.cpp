// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/contact.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/phantoms.hpp"

namespace osteomill::workpiece {
namespace {

constexpr double mm = units::mm;
const CutSettings kCut{3 * mm, 600.0};

cutting::Cutter cutter(double diameter) {
  cutting::Cutter cutter;
  cutter.radius = 0.5 * diameter;
  cutter.cutting_length = 10 * mm;
  return cutter;
}

TEST(ContactMap, FindsFirstContactFullEngagementAndExitOfASlot) {
  // Block from x = 5 to 25 mm; a 4 mm cylinder along x from 0: touches at 3, is in to its middle at
  // 5; its front has passed the end at 23, its widest part, and with it the last bone, at 25.
  const Stock stock =
      block({5 * mm, 0, -6 * mm}, {25 * mm, 20 * mm, 0}, {1900.0, 1.0}, 0.2 * mm, 2 * mm);
  const ToolPath path = line({0, 10 * mm, -3 * mm}, {32 * mm, 10 * mm, -3 * mm}, kCut);
  const ContactMap contact(stock, cutter(4 * mm), path);
  ASSERT_EQ(contact.stretches().size(), 1u);
  // One voxel of resolution, half a voxel of the surface's width.
  EXPECT_NEAR(contact.first_contact(), 3 * mm, 0.31 * mm);
  EXPECT_NEAR(contact.last_exit(), 25 * mm, 0.31 * mm);
  EXPECT_NEAR(contact.distance_to_contact(1 * mm), 2 * mm, 0.31 * mm);
  EXPECT_EQ(contact.distance_to_contact(10 * mm), 0.0);
  EXPECT_TRUE(contact.in_contact(10 * mm));
  EXPECT_FALSE(contact.in_contact(30 * mm));
  EXPECT_EQ(contact.distance_to_contact(30 * mm), std::numeric_limits<double>::infinity());
  // The chord at x is 95 % of the diameter where 1 - (1 - d/R)² = 0.95²: 0.69 R from the touch.
  EXPECT_NEAR(contact.distance_to_full_engagement(1 * mm), 2 * mm + 0.69 * 2 * mm, 0.5 * mm);
  EXPECT_EQ(contact.distance_to_full_engagement(10 * mm), 0.0);
  EXPECT_NEAR(contact.removed_volume(), 20 * 4 * 3 * units::mm3, 0.01 * 240 * units::mm3);
}

TEST(ContactMap, KnowsWhatEarlierPassesTook) {
  const Stock stock =
      block({5 * mm, 0, -6 * mm}, {25 * mm, 20 * mm, 0}, {1900.0, 1.0}, 0.4 * mm, 2 * mm);
  Lines twice;
  twice.start_W = Vector3(0, 10 * mm, -3 * mm);
  twice.along_W = Vector3(30 * mm, 0, 0);
  twice.step_over_W = Vector3(0, 0, 0);
  twice.count = 2;
  const ContactMap contact(stock, cutter(4 * mm), lines(twice, kCut));
  EXPECT_EQ(contact.stretches().size(), 1u) << "the second pass finds nothing";
}

TEST(ContactMap, RefusesAPathOutsideTheStock) {
  const Stock stock =
      block({5 * mm, 0, -6 * mm}, {25 * mm, 20 * mm, 0}, {1900.0, 1.0}, 0.4 * mm, 2 * mm);
  try {
    ContactMap(stock, cutter(4 * mm), line({0, 10 * mm, 1 * mm}, {32 * mm, 10 * mm, 1 * mm}, kCut));
    FAIL() << "no error";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("must touch the bone"));
  }
}

TEST(ContactMap, RefusesARapidThroughBone) {
  const Stock stock =
      block({5 * mm, 0, -6 * mm}, {25 * mm, 20 * mm, 0}, {1900.0, 1.0}, 0.4 * mm, 2 * mm);
  const Vector3 a(0, 10 * mm, -2 * mm), b(32 * mm, 10 * mm, -2 * mm), c(0, 15 * mm, -2 * mm);
  const ToolPath path(
      {{MoveKind::cut, {a, b}, 3 * mm, 600.0, 7}, {MoveKind::rapid, {b, c}, 0.0, 600.0, 8}});
  try {
    ContactMap(stock, cutter(4 * mm), path);
    FAIL() << "no error";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("rapid of line 8"));
  }
}

}  // namespace
}  // namespace osteomill::workpiece
