// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/io/surface.hpp"

namespace osteomill::io {
namespace {

/// The path in bone, a line for each stretch between two of air.
std::vector<PictureLine> lines_of(const SimulatedRun& run) {
  std::vector<PictureLine> lines;
  bool in_bone = false;
  for (const simulate::Step& step : run.steps) {
    const bool was_in_bone = std::exchange(in_bone, step.samples_in_contact > 0);
    if (!in_bone) continue;
    if (!was_in_bone) lines.emplace_back();
    lines.back().points.push_back(step.tip_W);
    lines.back().values.push_back(step.mean_force);
  }
  return lines;
}

double largest_mean_force(const std::vector<SimulatedRun>& runs) {
  double largest = 0.0;
  for (const SimulatedRun& run : runs)
    for (const simulate::Step& step : run.steps) largest = std::max(largest, step.mean_force);
  return largest;
}

}  // namespace

RunSurfaces surfaces_of(const std::vector<SimulatedRun>& runs) {
  RunSurfaces surfaces;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const SimulatedRun& run = runs[i];
    if (i > 0 && run.before && run.before == runs[i - 1].before)
      surfaces.before.push_back(surfaces.before[i - 1]);
    else
      surfaces.before.push_back(run.before ? surface_of(*run.before) : geometry::Mesh{});
    surfaces.after.push_back(run.after ? surface_of(*run.after) : geometry::Mesh{});
  }
  return surfaces;
}

Picture picture_of(const std::vector<SimulatedRun>& runs, const RunSurfaces& surfaces,
                   std::size_t index) {
  const SimulatedRun& run = runs[index];
  Picture picture;
  picture.title =
      fmt::format("{}: {:.1f} s, mean {:.1f} N, peak {:.1f} N", run.input.name,
                  run.summary.cutting_time, run.summary.mean_force, run.summary.peak_force);
  picture.views = {{"before", {{surfaces.before[index]}}},
                   {"after", {{surfaces.after[index]}}, lines_of(run)}};
  double low = 0.0;
  double high = 0.0;
  for (const geometry::Mesh& mesh : surfaces.before) {
    if (mesh.values.empty()) continue;
    const auto [least, most] = std::minmax_element(mesh.values.begin(), mesh.values.end());
    low = high > 0.0 ? std::min<double>(low, *least) : *least;
    high = std::max<double>(high, *most);
  }
  // Round hundreds, so that the bar begins and ends with a number.
  picture.mesh_values = {"density, kg/m³", std::floor(low / 100.0) * 100.0,
                         std::ceil(high / 100.0) * 100.0, ColourMap::bone};
  picture.line_values = {"mean force, N", 0.0, std::max(1.0, std::ceil(largest_mean_force(runs)))};
  picture.width = 1000;
  return picture;
}

void add_scene(ReportData& data, const std::vector<SimulatedRun>& runs, RunSurfaces surfaces) {
  if (runs.empty() || !runs.front().before) return;
  for (const SimulatedRun& run : runs)
    if (run.before != runs.front().before) return;
  ReportScene scene;
  scene.before = std::move(surfaces.before.front());
  scene.cutter = runs.front().input.cutter.cutter;
  scene.path_value_name = "mean force";
  data.scene = std::move(scene);
  for (std::size_t i = 0; i < runs.size(); ++i) data.runs[i].after = std::move(surfaces.after[i]);
}

}  // namespace osteomill::io
