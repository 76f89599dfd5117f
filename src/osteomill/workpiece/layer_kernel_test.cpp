// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/layer_kernel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "osteomill/workpiece/voxel_shadow.hpp"

namespace osteomill::workpiece::kernel {
namespace {

constexpr int kSize = 96;  // voxels of the layer, each way
constexpr int kTilesAlong = kSize / 8;
constexpr double kFar = 1e30;

/// What all functions make of one random layer of a step, one after the other.
struct Outcome {
  std::vector<int> stretches;
  std::vector<std::uint16_t> fresh, occupancy;
  std::vector<float> amounts, run_amounts, cells;
  std::vector<std::uint32_t> units;
  std::vector<std::int64_t> row_units;
  Taken taken;
  std::vector<bool> alike, any;
};

Outcome outcome_of(const Functions& functions, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double heading = seed % 4 == 0   ? 0.0
                         : seed % 4 == 1 ? 0.5 * std::numbers::pi
                                         : uniform(0.0, 6.28);
  const bool along_x = seed % 4 == 0, along_y = seed % 4 == 1;
  const double hx = along_y ? 0.0 : std::cos(heading), hy = along_x ? 0.0 : std::sin(heading);
  const double radius = uniform(5.0, 30.0), run = uniform(0.2, 9.0);
  const double from_x = uniform(40.0, 56.0), from_y = uniform(40.0, 56.0);
  const double to_x = from_x + run * hx, to_y = from_y + run * hy;

  std::vector<double> rows(7 * kSize);
  for (int y = 0; y < kSize; ++y) {
    const double y0 = y - from_y, y1 = y - to_y, along = hy * y0;
    const double start = along_y ? 0.0 : from_x - along / hx;
    const double end = along_y ? 0.0 : start + run / hx;
    const double all[7] = {
        y0 * y0,
        y1 * y1,
        along_y ? (along < 0.0 ? kFar : -kFar) : (hx > 0.0 ? start : -kFar),
        hx < 0.0 ? start : kFar,
        along_y ? (along < 0.0 || along > run ? kFar : -kFar) : std::min(start, end),
        along_y ? kFar : std::max(start, end),
        along_x ? from_x : from_x + hx * y0 / hy};
    for (int k = 0; k < 7; ++k) rows[static_cast<std::size_t>(k * kSize + y)] = all[k];
  }
  const double* r = rows.data();
  const Rows arrays{
      r, r + kSize, r + 2 * kSize, r + 3 * kSize, r + 4 * kSize, r + 5 * kSize, r + 6 * kSize};
  Outcome out;
  out.stretches.resize(6 * kSize);
  int* s = out.stretches.data();
  const Stretches stretch{
      {s, s + kSize}, {s + 2 * kSize, s + 3 * kSize}, s + 4 * kSize, s + 5 * kSize};
  const Section section{from_x,        to_x,         radius + 0.5,
                        radius - 0.5,  radius - 0.5, along_x ? 0.0 : 1.0 / std::abs(hy),
                        seed % 3 == 0, true,         kSize - 1.0};
  functions.stretches(arrays, section, 0, kSize - 1, stretch);

  std::vector<Run> runs;
  std::size_t size = 0;
  for (int y = 0; y < kSize; ++y)
    for (int part = 0; part < 2; ++part) {
      if (stretch.first[part][y] > stretch.last[part][y]) continue;
      runs.push_back({y, stretch.first[part][y], stretch.last[part][y], size, stretch.gone_first[y],
                      stretch.gone_last[y]});
      size += static_cast<std::size_t>(lanes_of(runs.back()));
    }
  out.fresh.resize(size);
  functions.fill({from_x, from_y, hx, hy, run, uniform(0.0, 4.0), 0.5 - radius}, runs.data(),
                 runs.size(), out.fresh.data());

  // Tile 0 is the empty one; the others stand in any order.
  std::vector<std::uint32_t> tiles(kTilesAlong * kTilesAlong);
  for (std::size_t i = 0; i < tiles.size(); ++i)
    tiles[i] = i % 7 == 3 ? 0 : static_cast<std::uint32_t>(tiles.size() - i);
  const std::size_t voxels = (tiles.size() + 1) * 512;
  out.occupancy.resize(voxels, 0);
  std::vector<std::uint16_t> material(voxels);
  for (std::size_t i = 512; i < voxels; ++i) {
    out.occupancy[i] = random() % 5 == 0 ? static_cast<std::uint16_t>(random() % 32769) : 32768;
    material[i] = static_cast<std::uint16_t>(random() % 3);
  }
  const std::vector<double> density{1900.0, 1100.0, 400.0}, scale{1.0, 0.61, 0.17};
  out.row_units.assign(kTilesAlong, std::int64_t{1} << 40);
  out.row_units[5] = 0;
  out.amounts.resize(size);
  out.units.resize(runs.size());
  out.run_amounts.resize(runs.size());
  const Amounts amounts{out.amounts.data(), out.run_amounts.data(), out.units.data()};
  for (const std::size_t layer : {2, 3}) {
    const Layer of{tiles.data(),         kTilesAlong,     layer * 64,
                   out.occupancy.data(), material.data(), out.row_units.data(),
                   density.data(),       scale.data(),    seed % 2 == 0};
    out.taken = functions.take(of, runs.data(), runs.size(), out.fresh.data(), layer == 3, amounts);
    out.alike.push_back(out.taken.alike);
    const VoxelShadow shadow(geometry::Vector3(-hy, hx, 0.0));
    FourShadows four;
    four.prepare(shadow, VoxelShadow::fixed(-hy));
    const std::size_t length = 128;
    out.cells.assign(4 * length, 1.0f);
    const Line line{60.0 + hy * from_x - hx * from_y,
                    -hy,
                    hx,
                    VoxelShadow::kPhaseBits,
                    shadow.table(),
                    VoxelShadow::kStride,
                    four.table(),
                    four.first_cell(),
                    along_x,
                    length,
                    out.cells.data()};
    out.any.push_back(functions.share(line, runs.data(), runs.size(), amounts));
    out.cells.resize(length);
  }
  return out;
}

/// The same of a leaning tool.
struct Leaning {
  std::vector<int> stretches;
  std::vector<std::uint16_t> fresh;
  std::vector<int> runs;
  std::vector<float> cells;
  std::vector<int> rows;
};

Leaning leaning_of(const Functions& functions, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto view_of = [](const Eigen::Matrix3d& frame, const geometry::Vector3& tip) -> View {
    const geometry::Vector3 base = frame * (geometry::Vector3(0.0, 0.0, 20.0) - tip);
    return {{base.x(), base.y(), base.z()},
            {frame(0, 1), frame(1, 1), frame(2, 1)},
            {frame(0, 0), frame(1, 0), frame(2, 0)}};
  };
  const bool ball = seed % 2 == 0, turns = seed % 3 == 0, placing = seed % 7 == 0;
  const double radius = uniform(5.0, 20.0);
  const geometry::Vector3 tip(uniform(40.0, 56.0), uniform(40.0, 56.0), uniform(5.0, 18.0));
  const Eigen::Matrix3d from =
      Eigen::AngleAxisd(uniform(-1.2, 1.2),
                        geometry::Vector3(uniform(-1.0, 1.0), 1.0, 0.2).normalized())
          .toRotationMatrix();
  const Eigen::Matrix3d to =
      turns ? (Eigen::AngleAxisd(0.02, geometry::Vector3::UnitX()) * from).eval() : from;
  const geometry::Vector3 way =
      ball ? geometry::Vector3(uniform(-3.0, 3.0), uniform(-3.0, 3.0), uniform(-3.0, 3.0))
           : (from.transpose() * geometry::Vector3(uniform(-3.0, 3.0), 2.0, 0.0)).eval();
  const geometry::Vector3 in_tool = -(from * way);
  const Solid near{view_of(from, tip), radius + 6.0, ball ? radius : -6.0, ball};
  const Solid gone{view_of(from, tip), radius - 0.5, ball ? radius : 0.5, ball};

  Leaning out;
  out.stretches.resize(4 * kSize);
  int* s = out.stretches.data();
  const Stretches stretch{{s, s + kSize}, {s + 2 * kSize, s + 3 * kSize}, nullptr, nullptr};
  functions.pose_stretches(near, placing ? nullptr : &gone, turns ? nullptr : in_tool.data(), 0,
                           kSize - 1, kSize - 1.0, stretch);
  std::vector<Run> runs;
  std::size_t size = 0;
  for (int y = 0; y < kSize; ++y)
    for (int part = 0; part < 2; ++part) {
      if (stretch.first[part][y] > stretch.last[part][y]) continue;
      runs.push_back({y, stretch.first[part][y], stretch.last[part][y], size});
      size += static_cast<std::size_t>(lanes_of(runs.back()));
    }
  out.fresh.resize(size);
  const Pass pass{view_of(from, tip),
                  view_of(to, placing ? tip : (tip + way).eval()),
                  radius,
                  ball,
                  placing,
                  turns};
  runs.resize(functions.pose_fill(pass, runs.data(), runs.size(), out.fresh.data()));
  for (const Run& run : runs) out.runs.insert(out.runs.end(), {run.y, run.first, run.last});

  std::vector<float> amounts(size), of_runs(runs.size());
  std::vector<std::uint32_t> units(runs.size(), 1);
  for (float& amount : amounts) amount = random() % 3 == 0 ? 0.0f : static_cast<float>(random());
  const geometry::Vector3 lateral =
      geometry::Vector3(uniform(-1.0, 1.0), uniform(-1.0, 1.0), 0.3).normalized();
  const geometry::Vector3 eta = lateral.unitOrthogonal();
  Plane plane{};
  FourShadows four[2];
  for (int i = 0; i < 2; ++i) {
    const geometry::Vector3& axis = i == 0 ? lateral : eta;
    four[i].prepare(VoxelShadow(axis), VoxelShadow::fixed(axis.x()));
    plane.x_rate[i] = axis.x();
    plane.y_rate[i] = axis.y();
    // All voxels of the layer are in it.
    plane.origin[i] = 150.0 - 48.0 * (axis.x() + axis.y());
    plane.four_shares[i] = four[i].table();
    plane.first_cell[i] = four[i].first_cell();
  }
  plane.phase_bits = VoxelShadow::kPhaseBits;
  plane.gain = 0.3f;
  plane.rows = 300;
  plane.stride = 300;
  out.cells.resize(300 * 300);
  plane.cells = out.cells.data();
  const RowRange range = functions.share_plane(plane, runs.data(), runs.size(),
                                               {amounts.data(), of_runs.data(), units.data()});
  out.rows = {range.first, range.last};
  return out;
}

// Bit for bit: results don't depend on the machine.
void compare(const Functions& one, const Functions& other) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(std::string(other.name) + ", seed " + std::to_string(seed));
    const Outcome a = outcome_of(one, seed), b = outcome_of(other, seed);
    EXPECT_EQ(a.stretches, b.stretches);
    EXPECT_EQ(a.fresh, b.fresh);
    EXPECT_EQ(a.occupancy, b.occupancy);
    EXPECT_EQ(a.amounts, b.amounts);
    EXPECT_EQ(a.run_amounts, b.run_amounts);
    EXPECT_EQ(a.units, b.units);
    EXPECT_EQ(a.row_units, b.row_units);
    EXPECT_EQ(a.cells, b.cells);
    EXPECT_EQ(a.taken.units, b.taken.units);
    EXPECT_EQ(a.taken.unit_density, b.taken.unit_density);
    EXPECT_EQ(a.taken.unit_scale, b.taken.unit_scale);
    EXPECT_EQ(a.alike, b.alike);
    EXPECT_EQ(a.any, b.any);
    const Leaning c = leaning_of(one, seed), d = leaning_of(other, seed);
    EXPECT_EQ(c.stretches, d.stretches);
    EXPECT_EQ(c.fresh, d.fresh);
    EXPECT_EQ(c.runs, d.runs);
    EXPECT_EQ(c.cells, d.cells);
    EXPECT_EQ(c.rows, d.rows);
  }
}

