// SPDX-License-Identifier: BSD-3-Clause
// Writes reports of made-up runs into a folder: what the tests of the page open in a browser, and
// an example of how a command fills the data.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <numbers>

#include "osteomill/base/units.hpp"
#include "osteomill/geometry/mesh.hpp"
#include "osteomill/io/report.hpp"

namespace {

using namespace osteomill;
using geometry::Mesh;

constexpr double kLength = 40 * units::mm, kRadius = 1.5 * units::mm, kDepth = 4 * units::mm;

/// A vaulted plate of 60 x 30 mm; with a slot of the cutter's width along x where `cut`.
Mesh plate(bool cut) {
  Mesh mesh;
  const int nx = 120, ny = 60;
  const auto top = [&](double x, double y) {
    const double vault = 9 * units::mm - 4.0 * (x * x + 2.0 * y * y);
    const double beyond = std::max(std::abs(x) - kLength / 2, 0.0);
    return cut && std::hypot(beyond, y) < kRadius ? vault - kDepth : vault;
  };
  for (int side = 0; side < 2; ++side)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) {
        const double x = (i - nx / 2) * 0.5 * units::mm, y = (j - ny / 2) * 0.5 * units::mm;
        const double z = side == 0 ? top(x, y) : top(x, y) * 0.0;
        mesh.vertices.emplace_back(static_cast<float>(x), static_cast<float>(y),
                                   static_cast<float>(z));
      }
  const auto at = [&](int side, int i, int j) {
    return static_cast<unsigned>((side * (ny + 1) + j) * (nx + 1) + i);
  };
  const auto quad = [&](unsigned a, unsigned b, unsigned c, unsigned d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      quad(at(0, i, j), at(0, i + 1, j), at(0, i + 1, j + 1), at(0, i, j + 1));
      quad(at(1, i, j), at(1, i, j + 1), at(1, i + 1, j + 1), at(1, i + 1, j));
    }
  for (int i = 0; i < nx; ++i) {
    quad(at(1, i, 0), at(1, i + 1, 0), at(0, i + 1, 0), at(0, i, 0));
    quad(at(0, i, ny), at(0, i + 1, ny), at(1, i + 1, ny), at(1, i, ny));
  }
  for (int j = 0; j < ny; ++j) {
    quad(at(1, 0, j), at(0, 0, j), at(0, 0, j + 1), at(1, 0, j + 1));
    quad(at(0, nx, j), at(1, nx, j), at(1, nx, j + 1), at(0, nx, j + 1));
  }
  return mesh;
}

/// Hard rims, soft middle: newtons per mm/s of feed.
double gain(double x) {
  if (std::abs(x) > kLength / 2) return 0.0;
  return std::abs(x) > kLength / 4 ? 6.0 : 1.5;
}

const char* material(double x) {
  return gain(x) == 0.0 ? "air" : gain(x) > 3.0 ? "cortical" : "cancellous";
}

io::ReportRun run(const std::string& name, const std::function<double(double)>& feed_mm_per_s) {
  io::ReportRun run;
  run.name = name;
  run.about = name == "adaptive" ? "The feed follows the measured force towards 12 N."
                                 : "The programmed feed, whatever the force.";
  run.after = plate(true);
  io::ReportSignal force{"mean", "N", {}, 30.0, "limit", "force"},
      peak{"peak", "N", {}, 30.0, "limit", "force"}, feed{"feed", "mm/s", {}, 12.0, "largest"},
      volume{"removed volume", "mm³", {}};
  io::ReportStrip strip{"material", {}}, saturated{"feed at its largest", {}, true};
  double x = -25 * units::mm, removed = 0.0;
  const double dt = 1e-3;
  for (double t = 0.0; x < 25 * units::mm; t += dt) {
    const double v = feed_mm_per_s(x);
    x += v * units::mm_per_s * dt;
    if (gain(x) > 0.0) removed += 2 * kRadius * kDepth * v * units::mm_per_s * dt / units::mm3;
    const double mean = gain(x) * v;
    const double ripple = 1.0 + 0.6 * std::sin(2 * std::numbers::pi * 66.7 * t);
    run.time_s.push_back(t);
    force.values.push_back(mean);
    peak.values.push_back(mean * ripple);
    feed.values.push_back(v);
    volume.values.push_back(removed);
    auto& intervals = strip.intervals;
    if (intervals.empty() || intervals.back().label != material(x))
      intervals.push_back({t, t, material(x)});
    intervals.back().to_s = t + dt;
    if (v > 11.9) {
      if (saturated.intervals.empty() || saturated.intervals.back().to_s < t - 1.5 * dt)
        saturated.intervals.push_back({t, t, "saturated"});
      saturated.intervals.back().to_s = t + dt;
    }
    const double z = 9 * units::mm - 4.0 * x * x - kDepth;
    run.path.time_s.push_back(t);
    run.path.tip.emplace_back(x, 0.0, z);
    run.path.value.push_back(mean);
  }
  run.path.axis = {geometry::Vector3::UnitZ()};
  run.events = {{strip.intervals.size() > 1 ? strip.intervals[1].from_s : 0.0, "first contact"}};
  run.signals = {peak, force, feed, volume};
  run.strips = {strip, saturated};
  return run;
}

