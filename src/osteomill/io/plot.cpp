// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/io/gnuplot.hpp"

namespace osteomill::io {
namespace {

using gnuplot::font;

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double v) {
    if (!std::isfinite(v)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  bool empty() const { return low > high; }
};

void require(bool holds, const std::string& field, const std::string& value,
             const std::string& rule) {
  if (!holds) throw InvalidInput({"plot." + field, value, rule, ""});
}

void check(const Series& series) {
  require(series.x.size() == series.y.size(), "series",
          fmt::format("{}: {} x, {} y", series.label, series.x.size(), series.y.size()),
          "must have as many x as y");
  require(series.error.empty() || series.error.size() == series.y.size(), "series.error",
          fmt::format("{} for {} points", series.error.size(), series.y.size()),
          "must be empty or one a point");
}

/// A long record drawn as a line keeps the lowest and the highest value of each column of pixels.
Series thinned(const Series& series, int columns) {
  const std::size_t bins = static_cast<std::size_t>(columns) * 2;
  const std::size_t count = series.x.size();
  if (count <= bins * 4 || !series.error.empty() || series.mark == Mark::points ||
      series.mark == Mark::line_points || !std::is_sorted(series.x.begin(), series.x.end()))
    return series;
  Series out = series;
  out.x.clear();
  out.y.clear();
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const auto begin = series.y.begin() + static_cast<std::ptrdiff_t>(bin * count / bins);
    const auto end = series.y.begin() + static_cast<std::ptrdiff_t>((bin + 1) * count / bins);
    const auto [low, high] = std::minmax_element(begin, end);
    for (const auto& at : {std::min(low, high), std::max(low, high)}) {
      out.x.push_back(series.x[static_cast<std::size_t>(at - series.y.begin())]);
      out.y.push_back(*at);
    }
  }
  return out;
}

/// "[low:high]" with air above and below, from zero where that is near.
std::string range_of(const Axis& axis, Range data, double margin) {
  if (data.empty()) data = {0.0, 1.0};
  double low = data.low;
  double high = data.high;
  if (axis.logarithmic) {
    require(axis.low.value_or(low) > 0.0, "axis", axis.label,
            "a logarithmic axis needs values above 0");
    low /= 1.0 + margin;
    high *= 1.0 + margin;
  } else if (margin > 0.0) {
    const double span = high > low ? high - low : std::max(1.0, std::abs(high));
    const bool from_zero = low >= 0.0 && low < 0.4 * high;
    const bool to_zero = high <= 0.0 && high > 0.4 * low;
    low = from_zero ? 0.0 : low - margin * span;
    high = to_zero ? 0.0 : high + margin * span;
  }
  if (!(low < high)) high = low + std::max(1.0, std::abs(low));
  return fmt::format("[{:.9g}:{:.9g}]", axis.low.value_or(low), axis.high.value_or(high));
}

std::string style_of(const Series& series, std::size_t order) {
  const std::string colour = hex(palette(series.colour.value_or(order)));
  const std::string line = fmt::format("lc rgb '{}' lw 1.25", colour);
  const std::string point = fmt::format("pt 7 ps 0.45 lc rgb '{}'", colour);
  switch (series.mark) {
    case Mark::line:
      return "with lines " + line;
    case Mark::dashed:
      return "with lines dt (14,8) " + line;
    case Mark::steps:
      return "with steps " + line;
    case Mark::points:
      return "with points " + point;
    case Mark::line_points:
      return "with linespoints lw 1.25 " + point;
  }
  return "with lines";
}

/// Data blocks and plot elements of some curves.
struct Elements {
  std::string blocks;
  std::vector<std::string> plots;