TEST(LayerKernel, EveryInstructionSetGivesTheSameBits) {
  if (__builtin_cpu_supports("avx2") != 0) compare(kSse2, kAvx2);
  if (best().name == kAvx512.name) compare(kSse2, kAvx512);
}

TEST(LayerKernel, TheLineHoldsAllThatWasTaken) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Outcome a = outcome_of(best(), seed);
    double amounts = 0.0, cells = 0.0;
    for (const float amount : a.amounts) amounts += static_cast<double>(amount);
    for (const float cell : a.cells) cells += static_cast<double>(cell);
    if (!a.any.back()) continue;
    // Single floats, some hundreds a cell: 1e-7 each.
    EXPECT_NEAR(cells / amounts, 1.0, 1e-5) << seed;
  }
}

TEST(LayerKernel, ThePlaneHoldsAllThatWasTaken) {
  // Rates along a row on both sides of none, among them such that rounding makes none of.
  const double turn = 0.3;
  for (const double rate : {0.9, 0.1, 1e-9, 1e-12, 1e-17, 0.0, -1e-17, -1e-12, -1e-9, -0.1, -0.9}) {
    const geometry::Vector3 axes[] = {{std::cos(turn), std::sin(turn), 0.0},
                                      {rate, 0.0, std::sqrt(1.0 - rate * rate)}};
    const kernel::Run run{7, 3, 16, 0};
    std::vector<float> amounts(static_cast<std::size_t>(lanes_of(run)), 2.0f);
    float of_run = 0.0f;
    std::uint32_t units = 1;
    FourShadows four[2];
    Plane plane{};
    for (int i = 0; i < 2; ++i) {
      four[i].prepare(VoxelShadow(axes[i]), VoxelShadow::fixed(axes[i].x()));
      plane.x_rate[i] = axes[i].x();
      plane.y_rate[i] = axes[i].y();
      plane.origin[i] = 40.0;
      plane.four_shares[i] = four[i].table();
      plane.first_cell[i] = four[i].first_cell();
    }
    plane.phase_bits = VoxelShadow::kPhaseBits;
    plane.gain = 0.5f;
    plane.rows = plane.stride = 80;
    std::vector<float> cells(80 * 80, 0.0f);
    plane.cells = cells.data();
    const RowRange rows = best().share_plane(plane, &run, 1, {amounts.data(), &of_run, &units});
    double sum = 0.0;
    for (const float cell : cells) sum += static_cast<double>(cell);
    // Single floats: 1e-7 each.
    EXPECT_NEAR(sum, static_cast<double>(amounts.size()), 1e-5 * sum) << rate;
    EXPECT_LE(rows.first, rows.last) << rate;
  }
}

