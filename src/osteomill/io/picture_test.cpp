// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/picture.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/png_for_test.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using units::mm;

/// A ball of 10 mm as a mesh of circles of latitude.
geometry::Mesh ball() {
  geometry::Mesh mesh;
  constexpr unsigned rows = 48;
  constexpr unsigned columns = 96;
  for (unsigned r = 0; r <= rows; ++r)
    for (unsigned c = 0; c < columns; ++c) {
      const double polar = std::numbers::pi * r / rows;
      const double around = 2.0 * std::numbers::pi * c / columns;
      mesh.vertices.push_back((Vector3(std::sin(polar) * std::cos(around),
                                       std::sin(polar) * std::sin(around), std::cos(polar)) *
                               10.0 * mm)
                                  .cast<float>());
    }
  for (unsigned r = 0; r < rows; ++r)
    for (unsigned c = 0; c < columns; ++c) {
      const unsigned a = r * columns + c;
      const unsigned b = r * columns + (c + 1) % columns;
      mesh.triangles.push_back({a, a + columns, b + columns});
      mesh.triangles.push_back({a, b + columns, b});
    }
  return mesh;
}

Picture of_ball() {
  Picture picture;
  picture.views = {{"", {{ball()}}}};
  picture.width = 260;
  picture.height = 200;
  return picture;
}

bool white(const std::array<int, 3>& pixel) { return pixel == std::array<int, 3>{255, 255, 255}; }

TEST(Picture, ShowsABallRoundAndLitFromAbove) {
  const auto path = scratch("ball.png");
  draw(of_ball(), path);
  const DecodedPng picture = decode(path);
  ASSERT_EQ(picture.width, 520);
  ASSERT_EQ(picture.height, 400);
  int left = picture.width;
  int right = 0;
  int top = picture.height;
  int bottom = 0;
  double covered = 0.0;
  // Above the bar of scale.
  for (int y = 0; y < 340; ++y)
    for (int x = 0; x < picture.width; ++x) {
      if (white(picture.at(x, y))) continue;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
      covered += 1.0;
    }
  const double across = right - left + 1;
  EXPECT_NEAR(across, bottom - top + 1, 2.0);  // a pixel at each side
  EXPECT_GT(across, 250.0);                    // it fills the sheet
  // The rim counts whole pixels: one of some 300 across, at both sides.
  EXPECT_NEAR(covered / (across * across), std::numbers::pi / 4.0, 0.02);
  const int middle = (left + right) / 2;
  EXPECT_GT(picture.at(middle, top + 60)[0], picture.at(middle, bottom - 30)[0] + 40);
}

TEST(Picture, ColoursByValueWithALegend) {
  Picture picture = of_ball();
  for (const Eigen::Vector3f& v : picture.views[0].meshes[0].mesh.vertices)
    picture.views[0].meshes[0].mesh.values.push_back(v.x() > 0.0F ? 1.0F : 0.0F);
  picture.mesh_values = {"side, 1", 0.0, 1.0, ColourMap::deviation};
  picture.camera.from = {0.0, -1.0, 0.0};
  picture.width = 360;
  const auto path = scratch("values.png");
  draw(picture, path);
  const DecodedPng decoded = decode(path);
  // x runs to the right: blue on the left, red on the right of the ball.
  const int middle = static_cast<int>(2 * 16 + 0.5 * (decoded.width - 2 * (16 + 118)));
  EXPECT_GT(decoded.at(middle - 60, 180)[2], decoded.at(middle - 60, 180)[0] + 60);
  EXPECT_GT(decoded.at(middle + 60, 180)[0], decoded.at(middle + 60, 180)[2] + 60);
  // The bar of the legend carries the map's colours as they are, unshaded.
  EXPECT_GT(decoded.count(stops(ColourMap::deviation)[4]), 10);
}

TEST(Picture, APathShowsThroughTheBoneBeforeIt) {
  const auto plain_path = scratch("plain.png");
  Picture picture = of_ball();
  draw(picture, plain_path);
  picture.views[0].lines = {
      {{Vector3(-8.0, 0.0, 0.0) * mm, Vector3(8.0, 0.0, 0.0) * mm}, {0.0, 1.0}}};
  picture.line_values = {"force, N", 0.0, 1.0};
  picture.camera = {};
  const auto path = scratch("path.png");
  draw(picture, path);
  const DecodedPng with = decode(path);
  int green = 0;
  for (const auto& pixel : with.pixels) green += pixel[1] > pixel[0] + 25 ? 1 : 0;
  EXPECT_GT(green, 500);
}

TEST(Picture, IsTheSameOnAnyNumberOfThreads) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  draw(of_ball(), scratch("one.png"));
  {
    const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 4);
    draw(of_ball(), scratch("many.png"));
  }
  EXPECT_TRUE(read_text_file(scratch("one.png")) == read_text_file(scratch("many.png")));
}

TEST(Picture, PerspectiveAndSeveralViewsAreDrawn) {
  Picture picture = of_ball();
  picture.title = "Größe: 10 mm";
  picture.views = {{"before", {{ball()}}}, {"after", {{ball()}}}};
  picture.camera.field_of_view_deg = 30.0;
  picture.width = 400;
  draw(picture, scratch("two.png"));
  const DecodedPng decoded = decode(scratch("two.png"));
  EXPECT_FALSE(white(decoded.at(200, 200)));
  EXPECT_FALSE(white(decoded.at(600, 200)));
  EXPECT_TRUE(white(decoded.at(400, 200)));
}

TEST(Picture, SaysWhatIsWrongAndLeavesNoFile) {
  std::vector<Picture> bad(7, of_ball());
  bad[0].views.clear();
  bad[1].views[0].meshes.clear();
  bad[2].views[0].meshes[0].mesh.triangles[0][0] = 1u << 30;
  bad[3].views[0].meshes[0].mesh.values = {1.0F};
  bad[4].camera.from = {0.0, 0.0, 1.0};
  bad[5].views[0].meshes[0].mesh.vertices[0].x() = std::numeric_limits<float>::quiet_NaN();
  bad[6].views[0].lines = {{{Vector3::Zero(), Vector3::UnitX()}, {1.0}}};
  for (std::size_t i = 0; i < bad.size(); ++i)
    EXPECT_THROW(draw(bad[i], scratch("bad.png")), InvalidInput) << i;
  EXPECT_FALSE(std::filesystem::exists(scratch("bad.png")));
  EXPECT_THROW(draw(of_ball(), scratch("no such folder/ball.png")), WorldError);
}

}  // namespace
}  // namespace osteomill::io
