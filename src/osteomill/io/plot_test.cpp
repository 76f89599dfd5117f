// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "osteomill/base/error.hpp"
#include "osteomill/io/gnuplot.hpp"
#include "osteomill/io/pending_file.hpp"
#include "osteomill/io/png_for_test.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

LinePlot two_panels() {
  LinePlot plot;
  plot.title = "Force and feed";
  plot.x.label = "time, s";
  Series force{"it's the force", {}, {}};
  for (int i = 0; i < 200000; ++i) {
    force.x.push_back(i * 1e-3);
    force.y.push_back(i == 100000 ? 50.0 : 10.0 + std::sin(i * 0.3));
  }
  plot.panels = {
      Panel{{"force, N"}, {force}, {{20.0, "limit"}}, {{20.0, 60.0, "line 1"}}},
      Panel{{"feed, mm/s"}, {{"feed", {0.0, 100.0, 200.0}, {3.0, 12.0, 3.0}, Mark::steps, {}, 1}}}};
  return plot;
}

TEST(Plot, DrawsEveryCurveInItsColourAtTwoPixelsAPoint) {
  const auto path = scratch("lines.png");
  draw(two_panels(), path);
  const DecodedPng picture = decode(path);
  EXPECT_EQ(picture.width, 1600);
  EXPECT_EQ(picture.height, 900);
  // A line is at least two pixels wide and crosses a diagram of some 1400 pixels.
  EXPECT_GT(picture.count(palette(0)), 2000);
  EXPECT_GT(picture.count(palette(1)), 1400);
}

TEST(Plot, KeepsASinglePeakOfALongRecord) {
  const auto path = scratch("peak.svg");
  draw(two_panels(), path);
  const std::string svg = read_text_file(path);
  // 200 000 points on 800 columns are thinned, and the one peak of 50 N among 10 N sets the axis.
  EXPECT_LT(svg.size(), 400000u);
  EXPECT_NE(svg.find("> 50<"), std::string::npos);
  EXPECT_NE(svg.find("it's the force"), std::string::npos);
}

TEST(Plot, DrawsGapsEmptyCurvesBandsAndLogarithmicAxes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LinePlot plot;
  plot.x = {"frequency, Hz", {}, {}, true};
  plot.panels = {Panel{{"receptance, µm/N", {}, {}, true},
                       {{"gap", {1.0, 10.0, 100.0}, {1e-3, nan, 1.0}, Mark::line_points},
                        {"nothing", {}, {}},
                        {"measured", {2.0, 20.0}, {1e-2, 0.3}, Mark::points, {1e-3, 0.05}}},
                       {},
                       {},
                       {{"95 %", {1.0, 100.0}, {5e-4, 0.5}, {2e-3, 2.0}}}}};
  const auto path = scratch("log.png");
  draw(plot, path);
  EXPECT_GT(decode(path).count(palette(2)), 50);
}

TEST(HeatMap, ShowsItsValuesInTheColoursOfTheMap) {
  HeatMap map;
  map.title = "Normal force";
  map.x.label = "angle, deg";
  map.y.label = "depth, mm";
  map.value_label = "force, N";
  map.x_centres = {0.0, 1.0, 2.0, 3.0};
  map.y_centres = {0.0, 5.0, 10.0};
  for (int i = 0; i < 12; ++i) map.values.push_back(i % 4 < 2 ? 0.0 : 8.0);
  map.contours = {4.0};
  map.series = {{"chosen", {0.5}, {5.0}, Mark::points}};
  const auto path = scratch("heat.png");
  draw(map, path);
  const DecodedPng picture = decode(path);
  // Half of some 890 x 760 pixels each.
  EXPECT_GT(picture.count(colour_at(ColourMap::viridis, 0.0)), 200000);
  EXPECT_GT(picture.count(colour_at(ColourMap::viridis, 1.0)), 200000);
}

TEST(PolarPlot, IsDrawn) {
  PolarPlot plot;
  plot.title = "Force over one revolution";
  plot.radius_label = "radius: force, N";
  plot.zero_on_top = plot.clockwise = true;
  plot.series = {{"tangential", {0.0, 90.0, 180.0, 270.0, 360.0}, {1.0, 2.0, 1.0, 2.0, 1.0}}};
  const auto path = scratch("polar.png");
  draw(plot, path);
  EXPECT_GT(decode(path).count(palette(0)), 500);
}