  void add(const Series& given, std::size_t order, int width, const std::string& name) {
    check(given);
    if (given.x.empty()) return;
    const Series series = thinned(given, width);
    const std::string title =
        series.label.empty() ? "notitle" : "title " + gnuplot::quoted(series.label);
    if (series.error.empty()) {
      blocks += gnuplot::data_block(name, {&series.x, &series.y});
    } else {
      blocks += gnuplot::data_block(name, {&series.x, &series.y, &series.error});
      plots.push_back(fmt::format(
          "${} using 1:($2-$3):(0):(2*$3) with vectors nohead lw 0.9 lc rgb '{}' notitle", name,
          hex(palette(series.colour.value_or(order)))));
    }
    plots.push_back(fmt::format("${} using 1:2 {} {}", name, style_of(series, order), title));
  }

  std::string command() const {
    // Nothing to draw still shows the axes, out of their range.
    return plots.empty() ? "plot NaN notitle\n"
                         : "plot " + fmt::format("{}", fmt::join(plots, ", \\\n  ")) + "\n";
  }
};

std::string labelled(const char* which, const Axis& axis) {
  return fmt::format("set {}label {} textcolor rgb '#222222'\n{}", which,
                     gnuplot::quoted(axis.label),
                     axis.logarithmic ? fmt::format("set logscale {}\n", which) : "");
}

std::string title_line(const std::string& title, const std::filesystem::path& path, double height) {
  if (title.empty()) return "";
  return fmt::format(
      "set label 1000 {} at screen 0.5, screen {} center textcolor rgb '#111111' {}\n",
      gnuplot::quoted(title), 1.0 - 17.0 / height, font(path, 10.5));
}

std::string limit_lines(const std::vector<Limit>& limits, const std::filesystem::path& path) {
  std::string out;
  for (std::size_t i = 0; i < limits.size(); ++i)
    out += fmt::format(
        "set arrow {0} from graph 0, first {1:.9g} to graph 1, first {1:.9g} nohead front dt "
        "(12,8) "
        "lc rgb '#444444' lw 0.9\n"
        "set label {0} {2} at graph 0.995, first {1:.9g} right offset 0,0.5 front boxed textcolor "
        "rgb "
        "'#444444' {3}\n",
        i + 1, limits[i].y, gnuplot::quoted(limits[i].label), font(path, 7));
  return out;
}

}  // namespace