TEST(LayerKernel, FreshOccupancyIsThatOfTheDistanceToTheSweptDisk) {
  const double radius = 11.3, run = 4.2, hx = 0.6, hy = 0.8, from_x = 20.3, from_y = 19.7;
  std::vector<kernel::Run> runs;
  std::size_t size = 0;
  for (int y = 0; y < 48; ++y) {
    runs.push_back({y, 3, 44, size});
    size += static_cast<std::size_t>(lanes_of(runs.back()));
  }
  std::vector<std::uint16_t> fresh(size);
  best().fill({from_x, from_y, hx, hy, run, 0.0, 0.5 - radius}, runs.data(), runs.size(),
              fresh.data());
  for (const kernel::Run& row : runs)
    for (int x = row.first; x <= row.last; ++x) {
      // The nearest of many places on the way, 1e-3 voxels apart: off by (0.5e-3)²/(2 r) and less.
      double nearest = kFar;
      for (int k = 0; k <= 4200; ++k) {
        const double t = run * k / 4200.0;
        nearest = std::min(nearest, std::hypot(x - from_x - t * hx, row.y - from_y - t * hy));
      }
      const double share = std::clamp(0.5 + nearest - radius, 0.0, 1.0);
      EXPECT_NEAR(fresh[row.fresh + static_cast<std::size_t>(x - start_of(row))], share * 32768.0,
                  1.0);
    }
}

}  // namespace
}  // namespace osteomill::workpiece::kernel
