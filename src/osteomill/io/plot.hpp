// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/io/colour.hpp"

/// Plots by gnuplot. Values are drawn as they are given: the caller brings them to the unit that
/// the axis names ("force, N"). A value that is not finite is a gap. The suffix of the file chooses
/// the format: .png (two pixels a point), .svg, .pdf. InvalidInput when the data do not fit
/// together, WorldError when gnuplot is missing or the file cannot be written.
namespace osteomill::io {

struct Axis {
  std::string label;  ///< with the unit: "feed, mm/s"
  std::optional<double> low{};
  std::optional<double> high{};
  bool logarithmic = false;
};

enum class Mark { line, dashed, steps, points, line_points };

/// One curve.
struct Series {
  std::string label;  ///< in the legend; empty: not in the legend
  std::vector<double> x;
  std::vector<double> y;
  Mark mark = Mark::line;
  std::vector<double> error{};          ///< half length of error bars, one a point, or empty
  std::optional<std::size_t> colour{};  ///< of the palette; otherwise by order
};

/// A filled region between two curves, such as a confidence interval.
struct Band {
  std::string label;
  std::vector<double> x;
  std::vector<double> low;
  std::vector<double> high;
  std::optional<std::size_t> colour{};
};

/// A dashed line across the panel at a value of y, with its name beside it.
struct Limit {
  double y = 0.0;
  std::string label;
};

/// A shaded range of x with its name on top.
struct Interval {
  double low = 0.0;
  double high = 0.0;
  std::string label;
};

/// One diagram of a stack.
struct Panel {
  Axis y;
  std::vector<Series> series;
  std::vector<Limit> limits{};
  std::vector<Interval> intervals{};
  std::vector<Band> bands{};
  double share_of_height = 1.0;
};

/// Panels one above the other that share the x axis.
struct LinePlot {
  std::string title;
  Axis x;
  std::vector<Panel> panels;
  int width = 800;   ///< points
  int height = 450;  ///< points
};

/// Values over a regular grid.
struct HeatMap {
  std::string title;
  Axis x;
  Axis y;
  std::string value_label;
  std::vector<double> x_centres;  ///< evenly spaced
  std::vector<double> y_centres;  ///< evenly spaced
  std::vector<double> values;     ///< x runs fastest
  std::optional<double> low{};    ///< of the colours
  std::optional<double> high{};
  ColourMap colours = ColourMap::viridis;
  std::vector<double> contours{};  ///< lines at these values
  std::vector<Series> series{};    ///< over the map: measured points, a chosen condition
  int width = 640;
  int height = 480;
};

/// Curves over an angle.
struct PolarPlot {
  std::string title;
  std::string radius_label;
  std::vector<Series> series;  ///< x: angle, degrees; y: radius
  bool zero_on_top = false;    ///< otherwise on the right
  bool clockwise = false;
  std::optional<double> radius_high{};
  int width = 560;
  int height = 520;
};

/// Groups of bars: one value a category from each series.
struct Bars {
  std::string label;
  std::vector<double> values;
  std::vector<double> errors{};  ///< half length of error bars, or empty
};
struct BarChart {
  std::string title;
  Axis y;
  std::vector<std::string> categories;
  std::vector<Bars> series;
  std::vector<Limit> limits{};
  int width = 640;
  int height = 400;
};

void draw(const LinePlot& plot, const std::filesystem::path& path);
void draw(const HeatMap& plot, const std::filesystem::path& path);
void draw(const PolarPlot& plot, const std::filesystem::path& path);
void draw(const BarChart& plot, const std::filesystem::path& path);

}  // namespace osteomill::io
