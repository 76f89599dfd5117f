// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/report_encode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "osteomill/base/units.hpp"

namespace osteomill::io {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::IsNan;
using testing::SizeIs;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string decoded(const std::string& text) {
  static const std::string digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255);
  }
  return bytes;
}

/// What the page does: inflate, and put the bytes of each value together again.
template <typename T>
std::vector<T> unpacked(const std::string& text, std::size_t count) {
  const std::string small = decoded(text);
  std::string planes(count * sizeof(T), '\0');
  uLongf size = planes.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(planes.data()), &size,
                       reinterpret_cast<const Bytef*>(small.data()), small.size()),
            Z_OK);
  EXPECT_EQ(size, planes.size());
  std::vector<T> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    char raw[sizeof(T)];
    for (std::size_t b = 0; b < sizeof(T); ++b) raw[b] = planes[b * count + i];
    std::memcpy(&values[i], raw, sizeof(T));
  }
  return values;
}

TEST(ReportEncode, WritesBase64AsTheStandardDoes) {  // RFC 4648, section 10
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(ReportEncode, FloatsComeBackAsTheyWere) {
  EXPECT_THAT(unpacked<float>(pack_floats(std::vector{0.0, -1.5, 3.25e7}), 3),
              ElementsAre(0.0f, -1.5f, 3.25e7f));
  EXPECT_THAT(unpacked<float>(pack_floats(std::vector{kNaN}), 1), ElementsAre(IsNan()));
}

TEST(ReportEncode, IndicesComeBackFromTheirDifferencesUpAndDown) {
  const std::vector<std::uint32_t> indices = {7, 3, 4'000'000'000u, 0};
  auto back = unpacked<std::uint32_t>(pack_indices(indices), indices.size());
  for (std::size_t i = 1; i < back.size(); ++i) back[i] += back[i - 1];
  EXPECT_EQ(back, indices);
}

TEST(ReportEncode, StepsComeBackWithinHalfAStepAndNaNStaysNothing) {
  const std::vector<float> values = {2.0f, -1.0f, 0.3f, std::numeric_limits<float>::quiet_NaN(),
                                     2.0f};
  auto steps = unpacked<std::uint16_t>(pack_steps(values, -1.0f, 2.0f), values.size());
  for (std::size_t i = 1; i < steps.size(); ++i)
    steps[i] = static_cast<std::uint16_t>(steps[i] + steps[i - 1]);
  EXPECT_EQ(steps[3], 65535);
  // Half of a step of 3/65534, and the rounding of a float near 2.
  for (const std::size_t i : {0u, 1u, 2u, 4u})
    EXPECT_NEAR(-1.0 + steps[i] * 3.0 / 65534, values[i], 0.5 * 3.0 / 65534 + 2.4e-7);
}

TEST(ReportEncode, LongSignalsKeepTheirPeaksAndTheirEnds) {
  std::vector<double> time, wave;
  for (int i = 0; i < 100'000; ++i) {
    time.push_back(0.001 * i);
    wave.push_back(std::sin(0.7 * i));
  }
  wave[54'321] = 9.0;
  wave[54'322] = -8.0;
  const Thinned few = thinned(time, {wave}, 1000);
  EXPECT_THAT(few.time, SizeIs(1000));
  EXPECT_TRUE(std::is_sorted(few.time.begin(), few.time.end()));
  EXPECT_EQ(few.time.front(), time.front());
  EXPECT_EQ(few.time.back(), time.back());
  const auto& values = few.signals[0];
  const auto largest = std::max_element(values.begin(), values.end());
  EXPECT_EQ(*largest, 9.0);
  EXPECT_EQ(*std::min_element(values.begin(), values.end()), -8.0);
  // 200 samples make an interval of 0.2 s; a peak stays within its own.
  EXPECT_NEAR(few.time[static_cast<std::size_t>(largest - values.begin())], time[54'321], 0.2);
}

TEST(ReportEncode, ShortSignalsAreLeftAlone) {
  const std::vector<double> time = {0, 1, 2}, values = {5, kNaN, 7};
  const Thinned same = thinned(time, {values}, 4);
  EXPECT_EQ(same.time, time);
  EXPECT_THAT(same.signals[0], ElementsAre(5, IsNan(), 7));
}

TEST(ReportEncode, AGapStaysAGapAndDoesNotSwallowItsNeighbours) {
  std::vector<double> time(1000), values(1000, 1.0);
  for (std::size_t i = 0; i < time.size(); ++i) time[i] = static_cast<double>(i);
  std::fill(values.begin() + 400, values.begin() + 600, kNaN);
  const Thinned few = thinned(time, {values}, 100);  // intervals of 20
  EXPECT_THAT(std::vector(few.signals[0].begin(), few.signals[0].begin() + 40), Each(1.0));
  EXPECT_THAT(std::vector(few.signals[0].begin() + 40, few.signals[0].begin() + 60), Each(IsNan()));
  EXPECT_EQ(few.signals[0][60], 1.0);
}

/// A sheet of n x n squares with sides of 1 mm; the value of a vertex is its x.
geometry::Mesh sheet(int n) {
  geometry::Mesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      mesh.vertices.emplace_back(1e-3f * static_cast<float>(i), 1e-3f * static_cast<float>(j),
                                 0.0f);
      mesh.values.push_back(mesh.vertices.back().x());
    }
  const auto at = [&](int i, int j) { return static_cast<unsigned>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

TEST(ReportEncode, ACoarsenedMeshIsSmallEnoughAndStaysWithinACellOfTheOriginal) {
  const geometry::Mesh fine = sheet(100);
  const geometry::Mesh coarse = coarsened(fine, 2000);
  EXPECT_LE(coarse.triangles.size(), 2000u);
  EXPECT_GT(coarse.triangles.size(), 500u);
  ASSERT_EQ(coarse.values.size(), coarse.vertices.size());
  for (std::size_t i = 0; i < coarse.vertices.size(); ++i) {
    EXPECT_EQ(coarse.vertices[i].z(), 0.0f);
    // Both are means over the same vertices; floats near 0.1 m.
    EXPECT_NEAR(coarse.values[i], coarse.vertices[i].x(), 1e-7f);
  }
  for (const auto& [a, b, c] : coarse.triangles)
    EXPECT_GT((coarse.vertices[b] - coarse.vertices[a])
                  .cross(coarse.vertices[c] - coarse.vertices[a])
                  .z(),
              0.0f);
  EXPECT_EQ(coarsened(fine, 20'000).vertices.size(), fine.vertices.size());
}

TEST(ReportEncode, MeanEdgeIsTheMeanOfSidesAndDiagonal) {
  EXPECT_NEAR(mean_edge(sheet(3)), (2.0 + std::sqrt(2.0)) / 3.0 * units::mm, 1e-9);
  EXPECT_EQ(mean_edge({}), 0.0);
}

struct Move {
  std::vector<double> time = {0.0, 10.0};
  std::vector<geometry::Vector3> tips = {{0, 0, 0}, {0.1, 0, 0}};  // 10 mm/s along x
  std::vector<geometry::Vector3> axes = {geometry::Vector3::UnitZ()};
};

cutting::Cutter cutter(cutting::CutterShape shape) {
  return {.shape = shape, .radius = 2 * units::mm, .flutes = 2, .cutting_length = 10 * units::mm};
}

TEST(ReachTimes, AreThoseOfFirstContactOnTheWay) {
  const Move move;
  const std::vector<Eigen::Vector3f> vertices = {
      {0.05f, 0.0f, 0.005f},     // on the way: reached when the tip is 2 mm before it
      {0.05f, 0.0019f, 0.005f},  // just within the swath: reached at its middle
      {0.05f, 0.0025f, 0.005f},  // beside
      {0.05f, 0.0f, 0.0105f},    // above the edges
      {0.05f, 0.0f, -0.0005f},   // below the tip
  };
  const auto at = reach_times(vertices, move.time, move.tips, move.axes,
                              cutter(cutting::CutterShape::cylindrical), 0.0);
  // Looked at every eighth of the radius: 0.25 mm are 0.025 s.
  EXPECT_NEAR(at[0], 4.8, 0.026);
  EXPECT_NEAR(at[1], 5.0 - std::sqrt(4.0 - 1.9 * 1.9) / 10.0, 0.026);
  EXPECT_THAT((std::vector{at[2], at[3], at[4]}), Each(IsNan()));
}

TEST(ReachTimes, FollowTheRoundTipOfABall) {
  const Move move;
  // 0.4 mm above the tip a ball of 2 mm is sqrt(2^2 - 1.6^2) = 1.2 mm wide to each side.
  const std::vector<Eigen::Vector3f> vertices = {{0.05f, 0.0011f, 0.0004f},
                                                 {0.05f, 0.0013f, 0.0004f}};
  const auto at = reach_times(vertices, move.time, move.tips, move.axes,
                              cutter(cutting::CutterShape::ball), 0.0);
  EXPECT_FALSE(std::isnan(at[0]));
  EXPECT_TRUE(std::isnan(at[1]));
}

TEST(ReachTimes, TurnWithTheAxisAndGrowWithTheMargin) {
  Move move;
  move.axes = {geometry::Vector3::UnitY(), geometry::Vector3::UnitY()};
  const std::vector<Eigen::Vector3f> vertices = {{0.05f, 0.005f, 0.0f}, {0.05f, 0.005f, 0.0024f}};
  const auto c = cutter(cutting::CutterShape::cylindrical);
  const auto tight = reach_times(vertices, move.time, move.tips, move.axes, c, 0.0);
  EXPECT_FALSE(std::isnan(tight[0]));
  EXPECT_TRUE(std::isnan(tight[1]));
  EXPECT_FALSE(std::isnan(reach_times(vertices, move.time, move.tips, move.axes, c, 0.5e-3)[1]));
}

TEST(ReachTimes, DoNotDependOnHowFinelyTheSamePathIsSampled) {
  const Move coarse;
  Move fine;
  fine.time.clear();
  fine.tips.clear();
  for (int i = 0; i <= 1000; ++i) {
    fine.time.push_back(0.01 * i);
    fine.tips.emplace_back(1e-4 * i, 0, 0);
  }
  std::vector<Eigen::Vector3f> vertices;
  for (int i = 0; i < 200; ++i)
    vertices.emplace_back(5e-4f * static_cast<float>(i), 1e-5f * static_cast<float>(i), 1e-3f);
  const auto c = cutter(cutting::CutterShape::cylindrical);
  const auto a = reach_times(vertices, coarse.time, coarse.tips, coarse.axes, c, 0.0);
  const auto b = reach_times(vertices, fine.time, fine.tips, fine.axes, c, 0.0);
  // Each is late by less than a look, 0.025 s (0.03 s where looks fall on samples of 0.01 s).
  for (std::size_t i = 0; i < vertices.size(); ++i) EXPECT_NEAR(a[i], b[i], 0.031) << i;
}

}  // namespace
}  // namespace osteomill::io
