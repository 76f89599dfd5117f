// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/path_maker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/cl_file.hpp"
#include "osteomill/io/gcode.hpp"
#include "osteomill/io/stock_maker.hpp"
#include "osteomill/io/text_file.hpp"
#include "osteomill/workpiece/air_moves.hpp"
#include "osteomill/workpiece/area_paths.hpp"
#include "osteomill/workpiece/remover.hpp"
#include "osteomill/workpiece/surface_passes.hpp"
#include "osteomill/workpiece/swing.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using Json = nlohmann::ordered_json;
using workpiece::Outline;
using workpiece::ToolPath;

// Of the cutter's volume: more of it in bone at the start is no trace of the voxels.
constexpr double kMostBuried = 1e-3;

Json mm_of(const Vector3& p) {
  return Json::array({p.x() / units::mm, p.y() / units::mm, p.z() / units::mm});
}

Outline shape_of(const PathCase& path, const workpiece::Stock& stock) {
  const OutlineCase& from = path.outline;
  if (from.kind == OutlineKind::rectangle)
    return workpiece::rectangle({from.x[0], from.y[0]}, {from.x[1], from.y[1]});
  if (from.kind == OutlineKind::circle)
    return workpiece::circle({from.x[0], from.y[0]}, from.radius);
  if (from.kind == OutlineKind::polygon) {
    workpiece::Polygon polygon;
    for (std::size_t i = 0; i < from.x.size(); ++i) polygon.emplace_back(from.x[i], from.y[i]);
    return workpiece::outline_of({polygon});
  }
  Outline outline = workpiece::shadow(stock, path.bottom, path.top);
  if (outline.empty())
    throw InvalidInput(Fault{
        "path.outline",
        fmt::format("bone between {:g} and {:g} mm", path.bottom / units::mm, path.top / units::mm),
        "must be there: the stock has none at these heights",
        "check path.top_mm and path.bottom_mm"});
  return outline;
}

Outline where_the_axis_may_go(const PathCase& path, const cutting::Cutter& cutter,
                              const workpiece::Stock& stock) {
  Outline outline = shape_of(path, stock);
  const bool bone = path.outline.kind == OutlineKind::bone;
  outline = workpiece::grown(outline, path.outline.grow.value_or(bone ? 0.0 : -cutter.radius));
  return outline;
}

/// The same at each level: what a region has below the tip is in nobody's way.
std::vector<Outline> where_no_region_is(const Outline& outline, const std::vector<double>& levels,
                                        const cutting::Cutter& cutter, const MadeRegions& regions) {
  std::vector<Outline> left;
  for (const double level : levels) {
    left.push_back(outline);
    for (const workpiece::NoGo& region : regions.no_go)
      left.back() = workpiece::without(left.back(), workpiece::forbidden(region, cutter, level));
  }
  if (std::all_of(left.begin(), left.end(), [](const Outline& one) { return one.empty(); }))
    throw InvalidInput(Fault{"path.avoid_no_go", "nothing is left",
                             "must leave a place for the tool: the no-go regions with their "
                             "margins forbid all of the outline",
                             "use a smaller cutter or smaller margins, or come from another side"});
  return left;
}

ToolPath area_path(const PathCase& path, const workpiece::CutSettings& cut,
                   const cutting::Cutter& cutter, const workpiece::Stock& stock,
                   const MadeRegions& regions) {
  workpiece::AreaCut area;
  area.outline = where_the_axis_may_go(path, cutter, stock);
  area.levels = workpiece::levels(path.top, path.bottom, path.axial_step);
  if (path.outline.avoid_no_go)
    area.outline_at = where_no_region_is(area.outline, area.levels, cutter, regions);
  area.step_over = path.radial_step;
  area.clearance_z = path.top + path.clearance;
  area.milling = path.milling;
  if (path.kind == PathKind::contour)
    return workpiece::contour_parallel(area, path.from_outside, cut);
  return workpiece::raster(area, {path.direction, path.to_and_fro}, cut);
}

ToolPath trochoid_path(const PathCase& path, const workpiece::CutSettings& cut,
                       const cutting::Cutter& cutter) {
  workpiece::Trochoid slot;
  slot.start_W = vector_of(path.start);
  slot.along_W = vector_of(path.along);
  slot.slot_width = path.slot_width;
  slot.cutter_radius = cutter.radius;
  slot.advance = path.advance;
  slot.levels = workpiece::levels(path.top, path.bottom, path.axial_step);
  slot.clearance_z = path.top + path.clearance;
  slot.milling = path.milling;
  return workpiece::trochoidal_slot(slot, cut);
}

ToolPath surface_path(const PathCase& path, const workpiece::CutSettings& cut,
                      const cutting::Cutter& cutter, const MadeRegions& regions) {
  if (!regions.plan)
    throw InvalidInput(Fault{"path.kind", "surface",
                             "needs a [plan]: its border is the surface that is finished", ""});
  if (cutter.shape != cutting::CutterShape::ball)
    throw InvalidInput(Fault{"cutter.shape", "", "must be ball with path.kind = \"surface\"", ""});
  workpiece::SurfacePasses surface;
  surface.keep = workpiece::outside(regions.plan);
  surface.lower = {path.outline.x[0], path.outline.y[0]};
  surface.upper = {path.outline.x[1], path.outline.y[1]};
  surface.top = path.top;
  surface.bottom = path.bottom;
  surface.ball_radius = cutter.radius;
  surface.scallop = path.scallop;
  surface.allowance = path.surface_allowance;
  surface.along_y = path.along_y;
  surface.sample = path.sample;
  surface.clearance_z = path.top + path.clearance;
  return workpiece::surface_passes(surface, cut);
}

