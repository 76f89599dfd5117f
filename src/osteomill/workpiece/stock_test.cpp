// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/stock.hpp"

#include <gmock/gmock.h>
#include <tbb/task_arena.h>

#include <numbers>

#include "osteomill/base/archive.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/phantoms.hpp"

namespace osteomill::workpiece {
namespace {

constexpr double mm = units::mm;

TEST(Stock, HasTheVolumeAndMassOfABlockOffTheGrid) {
  const Stock stock =
      block({0.03 * mm, 0, 0}, {10.13 * mm, 6 * mm, 4 * mm}, {1900.0, 1.0}, 0.2 * mm, 1 * mm);
  // Faces along the grid are exact in occupancy but where two of them meet inside a voxel.
  EXPECT_NEAR(stock.remaining_volume(), 10.1 * 6 * 4 * units::mm3, 1e-4 * 242.4 * units::mm3);
  EXPECT_NEAR(stock.remaining_mass(), 1900.0 * stock.remaining_volume(), 1e-12);
  EXPECT_EQ(stock.occupancy(0, 0, 0), 0.0);
  EXPECT_EQ(stock.occupancy(-1, 0, 0), 0.0);
  EXPECT_EQ(stock.material(0, 0, 0).density, 0.0);
}

TEST(Stock, OfABallConvergesWithTheSquareOfTheSpacing) {
  const double exact = 4.0 / 3.0 * std::numbers::pi * 125 * units::mm3;
  const auto error = [&](double spacing) {
    const Stock stock(
        cubes_over(Vector3::Constant(-6 * mm), Vector3::Constant(6 * mm), spacing),
        [](const Vector3& p_W) { return BoneSample{p_W.norm() - 5 * mm, {1900.0, 1.0}}; });
    return stock.remaining_volume() / exact - 1.0;
  };
  // Occupancy averages over a voxel's width along the normal: h²/(4 R²) too much on a ball; the
  // lattice samples the surface with an error of the same order, either way.
  for (double spacing : {0.8 * mm, 0.4 * mm, 0.2 * mm}) {
    const double averaging = 0.25 * std::pow(spacing / (5 * mm), 2);
    EXPECT_NEAR(error(spacing), averaging, 0.5 * averaging);
  }
}

TEST(Stock, StoresNoAirAroundTheBone) {
  const Stock stock = block({0, 0, 0}, {4 * mm, 4 * mm, 4 * mm}, {1900.0, 1.0}, 0.2 * mm, 20 * mm);
  // Three tiles of eight voxels along each axis: 96 to 119.
  EXPECT_EQ(stock.stored_voxels(), 24u * 24u * 24u);
  EXPECT_EQ(stock.bone_box().first, (std::array{100, 100, 100}));
  EXPECT_EQ(stock.bone_box().last, (std::array{119, 119, 119}));
}

TEST(Stock, IsTheSameForAnyNumberOfThreads) {
  const auto made_by = [](int threads) {
    tbb::task_arena arena(threads);
    return arena.execute([] { return tibia_section({}, 0.5 * mm, 1 * mm); });
  };
  const auto bytes_of = [](Stock& stock) {
    std::string bytes;
    Archive::saving([&](const void* from, std::size_t size) {
      bytes.append(static_cast<const char*>(from), size);
    })(stock);
    return bytes;
  };
  Stock one = made_by(1), four = made_by(4);
  EXPECT_EQ(bytes_of(one), bytes_of(four));
  const geometry::GridShape& shape = one.shape();
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x)
        ASSERT_EQ(one.material(x, y, z).density, four.material(x, y, z).density);
}

TEST(TibiaSection, HasACorticalRimAndCancellousBoneInside) {
  TibiaSection section;
  const Stock stock = tibia_section(section, 0.5 * mm, 1 * mm);
  const auto at = [&](double x_mm, double y_mm) {
    const Vector3 cell =
        (Vector3(x_mm * mm, y_mm * mm, -1 * mm) - stock.shape().origin) / (0.5 * mm);
    return stock
        .material(static_cast<int>(std::lround(cell.x())), static_cast<int>(std::lround(cell.y())),
                  static_cast<int>(std::lround(cell.z())))
        .density;
  };
  EXPECT_EQ(at(33, 2), section.cortical.density);
  EXPECT_EQ(at(2, 20), section.cortical.density);
  EXPECT_EQ(at(64, 20), section.cortical.density);
  EXPECT_EQ(at(33, 20), section.cancellous.density);
  EXPECT_EQ(at(33, -1), 0.0);
  const double rim = 66 * 40 - 56 * 30;
  EXPECT_NEAR(stock.remaining_mass(), (rim * 640.0 + 56 * 30 * 160.0) * 10 * units::mm3, 1e-9);
}

TEST(TibiaSection, GradesTheRimWhenAsked) {
  TibiaSection section;
  section.graded = 3 * mm;
  const Stock stock = tibia_section(section, 0.5 * mm);
  double last = section.cortical.force_scale;
  for (int y = 0; y < 40; ++y) {
    const double scale = stock.material(60, y, 3).force_scale;
    EXPECT_LE(scale, last);
    last = scale;
  }
  // Voxel 13 has its centre at 6.75 mm: 1.75 of the 3 mm into the graded zone.
  EXPECT_NEAR(stock.material(60, 13, 3).density, 640.0 - 480.0 * 1.75 / 3.0, 0.5);
}

/// A ball of bone in soft tissue as a CT would show it: the edge blurred over `blur`.
geometry::VoxelGrid<float> blurred_ball(double radius, double blur, double ct_spacing) {
  geometry::VoxelGrid<float> hu(
      cubes_over(Vector3::Constant(-9 * mm), Vector3::Constant(9 * mm), ct_spacing), 0.0f);
  for (int z = 0; z < hu.shape().size[2]; ++z)
    for (int y = 0; y < hu.shape().size[1]; ++y)
      for (int x = 0; x < hu.shape().size[0]; ++x) {
        const double inside = radius - hu.shape().centre(x, y, z).norm();
        hu.at(x, y, z) = static_cast<float>(1200.0 * std::clamp(0.5 + inside / blur, 0.0, 1.0));
      }
  return hu;
}

TEST(StockFromHounsfield, PutsTheSurfaceBetweenTheVoxels) {
  BoneFromCt options;
  options.threshold_hu = 600.0;  // the middle of the edge
  const Stock stock =
      stock_from_hounsfield(blurred_ball(6 * mm, 1.5 * mm, 0.5 * mm), 0.2 * mm, options);
  // The CT's linear interpolation of a curved edge moves it by about spacing²/(8 R) = 5 µm, 0.3 %
  // of the volume; h²/(4 R²) = 0.03 % for the occupancy.
  const double exact = 4.0 / 3.0 * std::numbers::pi * 216 * units::mm3;
  EXPECT_NEAR(stock.remaining_volume(), exact, 5e-3 * exact);
}

TEST(StockFromHounsfield, GivesTheEdgeTheDensityOfTheBoneBesideIt) {
  BoneFromCt options;
  options.threshold_hu = 600.0;
  const Stock stock =
      stock_from_hounsfield(blurred_ball(6 * mm, 1.0 * mm, 0.5 * mm), 0.2 * mm, options);
  const double full = std::round(131.0 + 1.067 * 1200.0);
  const double scale = bone::force_scale(full, options.force);
  const int middle = 45;
  EXPECT_EQ(stock.material(middle, middle, middle).density, full);
  EXPECT_DOUBLE_EQ(stock.material(middle, middle, middle).force_scale, scale);
  // A voxel at the surface: half bone, not bone of half the density.
  int x = middle;
  while (stock.occupancy(x + 1, middle, middle) > 0.0) ++x;
  EXPECT_GT(stock.material(x, middle, middle).density, 0.9 * full);
}

TEST(Stock, RefusesWhatIsNoBone) {
  const auto hu = blurred_ball(6 * mm, 1.0 * mm, 1.0 * mm);
  BoneFromCt options;
  options.threshold_hu = 3000.0;
  try {
    stock_from_hounsfield(hu, 0.5 * mm, options);
    FAIL() << "made a stock";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("0 voxels are bone"));
  }
  options.threshold_hu = -500.0;  // a density below 0
  EXPECT_THROW(stock_from_hounsfield(hu, 0.5 * mm, options), InvalidInput);
  EXPECT_THROW(stock_from_hounsfield(hu, 0.0, {}), InvalidInput);
  EXPECT_THROW(stock_from_hounsfield(hu, -1.0, {}), InvalidInput);
  EXPECT_THROW(Stock(cubes_over({0, 0, 0}, {1, 1, 1}, 0.1),
                     [](const Vector3&) { return BoneSample{1.0, {1.0, 1.0}}; }),
               InvalidInput);
  geometry::GridShape flat = cubes_over({0, 0, 0}, {1, 1, 1}, 0.1);
  flat.spacing.z() = 0.2;
  EXPECT_THROW(Stock(flat, [](const Vector3&) { return BoneSample{-1.0, {1.0, 1.0}}; }),
               InvalidInput);
  EXPECT_THROW(block({0, 0, 0}, {0, 1, 1}, {1900.0, 1.0}, 0.1), InvalidInput);
  TibiaSection section;
  section.rim = 30 * mm;
  EXPECT_THROW(tibia_section(section, 0.5 * mm), InvalidInput);
}

}  // namespace
}  // namespace osteomill::workpiece