void draw(const LinePlot& plot, const std::filesystem::path& path) {
  require(!plot.panels.empty(), "panels", "0", "must be one or more");
  Range x;
  double shares = 0.0;
  for (const Panel& panel : plot.panels) {
    for (const Series& series : panel.series)
      for (const double v : series.x) x.add(v);
    for (const Band& band : panel.bands)
      for (const double v : band.x) x.add(v);
    shares += panel.share_of_height;
  }
  const double width = plot.width;
  const double height = plot.height;
  const double top = plot.title.empty() ? 24.0 : 50.0;
  const double bottom = 50.0;
  const double gap = 26.0;
  const double free = height - top - bottom - gap * static_cast<double>(plot.panels.size() - 1);
  require(free > 30.0, "height", fmt::format("{}", plot.height), "is too low for its panels");

  std::string script = gnuplot::prologue(path, plot.width, plot.height);
  script += fmt::format("set lmargin at screen {}\nset rmargin at screen {}\nset xrange {}\n",
                        78.0 / width, 1.0 - 20.0 / width, range_of(plot.x, x, 0.0));
  script += "set multiplot\n" + title_line(plot.title, path, height);
  double upper = height - top;
  for (std::size_t p = 0; p < plot.panels.size(); ++p) {
    const Panel& panel = plot.panels[p];
    const double lower = upper - free * panel.share_of_height / shares;
    const bool last = p + 1 == plot.panels.size();
    Range y;
    Elements elements;
    for (std::size_t b = 0; b < panel.bands.size(); ++b) {
      const Band& band = panel.bands[b];
      require(band.x.size() == band.low.size() && band.x.size() == band.high.size(), "bands",
              band.label, "must have as many x as low and high");
      for (const double v : band.low) y.add(v);
      for (const double v : band.high) y.add(v);
      const std::string name = fmt::format("b{}_{}", p, b);
      elements.blocks += gnuplot::data_block(name, {&band.x, &band.low, &band.high});
      elements.plots.push_back(fmt::format(
          "${} using 1:2:3 with filledcurves fs transparent solid 0.22 noborder lc rgb '{}' {}",
          name, hex(palette(band.colour.value_or(b))),
          band.label.empty() ? "notitle" : "title " + gnuplot::quoted(band.label)));
    }
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
      const Series& series = panel.series[s];
      elements.add(series, s, plot.width, fmt::format("s{}_{}", p, s));
      for (std::size_t i = 0; i < series.y.size(); ++i) {
        const double error = series.error.empty() ? 0.0 : series.error[i];
        if (panel.y.logarithmic && series.y[i] <= 0.0) continue;
        y.add(series.y[i] + error);
        if (!panel.y.logarithmic || series.y[i] > error) y.add(series.y[i] - error);
      }
    }
    for (const Limit& limit : panel.limits) y.add(limit.y);

    script += elements.blocks;
    script += fmt::format("set tmargin at screen {}\nset bmargin at screen {}\n", upper / height,
                          lower / height);
    script += "unset logscale\n" + labelled("y", panel.y) +
              fmt::format("set yrange {}\n", range_of(panel.y, y, 0.06));
    if (plot.x.logarithmic) script += "set logscale x\n";
    script += last ? labelled("x", plot.x) + "set format x\n" : "unset xlabel\nset format x ''\n";
    script += "set key at graph 1, graph 1 right bottom horizontal samplen 1.6 maxrows 1 " +
              font(path, 8) + "\n";
    script += limit_lines(panel.limits, path);
    for (std::size_t i = 0; i < panel.intervals.size(); ++i) {
      const Interval& shade = panel.intervals[i];
      script += fmt::format(
          "set object {0} rectangle from first {1:.9g}, graph 0 to first {2:.9g}, graph 1 behind "
          "fc rgb '#ececec' fs solid 1.0 noborder\n"
          "set label {3} {4} at first {5:.9g}, graph 0.97 center front textcolor rgb '#777777' "
          "{6}\n",
          i + 1, shade.low, shade.high, 200 + i, gnuplot::quoted(shade.label),
          0.5 * (shade.low + shade.high), font(path, 7));
    }
    script += elements.command() + "unset arrow\nunset object\nunset label\n";
    upper = lower - gap;
  }
  gnuplot::run(script + "unset multiplot\n", path);
}

