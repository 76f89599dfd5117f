// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/robot_drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "osteomill/base/units.hpp"
#include "osteomill/io/colour.hpp"
#include "osteomill/io/gnuplot.hpp"
#include "osteomill/io/plot.hpp"

namespace osteomill::io {
namespace {

using robot::Vector2;
using units::mm;

struct Bounds {
  Vector2 low = Vector2::Constant(std::numeric_limits<double>::infinity());
  Vector2 high = Vector2::Constant(-std::numeric_limits<double>::infinity());
  void add(const Vector2& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

/// Drawn as one looks at a standing knee from the side: anterior (y) to the left, distal (x) down.
Vector2 on_paper(const Vector2& p) { return Vector2(-p.y(), -p.x()) / mm; }

std::string block(const std::string& name, const std::vector<Vector2>& points) {
  std::vector<double> x;
  std::vector<double> y;
  for (const Vector2& p : points) {
    x.push_back(on_paper(p).x());
    y.push_back(on_paper(p).y());
  }
  return gnuplot::data_block(name, {&x, &y});
}

std::string words(robot::Cut cut) {
  std::string text = robot::name(cut);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

}  // namespace

void draw_poses(const robot::Profile& profile, const robot::CutOptions& cuts,
                const robot::BoneOutline& bone, const std::vector<PoseDrawing>& steps,
                const std::string& title, const std::filesystem::path& path) {
  const auto lines = robot::cut_lines(profile, cuts);
  const auto edges = robot::cut_lines(profile, {.distal_overhang = cuts.distal_overhang});
  Bounds bounds;
  for (const Vector2& p : bone) bounds.add(on_paper(p));
  for (const PoseDrawing& step : steps) {
    for (const Vector2& p : step.points) bounds.add(on_paper(p));
  }
  const Vector2 margin = Vector2::Constant(9.0);
  bounds.low -= margin;
  bounds.high += margin;

  const double panel_width = 300.0;
  const double shape = (bounds.high.y() - bounds.low.y()) / (bounds.high.x() - bounds.low.x());
  const double panel_height = panel_width * shape + 30.0;
  std::string script = gnuplot::prologue(path, static_cast<int>(3.0 * panel_width),
                                         static_cast<int>(2.0 * panel_height) + 40);
  fmt::format_to(std::back_inserter(script),
                 "set multiplot title {}\n"
                 "set size ratio -1\nunset border\nunset tics\nunset grid\n"
                 "set xrange [{}:{}]\nset yrange [{}:{}]\n"
                 "set lmargin 0\nset rmargin 0\nset bmargin 0\nset tmargin 0\n",
                 gnuplot::quoted(title), bounds.low.x(), bounds.high.x(), bounds.low.y(),
                 bounds.high.y());
  robot::BoneOutline left = bone;
  const std::vector<Vector2> corners(profile.corners.begin(), profile.corners.end());
  script += block("profile", corners);
  const double head = 40.0 / (2.0 * panel_height + 40.0);
  const double row = (1.0 - head) / 2.0;
  for (std::size_t i = 0; i <= steps.size(); ++i) {
    const std::size_t column = i % 3;
    const std::size_t line = i / 3;
    fmt::format_to(std::back_inserter(script), "set origin {},{}\nset size {},{}\n",
                   static_cast<double>(column) / 3.0, (1.0 - static_cast<double>(line)) * row,
                   1.0 / 3.0, row - 22.0 / (2.0 * panel_height + 40.0));
    if (i == steps.size()) break;
    const PoseDrawing& step = steps[i];
    const robot::CutLine& cut = lines[robot::index(step.cut)];
    auto closed = left;
    closed.push_back(left.front());
    script += block(fmt::format("bone{}", i), closed);
    script += block(fmt::format("cut{}", i), {cut.entry, cut.entry + cut.length * cut.direction});
    // A cut without a pose has neither link nor guide: a point far outside keeps the plot whole.
    const std::vector<Vector2> nowhere(2, Vector2::Constant(1e3));
    const bool posed = step.points.size() >= 3;
    script += block(fmt::format("link{}", i),
                    posed ? std::vector(step.points.begin(), step.points.begin() + 2) : nowhere);
    script += block(fmt::format("guide{}", i),
                    posed ? std::vector(step.points.begin() + 1, step.points.end()) : nowhere);
    script += block(fmt::format("axes{}", i),
                    posed ? std::vector(step.points.begin(), step.points.end() - 1) : nowhere);
    fmt::format_to(
        std::back_inserter(script),
        "set title {} offset 0,-0.6\n"
        "plot $bone{} with filledcurves closed fs solid 1 noborder lc rgb '#ead9b8', "
        "$profile with lines lw 1 dt 2 lc rgb '#7a6a48', "
        "$cut{} with lines lw 1.5 lc rgb '{}', "
        "$link{} with lines lw 3 lc rgb '#8c8c8c', $guide{} with lines lw 5 lc rgb '{}', "
        "$axes{} with points pt 7 ps 0.9 lc rgb '#222222'\n",
        gnuplot::quoted(fmt::format("{} {}: gap {:.1f} mm{}", i + 1, words(step.cut),
                                    std::abs(step.gap) < 5e-5 ? 0.0 : step.gap / mm,
                                    step.trouble ? ", see text" : "")),
        i, i, hex(palette(5)), i, i, hex(palette(4)), i);
    left = robot::after_cut(left, edges[robot::index(step.cut)]);
  }
  // The sixth place explains the lines.
  fmt::format_to(
      std::back_inserter(script),
      "set title ''\nset key at screen 0.69,{} left top Left reverse samplen 3 spacing "
      "1.4\nset origin 0.667,0\n"
      "plot 1/0 with filledcurves fs solid 1 lc rgb '#ead9b8' title 'bone not yet cut', "
      "1/0 with lines dt 2 lc rgb '#7a6a48' title 'profile of the implant', "
      "1/0 with lines lw 1.5 lc rgb '{}' title 'this cut', "
      "1/0 with lines lw 3 lc rgb '#8c8c8c' title 'link from axis A1 to A2', "
      "1/0 with lines lw 5 lc rgb '{}' title 'guide from A2 to its tip', "
      "1/0 with points pt 7 ps 0.9 lc rgb '#222222' title 'axes (A1 fixed to the bone)'\n"
      "unset multiplot\n",
      row * 0.72, hex(palette(5)), hex(palette(4)));
  gnuplot::run(script, path);
}

void draw_poses(const robot::Profile& profile, const robot::CutOptions& cuts,
                const robot::BoneOutline& bone, const robot::Vector2& axis_position,
                const std::vector<robot::SequenceStep>& steps, const std::string& title,
                const std::filesystem::path& path) {
  std::vector<PoseDrawing> drawings;
  for (const robot::SequenceStep& step : steps) {
    drawings.push_back(
        {step.cut, {axis_position, step.pose.X1, step.pose.X2}, step.gap, !step.trouble.empty()});
  }
  draw_poses(profile, cuts, bone, drawings, title, path);
}

void draw_gap_map(const robot::GapMap& map, const robot::Placement& placement,
                  const std::optional<Circle>& mark, const std::string& title,
                  const std::filesystem::path& path) {
  HeatMap plot;
  plot.title = title;
  plot.x.label = "x0, distal, mm";
  plot.y.label = "y0, anterior, mm";
  plot.value_label = "largest gap, mm";
  double highest = 0.0;
  for (const double x : map.x) plot.x_centres.push_back(x / mm);
  for (const double y : map.y) plot.y_centres.push_back(y / mm);
  for (const auto& value : map.largest) {
    plot.values.push_back(value ? *value / mm : std::numeric_limits<double>::quiet_NaN());
    highest = std::max(highest, value.value_or(0.0) / mm);
  }
  plot.low = 0.0;
  plot.high = std::ceil(highest / 5.0) * 5.0;
  const double step = highest > 25.0 ? 5.0 : highest > 12.0 ? 2.0 : 1.0;
  for (double level = step; level < highest; level += step) plot.contours.push_back(level);
  if (placement.feasible) {
    Series optimum;
    optimum.label = fmt::format("optimum, {:.2f} mm", placement.largest_gap / mm);
    optimum.x = {placement.axis_position.x() / mm};
    optimum.y = {placement.axis_position.y() / mm};
    optimum.mark = Mark::points;
    optimum.colour = 5;
    plot.series.push_back(optimum);
  }
  if (mark) {
    Series circle;
    circle.label = mark->label;
    circle.mark = Mark::dashed;
    circle.colour = 4;
    for (int i = 0; i <= 180; ++i) {
      const double angle = i * std::numbers::pi / 90.0;
      circle.x.push_back((mark->centre.x() + mark->radius * std::cos(angle)) / mm);
      circle.y.push_back((mark->centre.y() + mark->radius * std::sin(angle)) / mm);
    }
    plot.series.push_back(circle);
  }
  draw(plot, path);
}

void draw_sensitivity(const robot::GuidePositioner& robot,
                      const robot::PerCut<robot::CutLine>& lines, const robot::Placement& placement,
                      const std::string& title, const std::filesystem::path& path) {
  LinePlot plot;
  plot.title = title;
  plot.x.label = "off the best place, mm";
  plot.height = 620;
  const std::pair<const char*, Vector2> ways[] = {{"moved distally: gap, mm", Vector2::UnitX()},
                                                  {"moved anteriorly: gap, mm", Vector2::UnitY()}};
  for (const auto& [label, way] : ways) {
    Panel panel;
    panel.y.label = label;
    panel.y.low = 0.0;
    for (const robot::Cut cut : robot::kCuttingOrder) {
      Series series;
      series.label = plot.panels.empty() ? words(cut) : "";
      series.colour = robot::index(cut);
      for (double off = -5.0; off <= 10.0; off += 0.05) {
        const auto gap =
            robot::gap(robot, placement.axis_position + off * mm * way, lines[robot::index(cut)],
                       placement.branches[robot::index(cut)]);
        series.x.push_back(off);
        series.y.push_back(gap && *gap >= 0.0 ? *gap / mm
                                              : std::numeric_limits<double>::quiet_NaN());
      }
      panel.series.push_back(series);
    }
    plot.panels.push_back(panel);
  }
  draw(plot, path);
}

void draw_size_study(const robot::SizeStudy& study,
                     const std::vector<std::optional<double>>& surface,
                     const robot::LinkChoice& best, const std::string& title,
                     const std::filesystem::path& path) {
  HeatMap plot;
  plot.title = title;
  plot.x.label = "L1, mm";
  plot.y.label = "L2, mm";
  plot.value_label = "gap, mm";
  for (const double l1 : study.l1) plot.x_centres.push_back(l1 / mm);
  for (const double l2 : study.l2) plot.y_centres.push_back(l2 / mm);
  double highest = 0.0;
  for (std::size_t j = 0; j < study.l2.size(); ++j) {
    for (std::size_t i = 0; i < study.l1.size(); ++i) {
      const auto& value = surface[i * study.l2.size() + j];
      plot.values.push_back(value ? *value / mm : std::numeric_limits<double>::quiet_NaN());
      highest = std::max(highest, value.value_or(0.0) / mm);
    }
  }
  plot.low = 0.0;
  const double step = highest > 25.0 ? 5.0 : 2.0;
  for (double level = step; level < highest; level += step) plot.contours.push_back(level);
  if (best.exists) {
    Series optimum;
    optimum.label =
        fmt::format("L1 {:.1f}, L2 {:.1f}: {:.2f} mm", best.l1 / mm, best.l2 / mm, best.value / mm);
    optimum.x = {best.l1 / mm};
    optimum.y = {best.l2 / mm};
    optimum.mark = Mark::points;
    optimum.colour = 5;
    plot.series.push_back(optimum);
  }
  draw(plot, path);
}

}  // namespace osteomill::io