ToolPath swing_path(const PathCase& path, const workpiece::CutSettings& cut) {
  workpiece::Swing swing;
  swing.pivot_W = vector_of(path.pivot);
  swing.normal_W = vector_of(path.normal);
  swing.forward_W = vector_of(path.forward);
  swing.first_angle = path.first_angle;
  swing.last_angle = path.last_angle;
  swing.first_insertion = path.first_insertion;
  swing.last_insertion = path.last_insertion;
  swing.advance = path.groove;
  swing.there_and_back = path.there_and_back;
  return workpiece::swing_and_advance(swing, cut);
}

ToolPath built(const PathCase& path, const cutting::Cutter& cutter, const workpiece::Stock& stock,
               const MadeRegions& regions) {
  const workpiece::CutSettings cut{path.feed, path.spindle_speed};
  workpiece::Lines lines;
  lines.start_W = vector_of(path.start);
  lines.along_W = vector_of(path.along);
  lines.step_over_W = vector_of(path.step_over);
  lines.count = path.lines;
  lines.clearance = path.clearance;
  switch (path.kind) {
    case PathKind::lines:
      return workpiece::lines(lines, cut);
    case PathKind::zigzag:
      return workpiece::zigzag(lines, cut);
    case PathKind::one_way:
      return workpiece::one_way(lines, cut, path.milling);
    case PathKind::rough_finish:
      return workpiece::rough_and_finish({lines, vector_of(path.allowance), path.finish_feed}, cut);
    case PathKind::raster:
    case PathKind::contour:
      return area_path(path, cut, cutter, stock, regions);
    case PathKind::trochoid:
      return trochoid_path(path, cut, cutter);
    case PathKind::swing:
      return swing_path(path, cut);
    case PathKind::surface:
      return surface_path(path, cut, cutter, regions);
    case PathKind::gcode:
      return read_gcode(read_text_file(path.file),
                        GcodeOptions{.file_name = path.file.filename().string()});
    case PathKind::cl:
      return read_cl(read_text_file(path.file), path.file.filename().string());
    case PathKind::points:
      break;
  }
  workpiece::Move move{workpiece::MoveKind::cut, {}, path.feed, path.spindle_speed, 1};
  for (const auto& point : path.points) move.points_W.push_back(vector_of(point));
  return ToolPath({move});
}

void check_start(const ToolPath& path, const cutting::Cutter& cutter, workpiece::Stock stock) {
  const workpiece::ToolPose start = path.at(0.0).pose();
  const Vector3& tip = start.tip_W;
  const double buried = workpiece::Remover(stock, cutter).step(start, start).buried_volume;
  const double volume = M_PI * cutter.radius * cutter.radius * cutter.cutting_length;
  if (buried < kMostBuried * volume) return;
  throw InvalidInput(
      Fault{"path",
            fmt::format("starts at ({:.2f}, {:.2f}, {:.2f}) mm with {:.3g} mm³ of bone inside the "
                        "cutter",
                        tip.x() / units::mm, tip.y() / units::mm, tip.z() / units::mm,
                        buried / units::mm3),
            "must start in air: what is inside the cutter at the start was never cut",
            "begin above the bone or beside it, and go in by a cut"});
}

Json margins_of(const ToolPath& path, const cutting::Cutter& cutter, const MadeRegions& regions) {
  const std::vector<workpiece::Approach> approaches =
      workpiece::check_no_go(path, cutter, regions.no_go);
  Json list = Json::array();
  for (std::size_t i = 0; i < approaches.size(); ++i) {
    const workpiece::Approach& near = approaches[i];
    list.push_back({{"name", regions.no_go[i].name},
                    {"margin_mm", regions.no_go[i].margin / units::mm},
                    {"least_distance_mm", near.distance / units::mm},
                    {"line", path.moves()[near.move].line},
                    {"tip_mm", mm_of(near.tip_W)},
                    {"region_mm", mm_of(near.place_W)}});
  }
  return list;
}

}  // namespace

MadePath make_path(const PathCase& path, const cutting::Cutter& cutter,
                   const workpiece::Stock& stock, const MadeRegions& regions) {
  MadePath made{built(path, cutter, stock, regions), {}};
  check_start(made.path, cutter, stock);
  made.report["no_go"] = margins_of(made.path, cutter, regions);
  if (regions.access)
    made.report["access_margin_mm"] =
        workpiece::check_access(made.path, cutter, *regions.access) / units::mm;
  made.report["length_mm"] = made.path.length() / units::mm;
  made.report["programmed_time_s"] = workpiece::duration(made.path, path.rapid_feed);
  if (path.skip_air) {
    const workpiece::ContactMap contact(stock, cutter, made.path);
    workpiece::AirMoves air =
        workpiece::rapid_through_air(made.path, contact, {path.air_clearance, path.rapid_feed});
    made.path = std::move(air.path);
    made.report["air_length_mm"] = air.length / units::mm;
    made.report["air_time_saved_s"] = air.time_saved;
  }
  return made;
}

}  // namespace osteomill::io