TEST(BarChart, ABarIsAsHighAsItsValue) {
  BarChart chart;
  chart.y.label = "error, deg";
  chart.categories = {"distal", "anterior"};
  chart.series = {{"robot", {1.0, 1.0}}, {"jig", {2.0, 2.0}, {0.1, 0.2}}};
  chart.limits = {{1.5, "limit"}};
  const auto path = scratch("bars.png");
  draw(chart, path);
  const DecodedPng picture = decode(path);
  // Fill of 0.85 over white; error bars, the limit and its label hide a little of the higher bars.
  const auto mixed = [](Colour c) {
    for (float& v : c) v = 0.85F * v + 0.15F;
    return c;
  };
  const double low = static_cast<double>(picture.count(mixed(palette(0))));
  const double high = static_cast<double>(picture.count(mixed(palette(1))));
  EXPECT_GT(low, 10000.0);
  EXPECT_NEAR(high / low, 2.0, 0.06);
}

TEST(Plot, SaysWhatIsWrongAndLeavesNoFile) {
  struct Bad {
    const char* what;
    std::function<void(const std::filesystem::path&)> make;
    const char* message;
  };
  const std::vector<Bad> table = {
      {"uneven",
       [](const auto& path) {
         LinePlot plot;
         plot.panels = {Panel{{"y"}, {{"a", {1.0, 2.0}, {1.0}}}}};
         draw(plot, path);
       },
       "2 x, 1 y"},
      {"no panels", [](const auto& path) { draw(LinePlot{}, path); }, "one or more"},
      {"log of zero",
       [](const auto& path) {
         LinePlot plot;
         plot.x.logarithmic = true;
         plot.panels = {Panel{{"y"}, {{"a", {0.0, 2.0}, {1.0, 1.0}}}}};
         draw(plot, path);
       },
       "above 0"},
      {"uneven map",
       [](const auto& path) {
         HeatMap map;
         map.x_centres = {0.0, 1.0, 3.0};
         map.y_centres = {0.0, 1.0};
         map.values.resize(6);
         draw(map, path);
       },
       "evenly spaced"},
      {"negative radius",
       [](const auto& path) {
         PolarPlot plot;
         plot.series = {{"a", {0.0}, {-1.0}}};
         draw(plot, path);
       },
       "radius"},
      {"bars",
       [](const auto& path) {
         BarChart chart;
         chart.categories = {"a", "b"};
         chart.series = {{"c", {1.0}}};
         draw(chart, path);
       },
       "one a category"}};
  for (const Bad& bad : table) {
    const auto path = scratch("bad.png");
    try {
      bad.make(path);
      FAIL() << bad.what;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(bad.message)) << bad.what;
    }
    EXPECT_FALSE(std::filesystem::exists(path)) << bad.what;
  }
  EXPECT_THROW(draw(two_panels(), scratch("plot.bmp")), InvalidInput);
  EXPECT_THROW(draw(two_panels(), scratch("no such folder/plot.png")), WorldError);
}

TEST(Gnuplot, PassesOnWhatGnuplotComplainsAboutAndLeavesNothing) {
  const auto path = scratch("broken.png");
  try {
    gnuplot::run("set no such thing", path);
    FAIL();
  } catch (const WorldError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("set no such thing"));
  }
  for (const auto& entry : std::filesystem::directory_iterator(path.parent_path()))
    EXPECT_THAT(entry.path().filename().string(), testing::Not(testing::HasSubstr("broken")));
}

TEST(Colour, MapsRunFromEndToEndAndHoldThere) {
  for (const ColourMap map : {ColourMap::viridis, ColourMap::deviation, ColourMap::bone}) {
    EXPECT_EQ(colour_at(map, -1.0), stops(map).front());
    EXPECT_EQ(colour_at(map, 2.0), stops(map).back());
  }
  EXPECT_EQ(hex(palette(0)), "#0072b2");
  std::set<std::string> kinds;
  for (std::size_t i = 0; i < 8; ++i) kinds.insert(hex(palette(i)));
  EXPECT_EQ(kinds.size(), 8u);
}

TEST(PendingFile, AppearsWholeOrNotAtAll) {
  const auto path = scratch("pending.txt");
  write_text_file(path, "old");
  {
    PendingFile half(path);
    EXPECT_EQ(read_text_file(path), "old");
  }
  EXPECT_EQ(read_text_file(path), "old");
  write_text_file(path, "new");
  EXPECT_EQ(read_text_file(path), "new");
  EXPECT_THROW(read_text_file(scratch("absent.txt")), InvalidInput);
  EXPECT_THROW(write_text_file(scratch("absent/file.txt"), ""), WorldError);
}

}  // namespace
}  // namespace osteomill::io
