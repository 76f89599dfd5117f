// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_picture.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "osteomill/base/units.hpp"
#include "osteomill/io/profile_slab.hpp"
#include "osteomill/io/surface.hpp"

namespace osteomill::io {
namespace {

const geometry::Vector3 kTowardsWall(-0.3, -1.0, 0.45);  // of a profile's slab, from the eye's side

// Large triangles on the flat sides of a slab would blur the zones of its profile.
const SurfaceOptions kEveryVoxel{0.0};

constexpr Colour kNoGoColour{0.30F, 0.55F, 0.62F};

bool profiled(const SimulatedRun& run) { return run.input.stock.kind == StockKind::line_profile; }

/// The path in bone, a line for each stretch between two of air. Its points are no closer than the
/// line is thick but for the last: the ends of shorter pieces would show through one another.
std::vector<PictureLine> lines_of(const SimulatedRun& run) {
  constexpr double kRadius = 0.3 * units::mm;
  std::vector<PictureLine> lines;
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    const auto in_bone = [&](std::size_t k) {
      return k < run.steps.size() && run.steps[k].samples_in_contact > 0;
    };
    if (!in_bone(i)) continue;
    const simulate::Step& step = run.steps[i];
    const bool begins = i == 0 || !in_bone(i - 1), ends = !in_bone(i + 1);
    if (begins) lines.push_back({{}, {}, kRadius});
    if (!begins && !ends && (step.tip_W - lines.back().points.back()).norm() < kRadius) continue;
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

PictureLegend materials(const SimulatedRun& run, const RunSurfaces& surfaces) {
  double low = std::numeric_limits<double>::infinity();
  double high = 0.0;
  for (const geometry::Mesh& mesh : surfaces.before)
    for (const float value : mesh.values) {
      low = std::min<double>(low, value);
      high = std::max<double>(high, value);
    }
  if (profiled(run)) return {"gain, N/(mm/s)", 0.0, std::ceil(high), ColourMap::bone};
  // Round hundreds, so that the bar begins and ends with a number.
  return {"density, kg/m³", std::floor(low / 100.0) * 100.0, std::ceil(high / 100.0) * 100.0,
          ColourMap::bone};
}

/// The plane along the tool in which the tip keeps while it cuts, to within the cutter's radius,
/// seen from the front.
std::optional<CutPlane> plane_of_slot(const SimulatedRun& run) {
  if (profiled(run)) return {};
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  double count = 0.0;
  for (const simulate::Step& step : run.steps) {
    if (step.samples_in_contact == 0) continue;
    const Eigen::Vector2d p = step.tip_W.head<2>();
    count += 1.0;
    const Eigen::Vector2d from_mean = p - mean;
    mean += from_mean / count;
    spread += from_mean * (p - mean).transpose();
  }
  if (count < 2.0) return {};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(0.5 * (spread + spread.transpose()));
  const Eigen::Vector2d across = axes.eigenvectors().col(0);
  for (const simulate::Step& step : run.steps)
    if (step.samples_in_contact > 0 &&
        std::abs(across.dot(step.tip_W.head<2>() - mean)) > run.input.cutter.cutter.radius)
      return {};
  CutPlane plane;
  plane.point << mean, 0.0;
  plane.away << across, 0.0;
  if (plane.away.dot(PictureCamera{}.from) < 0.0) plane.away = -plane.away;
  return plane;
}

void add_no_go(PictureView& view, const SimulatedRun& run) {
  for (const geometry::Mesh& surface : run.no_go)
    if (surface.vertices.size() > 3) view.meshes.push_back({surface, kNoGoColour});
}

}  // namespace

RunSurfaces surfaces_of(const std::vector<SimulatedRun>& runs) {
  RunSurfaces surfaces;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const SimulatedRun& run = runs[i];
    if (profiled(run)) {
      workpiece::Stock slab = slab_of(run.input.stock.profile);
      surfaces.before.push_back(surface_of(slab, kEveryVoxel));
      mill_slab(run.steps, run.input.cutter.cutter, slab);
      surfaces.after.push_back(surface_of(slab, kEveryVoxel));
      continue;
    }
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
  Picture picture;
  picture.title = runs[index].input.name + ": the bone before and after";
  picture.views = {{"before", {{surfaces.before[index]}}}, {"after", {{surfaces.after[index]}}}};
  for (PictureView& view : picture.views) add_no_go(view, runs[index]);
  picture.mesh_values = materials(runs[index], surfaces);
  picture.width = 1000;
  if (profiled(runs[index])) picture.camera.from = kTowardsWall;
  return picture;
}

Picture force_picture_of(const std::vector<SimulatedRun>& runs, const RunSurfaces& surfaces,
                         std::size_t index) {
  const SimulatedRun& run = runs[index];
  Picture picture;
  picture.title =
      fmt::format("{}: {:.1f} s, mean {:.1f} N, peak {:.1f} N", run.input.name,
                  run.summary.cutting_time, run.summary.mean_force, run.summary.peak_force);
  PictureView view;
  view.lines = lines_of(run);
  if (const std::optional<CutPlane> plane = plane_of_slot(run)) {
    SurfaceOptions options;
    options.cut = plane;
    view.meshes = {{surface_of(*run.after, options)}};
    picture.camera.from = plane->away + geometry::Vector3(0.0, 0.0, 0.5) +
                          0.3 * geometry::Vector3::UnitZ().cross(plane->away);
  } else {
    view.meshes = {{surfaces.after[index]}};
    if (profiled(run)) picture.camera.from = kTowardsWall;
  }
  add_no_go(view, run);
  picture.views = {std::move(view)};
  picture.mesh_values = materials(runs[index], surfaces);
  picture.line_values = {"mean force, N", 0.0, std::max(1.0, std::ceil(largest_mean_force(runs)))};
  return picture;
}

void add_scene(ReportData& data, const std::vector<SimulatedRun>& runs, RunSurfaces surfaces) {
  if (!data.scene) return;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    data.runs[i].after = std::move(surfaces.after[i]);
    const bool shared = !profiled(runs[i]) && runs[i].before == runs.front().before;
    if (i > 0 && !shared) data.runs[i].before = std::move(surfaces.before[i]);
  }
  data.scene->before = std::move(surfaces.before.front());
  const bool gain = profiled(runs.front());
  data.scene->mesh_value_name = gain ? "cutting gain" : "density";
  data.scene->mesh_value_unit = gain ? "N/(mm/s)" : "kg/m³";
}

}  // namespace osteomill::io