io::ReportData slot() {
  io::ReportData data;
  data.title = "A slot through a made-up plate";
  data.subtitle = "40 mm long, 4 mm deep, 3 mm cylinder with two flutes at 20 000 rpm";
  data.program = "osteomill sample";
  data.created = "1 January 2026, 12:00";
  data.headline = {
      "Adaptive feed takes 36 % less time than constant feed and stays below the limit "
      "throughout."};
  data.highlights = {{"10.0", "s", "cutting time, adaptive", "constant feed: 15.7 s"},
                     {"19.2", "N", "peak force, adaptive", "limit 30 N"},
                     {"12.0", "mm/s", "largest feed", "in cancellous bone"},
                     {"480", "mm³", "removed volume", "same for both"}};
  data.runs.push_back(run("constant", [](double) { return 3.2; }));
  data.runs.push_back(run("adaptive", [](double x) {
    return std::abs(x) < 9.9e-3 ? 12.0 : gain(x) == 0.0 ? 3.0 : 2.0;
  }));
  data.summary.columns = {{"run"},
                          {"cutting time", "s", 2, true},
                          {"mean force", "N", 1, true},
                          {"peak force", "N", 1, true},
                          {"above the limit", "s", 2, true},
                          {"removed volume", "mm³", 1},
                          {"largest feed", "mm/s", 1}};
  for (const auto& r : data.runs) {
    double peak = 0.0, sum = 0.0, fastest = 0.0, above = 0.0;
    for (std::size_t i = 0; i < r.time_s.size(); ++i) {
      peak = std::max(peak, r.signals[0].values[i]);
      sum += r.signals[1].values[i];
      fastest = std::max(fastest, r.signals[2].values[i]);
      above += r.signals[0].values[i] > 30.0 ? 1e-3 : 0.0;
    }
    data.summary.rows.push_back({r.name, r.time_s.back(),
                                 sum / static_cast<double>(r.time_s.size()), peak, above,
                                 r.signals[3].values.back(), fastest});
  }
  data.notes = {
      {io::ReportNote::Kind::assumption,
       "Force grows with the square of the apparent density; no measured law was found.", "assumed",
       ""},
      {io::ReportNote::Kind::assumption, "Edge-force law of bovine cortical bone at 3.5 m/s.",
       "reconstructed", "[plaskos2006]"},
      {io::ReportNote::Kind::warning,
       "The feed per tooth leaves the range in which the law was fitted (2.5 to 203 µm).", "", ""},
      {io::ReportNote::Kind::information, "Times are counted from first contact to last exit."}};
  io::ReportScene scene;
  scene.before = plate(false);
  scene.cutter = cutting::Cutter{.shape = cutting::CutterShape::cylindrical,
                                 .radius = kRadius,
                                 .flutes = 2,
                                 .helix_angle = 30 * units::deg,
                                 .rake_angle = 0.0,
                                 .cutting_length = 10 * units::mm};
  scene.path_value_limit = 30.0;
  data.scene = scene;
  data.pictures = {{"The plate with its slot, from above",
                    "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 600 300' width='600'>"
                    "<rect width='600' height='300' fill='#e9dfc9'/><rect x='100' y='135' "
                    "width='400' height='30' rx='15' fill='#b98d6b'/></svg>",
                    true}};
  data.expanded_case =
      "{\n  \"cutter\": {\n    \"shape\": \"cylindrical\",\n    \"diameter_mm\": 3,\n    "
      "\"flutes\": 2\n  },\n  \"note\": \"</script><b>&amp; not markup</b>\"\n}";
  return data;
}

