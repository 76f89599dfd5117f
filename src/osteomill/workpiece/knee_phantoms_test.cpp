// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/knee_phantoms.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {
namespace {

constexpr double mm = units::mm;

double density_at(const Stock& stock, const Vector3& p_mm) {
  const Vector3 cell = (p_mm * mm - stock.shape().origin) / stock.spacing();
  return stock
      .material(static_cast<int>(std::lround(cell.x())), static_cast<int>(std::lround(cell.y())),
                static_cast<int>(std::lround(cell.z())))
      .density;
}

Vector3 extent(const Stock& stock) {
  const Stock::Box box = stock.bone_box();
  return stock.spacing() * Vector3(box.last[0] - box.first[0] + 1, box.last[1] - box.first[1] + 1,
                                   box.last[2] - box.first[2] + 1);
}

TEST(ProximalTibia, HasItsSizesAndLayers) {
  ProximalTibia tibia;
  const Stock stock = proximal_tibia(tibia, 1 * mm);
  // A trace of bone counts as a voxel: up to one more on each side, and rounding.
  EXPECT_NEAR(extent(stock).x(), tibia.width, 2.001 * mm);
  EXPECT_NEAR(extent(stock).y(), tibia.depth, 2.001 * mm);
  EXPECT_EQ(density_at(stock, {0, 0, -1}), tibia.bone.subchondral);
  const double below_plate = density_at(stock, {0, 0, -4});
  const double deep = density_at(stock, {0, 0, -30});
  EXPECT_LT(below_plate, tibia.bone.cancellous_joint + 1.0);
  EXPECT_LT(deep, below_plate);
  EXPECT_EQ(density_at(stock, {0, 0, -60}), tibia.bone.cancellous_shaft);
  EXPECT_EQ(density_at(stock, {12, 0, -60}), tibia.bone.cortical);
  EXPECT_EQ(density_at(stock, {20, 0, -60}), 0.0);
}

TEST(ProximalTibia, SlopesDownBackwards) {
  const Stock stock = proximal_tibia({}, 1 * mm);
  // 20 mm from the middle a slope of 5° is 1.7 mm.
  EXPECT_EQ(density_at(stock, {0, -20, 0.0}), 0.0);
  EXPECT_GT(density_at(stock, {0, 20, 0.0}), 0.0);
}

TEST(DistalFemur, HasTwoCondylesWithANotchBetweenThem) {
  DistalFemur femur;
  const Stock stock = distal_femur(femur, 1 * mm);
  EXPECT_NEAR(extent(stock).x(), femur.width, 4 * mm);
  EXPECT_NEAR(extent(stock).y(), femur.depth, 4 * mm);
  EXPECT_GT(density_at(stock, {25, 0, 5}), 0.0);
  EXPECT_GT(density_at(stock, {-25, 0, 5}), 0.0);
  EXPECT_EQ(density_at(stock, {0, -18, 8}), 0.0) << "the notch";
  EXPECT_GT(density_at(stock, {0, 0, 70}), 0.0) << "the shaft";
  EXPECT_EQ(density_at(stock, {25, 0, 1}), femur.bone.subchondral);
  // The same on both sides.
  const std::array<int, 3>& size = stock.shape().size;
  int differing = 0;
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0] / 2; ++x)
        if (std::abs(stock.occupancy(x, y, z) - stock.occupancy(size[0] - 1 - x, y, z)) > 1e-4)
          ++differing;
  EXPECT_EQ(differing, 0);
}

TEST(KneePhantoms, RefuseWhatIsNoBone) {
  ProximalTibia tibia;
  tibia.shaft = 100 * mm;
  EXPECT_THROW(proximal_tibia(tibia, 1 * mm), InvalidInput);
  tibia = {};
  tibia.bone.cortical = -1.0;
  EXPECT_THROW(proximal_tibia(tibia, 1 * mm), InvalidInput);
  DistalFemur femur;
  femur.notch = 70 * mm;
  EXPECT_THROW(distal_femur(femur, 1 * mm), InvalidInput);
  EXPECT_THROW(distal_femur({}, 0.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::workpiece