void draw(const HeatMap& map, const std::filesystem::path& path) {
  const auto step = [](const std::vector<double>& at, const char* field) {
    require(at.size() >= 2, field, fmt::format("{}", at.size()), "must be two or more");
    const double mean = (at.back() - at.front()) / static_cast<double>(at.size() - 1);
    for (std::size_t i = 1; i < at.size(); ++i)
      require(std::abs(at[i] - at[i - 1] - mean) <= 1e-3 * std::abs(mean) && mean != 0.0, field,
              fmt::format("{} after {}", at[i], at[i - 1]), "must be evenly spaced");
    return mean;
  };
  const double dx = step(map.x_centres, "x_centres");
  const double dy = step(map.y_centres, "y_centres");
  require(map.values.size() == map.x_centres.size() * map.y_centres.size(), "values",
          fmt::format("{}", map.values.size()), "must be one a cell");
  std::string script = gnuplot::prologue(path, map.width, map.height);
  std::string block = "$map << EOD\n";
  for (std::size_t j = 0; j < map.y_centres.size(); ++j) {
    for (std::size_t i = 0; i < map.x_centres.size(); ++i)
      block += fmt::format("{:.7g} {:.7g} {:.7g}\n", map.x_centres[i], map.y_centres[j],
                           map.values[j * map.x_centres.size() + i]);
    block += "\n";
  }
  script += block + "EOD\n";
  Range values;
  for (const double v : map.values) values.add(v);
  if (values.empty()) values = {0.0, 1.0};
  if (map.colours == ColourMap::deviation) {
    const double most = std::max(std::abs(values.low), std::abs(values.high));
    values = {-most, most};
  }
  std::vector<std::string> colours;
  colours.reserve(stops(map.colours).size());
  for (std::size_t i = 0; i < stops(map.colours).size(); ++i)
    colours.push_back(fmt::format("{} '{}'", i, hex(stops(map.colours)[i])));
  script += fmt::format("set palette defined ({})\nset cbrange {}\n", fmt::join(colours, ", "),
                        range_of({"", map.low, map.high}, values, 0.0));
  Elements elements;
  // Files of shapes get rectangles; gnuplot would put an image into a file of its own.
  elements.plots.push_back(fmt::format("$map using 1:2:3 with image{} notitle",
                                       path.extension() == ".svg" ? " pixels" : ""));
  if (!map.contours.empty()) {
    // A table of lines, drawn once as lines and once as one value a line.
    script += fmt::format(
        "set contour base\nset cntrparam levels discrete {:.9g}\nunset surface\n"
        "set cntrlabel onecolor\nset table $lines\nsplot $map using 1:2:3 notitle\n"
        "unset table\nunset contour\nset surface\n",
        fmt::join(map.contours, ", "));
    elements.plots.push_back("$lines using 1:2 with lines lw 1 lc rgb '#ffffff' notitle");
    elements.plots.push_back(
        "$lines using 1:2:3 every 1000000::8 with labels offset 0,0.5 textcolor rgb '#ffffff' " +
        font(path, 7) + " notitle");
  }
  for (std::size_t s = 0; s < map.series.size(); ++s)
    elements.add(map.series[s], s + 1, map.width, fmt::format("s{}", s));
  const Axis x{map.x.label, map.x.low.value_or(map.x_centres.front() - 0.5 * dx),
               map.x.high.value_or(map.x_centres.back() + 0.5 * dx), map.x.logarithmic};
  const Axis y{map.y.label, map.y.low.value_or(map.y_centres.front() - 0.5 * dy),
               map.y.high.value_or(map.y_centres.back() + 0.5 * dy), map.y.logarithmic};
  script += fmt::format(
      "set lmargin at screen {}\nset rmargin at screen {}\nset tmargin at screen {}\nset bmargin "
      "at "
      "screen {}\nset colorbox noborder\nset cbtics scale 0.4\nset cblabel {}\nunset grid\n"
      "set style fill solid 1.0 noborder\n",
      78.0 / map.width, 1.0 - 112.0 / map.width,
      1.0 - (map.title.empty() ? 24.0 : 50.0) / map.height, 50.0 / map.height,
      gnuplot::quoted(map.value_label));
  script +=
      labelled("x", x) + labelled("y", y) + title_line(map.title, path, map.height) +
      fmt::format("set xrange {}\nset yrange {}\n", range_of(x, {}, 0.0), range_of(y, {}, 0.0)) +
      "set key at graph 1, graph 1 right bottom horizontal samplen 1.6\n";
  gnuplot::run(script + elements.blocks + elements.command(), path);
}

void draw(const PolarPlot& plot, const std::filesystem::path& path) {
  Range radius;
  radius.add(0.0);
  Elements elements;
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    for (const double v : plot.series[s].y) {
      require(!(v < 0.0), "series.y", fmt::format("{}", v), "a radius must not be below 0");
      radius.add(v);
    }
    elements.add(plot.series[s], s, plot.width, fmt::format("s{}", s));
  }
  std::string script = gnuplot::prologue(path, plot.width, plot.height);
  script += fmt::format(
      "set polar\nset angles degrees\nset theta {} {}\nunset border\nunset xtics\nunset ytics\n"
      "unset raxis\nset size square\nset rrange {}\nset rtics axis scale 0 textcolor rgb '#777777' "
      "{}\n"
      "set ttics 0,30 format '%g°' scale 0\nset grid polar 30 lt 1 lc rgb '#dddddd' lw 0.5\n"
      "set tmargin at screen {}\nset bmargin at screen 0.11\n"
      "set key at screen 0.98, screen 0.03 right bottom horizontal samplen 1.6\n",
      plot.zero_on_top ? "top" : "right", plot.clockwise ? "clockwise" : "counterclockwise",
      range_of({"", 0.0, plot.radius_high}, radius, 0.06), font(path, 7),
      plot.title.empty() ? 0.95 : 0.88);
  script +=
      title_line(plot.title, path, plot.height) +
      fmt::format("set label 1001 {} at screen 0.02, screen 0.04 left textcolor rgb '#222222'\n",
                  gnuplot::quoted(plot.radius_label));
  gnuplot::run(script + elements.blocks + elements.command(), path);
}

