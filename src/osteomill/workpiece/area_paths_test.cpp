// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/area_paths.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/phantoms.hpp"
#include "osteomill/workpiece/remover.hpp"

namespace osteomill::workpiece {
namespace {

using units::mm;
using units::mm2;

const CutSettings kCut{3e-3, 628.0};

TEST(Outline, GrowsByTheAreaOfItsBorder) {
  const Outline square = rectangle({0, 0}, {20 * mm, 10 * mm});
  EXPECT_NEAR(area(square), 200 * mm2, 1e-9 * mm2);
  // Steiner: A + L r + pi r². The rounded corners lie within 1 µm of their circle.
  const double r = 3 * mm;
  EXPECT_NEAR(area(grown(square, r)), 200 * mm2 + 60 * mm * r + std::numbers::pi * r * r,
              2 * std::numbers::pi * r * 1e-6);
  EXPECT_NEAR(area(grown(square, -2 * mm)), 16 * mm * 6 * mm, 1e-3 * mm2);
  EXPECT_TRUE(grown(square, -5.1 * mm).empty());
  EXPECT_NEAR(area(without(square, circle({10 * mm, 5 * mm}, 2 * mm))),
              200 * mm2 - 4 * std::numbers::pi * mm2, 0.02 * mm2);
}

TEST(Outline, CutsALineIntoPiecesInItsOwnDirection) {
  const Outline ring = without(circle({0, 0}, 10 * mm), circle({0, 0}, 4 * mm));
  const auto pieces = within(ring, {20 * mm, 0}, {-20 * mm, 0});
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_NEAR(pieces[0][0].x(), 10 * mm, 2e-6);
  EXPECT_NEAR(pieces[0][1].x(), 4 * mm, 2e-6);
  EXPECT_NEAR(pieces[1][1].x(), -10 * mm, 2e-6);
  EXPECT_FALSE(reaches(ring, {6 * mm, 0}, {-6 * mm, 0}));
  EXPECT_TRUE(reaches(ring, {6 * mm, 0}, {8 * mm, 0}));
}

TEST(Outline, OfAStockIsItsShadow) {
  const Stock stock = block({0, 0, -5 * mm}, {30 * mm, 20 * mm, 0}, {1900, 1}, 0.5 * mm, 2 * mm);
  EXPECT_NEAR(area(shadow(stock, -5 * mm, 0)) / mm2, 600.0, 1.0);
  EXPECT_TRUE(shadow(stock, 1 * mm, 5 * mm).empty());
}

AreaCut face() {
  AreaCut cut;
  cut.outline = grown(rectangle({0, 0}, {24 * mm, 16 * mm}), 1 * mm);
  cut.levels = levels(0, -3 * mm, 1.6 * mm);
  cut.step_over = 4 * mm;
  cut.clearance_z = 5 * mm;
  return cut;
}

cutting::Cutter cylinder() {
  cutting::Cutter cutter;
  cutter.radius = 3 * mm;
  cutter.cutting_length = 10 * mm;
  return cutter;
}

/// What is left of the layer that the path is to take off, m³; and what it took below.
std::array<double, 2> left_and_below(const ToolPath& path) {
  Stock stock = block({0, 0, -6 * mm}, {24 * mm, 16 * mm, 0}, {1900, 1}, 0.5 * mm, 2 * mm);
  Remover remover(stock, cylinder());
  for (const Move& move : path.moves())
    for (std::size_t i = 1; i < move.points_W.size(); ++i)
      remover.step(move.points_W[i - 1], move.points_W[i]);
  const double below = 24 * mm * 16 * mm * 3 * mm;
  double upper = 0.0;
  for (int z = 0; z < stock.shape().size[2]; ++z)
    for (int y = 0; y < stock.shape().size[1]; ++y)
      for (int x = 0; x < stock.shape().size[0]; ++x)
        if (stock.shape().centre(x, y, z).z() > -3 * mm)
          upper += stock.occupancy(x, y, z) * stock.shape().voxel_volume();
  return {upper, below - (stock.remaining_volume() - upper)};
}

TEST(AreaPaths, TakeOffAllOfTheirLayersAndNothingBelow) {
  const double voxel = std::pow(0.5 * mm, 3);
  for (const Milling milling : {Milling::down, Milling::up}) {
    for (const bool choice : {false, true}) {
      AreaCut cut = face();
      cut.milling = milling;
      for (const ToolPath& path :
           {raster(cut, {0.4, choice}, kCut), contour_parallel(cut, choice, kCut)}) {
        const auto [left, below] = left_and_below(path);
        // Rounding of shares to 1/32768 on some thousand voxels of the floor.
        EXPECT_NEAR(left, 0.0, voxel);
        EXPECT_NEAR(below, 0.0, voxel);
      }
    }
  }
}

TEST(AreaPaths, LevelsAreEquallyApartAndEndAtTheBottom) {
  EXPECT_THAT(levels(1.0, -3.0, 1.5), testing::ElementsAre(testing::DoubleNear(-1.0 / 3, 1e-12),
                                                           testing::DoubleNear(-5.0 / 3, 1e-12),
                                                           testing::DoubleNear(-3.0, 1e-12)));
  EXPECT_THAT(levels(0.0, -2.0, 1.0).size(), 2u);
}

TEST(AreaPaths, RunWithTheBoneThatIsLeftOnTheSideOfTheirMilling) {
  AreaCut cut = face();
  cut.levels = {-1 * mm};
  // A raster advances along its v; down-milling has what is left on the right.
  const ToolPath passes = raster(cut, {0.0, false}, kCut);
  const Move* last = nullptr;
  for (const Move& move : passes.moves())
    if (move.kind == MoveKind::cut && move.points_W.front().z() == move.points_W.back().z())
      last = &move;
  ASSERT_NE(last, nullptr);
  EXPECT_LT((last->points_W.back() - last->points_W.front()).x(), 0.0);
  // From the border inwards the middle is left: clockwise.
  for (const bool outside_in : {true, false}) {
    const ToolPath rings = contour_parallel(cut, outside_in, kCut);
    double signed_area = 0.0;
    for (const Move& move : rings.moves())
      if (move.kind == MoveKind::cut)
        for (std::size_t i = 1; i < move.points_W.size(); ++i)
          signed_area += move.points_W[i - 1].cross(move.points_W[i]).z();
    EXPECT_EQ(signed_area < 0.0, outside_in);
  }
}

Trochoid slot() {
  Trochoid slot;
  slot.along_W = {30 * mm, 0, 0};
  slot.slot_width = 10 * mm;
  slot.cutter_radius = 3 * mm;
  slot.advance = 0.8 * mm;
  slot.levels = {-2 * mm};
  slot.clearance_z = 5 * mm;
  return slot;
}

TEST(TrochoidalSlot, IsAsWideAsAskedForAndAdvancesByItsStepATurn) {
  const ToolPath path = trochoidal_slot(slot(), kCut);
  const std::vector<Vector3>& points = path.moves().back().points_W;
  double low = 0.0, high = 0.0;
  for (const Vector3& p : points) {
    low = std::min(low, p.y());
    high = std::max(high, p.y());
  }
  // Points stand 2 acos(1 - e/r) apart: up to e = 5 µm short of the largest width.
  EXPECT_NEAR(high, 2 * mm, 5e-6);
  EXPECT_NEAR(low, -2 * mm, 5e-6);
  // 37.5 turns: from the front of a circle to the back of another.
  EXPECT_NEAR(points.back().x() - points.front().x(), 30 * mm - 2 * 2 * mm, 1e-12);
  double turned = 0.0;
  for (std::size_t i = 2; i < points.size(); ++i) {
    const Vector3 a = points[i - 1] - points[i - 2], b = points[i] - points[i - 1];
    turned += std::atan2(a.cross(b).z(), a.dot(b));
  }
  // A turn each 0.8 mm; the first and the last half chord are not counted.
  EXPECT_NEAR(turned / (2 * std::numbers::pi), 30.0 / 0.8, 0.05);
}

TEST(TrochoidalSlot, MeetsTheBoneInFrontDownMillingUnlessToldOtherwise) {
  for (const Milling milling : {Milling::down, Milling::up}) {
    Trochoid asked = slot();
    asked.milling = milling;
    const std::vector<Vector3> points = trochoidal_slot(asked, kCut).moves().back().points_W;
    // At the front, the start of a turn, bone lies ahead along +x.
    const Vector3 motion = points[1] - points[0];
    const bool bone_on_the_right = motion.cross(Vector3::UnitZ()).x() > 0.0;
    EXPECT_EQ(bone_on_the_right, milling == Milling::down);
  }
}

TEST(AreaPaths, RefuseWhatCannotBe) {
  AreaCut nothing = face();
  nothing.outline = {};
  EXPECT_THROW(raster(nothing, {}, kCut), InvalidInput);
  AreaCut low = face();
  low.clearance_z = -2 * mm;
  EXPECT_THROW(contour_parallel(low, true, kCut), InvalidInput);
  EXPECT_THROW(levels(0, 1, 1), InvalidInput);
  EXPECT_THROW(levels(0, -1, 0), InvalidInput);
  Trochoid narrow = slot();
  narrow.slot_width = 5 * mm;
  EXPECT_THROW(trochoidal_slot(narrow, kCut), InvalidInput);
  Trochoid steep = slot();
  steep.along_W.z() = 1 * mm;
  EXPECT_THROW(trochoidal_slot(steep, kCut), InvalidInput);
}

}  // namespace
}  // namespace osteomill::workpiece