/// What commands without runs over time write: sections of text, tables, charts and pictures.
io::ReportData sections() {
  io::ReportData data;
  data.title = "Forces of one revolution";
  data.subtitle = "A report of sections, without runs over time";
  data.headline = {"The mean force in feed direction is 12.3 N."};
  io::ReportSeries fx{"x", {}, {}}, fy{"y", {}, {}}, loop{"hodograph", {}, {}};
  for (int i = 0; i <= 360; ++i) {
    const double a = i * units::deg;
    fx.x.push_back(i);
    fx.y.push_back(-12 + 4 * std::cos(4 * a));
    fy.x.push_back(i);
    fy.y.push_back(20 + 4 * std::sin(4 * a));
    loop.x.push_back(fx.y.back());
    loop.y.push_back(fy.y.back());
  }
  io::ReportSeries measured{
      "measured", {1, 2, 7, 13}, {8, 11, 24, 35}, io::ReportSeries::Style::points};
  io::ReportSeries law{
      "law", {1, 2, 4, 7, 13}, {7.5, 11.4, 17, 24.2, 34}, io::ReportSeries::Style::line};
  io::ReportSeries bars{"force", {0, 1, 2}, {12, 20, 5}, io::ReportSeries::Style::bars};
  const std::string svg =
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 120 60'><circle cx='60' cy='30' r='20' "
      "fill='none' stroke='#0b6aa8'/></svg>";
  data.sections = {
      {"Over a revolution",
       {io::ReportParagraph{"Forces on the tool; x along the feed."},
        io::ReportChart{"Force", {"angle", "°"}, {"force", "N"}, {fx, fy}, {{"limit", 25.0}}},
        io::ReportChart{"Hodograph", {"force x", "N"}, {"force y", "N"}, {loop}}}},
      {"Over the chip thickness",
       {io::ReportChart{"",
                        {"chip thickness", "µm", true},
                        {"force", "N", true},
                        {law, measured},
                        {},
                        "Both axes are logarithmic."},
        io::ReportChart{"", {"tool", "", false, {"A", "B", "C"}}, {"force", "N"}, {bars}},
        io::ReportTable{
            "Means",
            {{"component"}, {"mean", "N", 2}, {"peak", "N", 2}},
            {{std::string("x"), -12.0, -16.0}, {std::string("y"), 20.0, std::monostate{}}}},
        io::ReportPicture{"A circle, as a picture of lines.", svg}}}};
  return data;
}

/// 400 000 samples a signal: as long as the longest recordings.
io::ReportData long_signals() {
  io::ReportData data;
  data.title = "A long recording";
  io::ReportRun run;
  run.name = "recording";
  io::ReportSignal force{"force", "N", {}, 30.0};
  for (int i = 0; i < 400'000; ++i) {
    const double t = i / 8000.0;
    run.time_s.push_back(t);
    force.values.push_back(i == 123'456 ? 77.0 : 10 + 5 * std::sin(900 * t) * std::sin(t));
  }
  run.signals = {force};
  data.runs = {run};
  return data;
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::cerr << "osteomill_report_sample FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = words[1];
  std::filesystem::create_directories(folder);
  io::ReportData two_runs = slot(), one_run = slot();
  one_run.runs.erase(one_run.runs.begin());
  one_run.summary.rows.erase(one_run.summary.rows.begin());
  one_run.scene.reset();
  io::write_report(folder / "two_runs.html", two_runs);
  io::write_report(folder / "one_run.html", one_run);
  io::write_report(folder / "sections.html", sections());
  io::write_report(folder / "long_signals.html", long_signals());
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    fmt::print("{} {} kB\n", entry.path().filename().string(), entry.file_size() / 1000);
}