void draw(const BarChart& chart, const std::filesystem::path& path) {
  require(!chart.categories.empty() && !chart.series.empty(), "series", "0",
          "must be one or more, over one or more categories");
  const double group = 0.8;
  const double bar = group / static_cast<double>(chart.series.size());
  Range y;
  y.add(0.0);
  Elements elements;
  for (std::size_t s = 0; s < chart.series.size(); ++s) {
    const Bars& bars = chart.series[s];
    require(bars.values.size() == chart.categories.size(), "series.values",
            fmt::format("{}: {}", bars.label, bars.values.size()), "must be one a category");
    require(bars.errors.empty() || bars.errors.size() == bars.values.size(), "series.errors",
            fmt::format("{}: {}", bars.label, bars.errors.size()), "must be empty or one a value");
    std::vector<double> x;
    for (std::size_t c = 0; c < bars.values.size(); ++c) {
      x.push_back(static_cast<double>(c) - 0.5 * group + bar * (static_cast<double>(s) + 0.5));
      const double error = bars.errors.empty() ? 0.0 : bars.errors[c];
      y.add(bars.values[c] + error);
      y.add(bars.values[c] - error);
    }
    const std::string name = fmt::format("s{}", s);
    const std::string title =
        bars.label.empty() ? "notitle" : "title " + gnuplot::quoted(bars.label);
    std::vector<const std::vector<double>*> columns = {&x, &bars.values};
    if (!bars.errors.empty()) columns.push_back(&bars.errors);
    elements.blocks += gnuplot::data_block(name, columns);
    elements.plots.push_back(
        fmt::format("${} using 1:2:({}) with boxes fs solid 0.85 noborder lc rgb '{}' {}", name,
                    0.92 * bar, hex(palette(s)), title));
    if (!bars.errors.empty())
      elements.plots.push_back(fmt::format(
          "${} using 1:($2-$3):(0):(2*$3) with vectors nohead lw 0.9 lc rgb '#222222' notitle",
          name));
  }
  for (const Limit& limit : chart.limits) y.add(limit.y);
  std::vector<std::string> tics;
  tics.reserve(chart.categories.size());
  for (std::size_t c = 0; c < chart.categories.size(); ++c)
    tics.push_back(fmt::format("{} {}", gnuplot::quoted(chart.categories[c]), c));
  std::string script = gnuplot::prologue(path, chart.width, chart.height);
  script += fmt::format(
      "set lmargin at screen {}\nset rmargin at screen {}\nset tmargin at screen {}\nset bmargin "
      "at "
      "screen {}\nset xtics ({}) scale 0\nset xrange [-0.6:{}]\nset yrange {}\nset grid noxtics\n"
      "set key at graph 1, graph 1 right bottom horizontal samplen 1.2\n"
      "set xzeroaxis lt 1 lc rgb '#555555' lw 0.75\n",
      78.0 / chart.width, 1.0 - 20.0 / chart.width,
      1.0 - (chart.title.empty() ? 24.0 : 50.0) / chart.height, 34.0 / chart.height,
      fmt::join(tics, ", "), static_cast<double>(chart.categories.size()) - 0.4,
      range_of(chart.y, y, 0.06));
  script += labelled("y", chart.y) + title_line(chart.title, path, chart.height) +
            limit_lines(chart.limits, path);
  gnuplot::run(script + elements.blocks + elements.command(), path);
}

}  // namespace osteomill::io
