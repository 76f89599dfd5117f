// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/path_section.hpp"

#include "osteomill/base/units.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/stock_section.hpp"

namespace osteomill::io {
namespace {

constexpr Quantity kMm{units::mm, "mm"};
constexpr Quantity kMmPerS{units::mm_per_s, "mm/s"};
constexpr Quantity kRpm{units::rpm, "rpm"};
constexpr Quantity kDeg{units::deg, "deg"};
constexpr Quantity kPlain{};

void bind_profiled(Section& s, simulate::LineProfile& profile) {
  s.integer("lines", profile.lines, between(1, 1000), "number of lines", Need::optional);
  s.number("lead_in_mm", profile.lead_in, kMm, non_negative(), "air before each line",
           Need::optional);
  s.number("lead_out_mm", profile.lead_out, kMm, non_negative(), "air behind each line",
           Need::optional);
  s.number("radial_depth_mm", profile.radial_depth, kMm, positive(), "radial depth of cut",
           Need::optional);
  s.number("axial_depth_mm", profile.axial_depth, kMm, positive(), "axial depth of cut",
           Need::optional);
}

void bind_milling(Section& s, PathCase& path) {
  s.choice<workpiece::Milling>(
      "milling", path.milling, {{"down", workpiece::Milling::down}, {"up", workpiece::Milling::up}},
      "on which side of the feed the bone is that is left", Need::optional);
}

void bind_lines(Section& s, PathCase& path) {
  s.triple("start_mm", path.start, kMm, any(), "tip at the start of the first line");
  s.triple("along_mm", path.along, kMm, any(), "from the start to the end of a line");
  if (!s.when(path.kind != PathKind::trochoid)) return;
  s.triple("step_over_mm", path.step_over, kMm, any(), "from one line to the next", Need::optional);
  s.integer("count", path.lines, between(1, 10000), "number of lines", Need::optional);
}

void bind_rough_finish(Section& s, PathCase& path) {
  s.triple("allowance_mm", path.allowance, kMm, any(),
           "by how much the rough pass stays off the finishing pass", Need::optional);
  s.number("finish_feed_mm_per_s", path.finish_feed, kMmPerS, non_negative(),
           "feed of the finishing pass; 0: feed_mm_per_s", Need::optional);
}

void bind_outline(Section& s, PathCase& path) {
  OutlineCase& outline = path.outline;
  if (s.when(path.kind != PathKind::surface)) {
    s.choice<OutlineKind>("outline", outline.kind,
                          {{"bone", OutlineKind::bone},
                           {"rectangle", OutlineKind::rectangle},
                           {"circle", OutlineKind::circle},
                           {"polygon", OutlineKind::polygon}},
                          "what is taken off, seen from above: the bone's own shadow, or a shape",
                          Need::optional);
    s.number("outline_grow_mm", outline.grow, kMm, any(),
             "the tool's axis may go this far beyond the outline; absent: 0 for bone, otherwise "
             "minus the cutter's radius");
    s.flag("avoid_no_go", outline.avoid_no_go,
           "leave out what the no-go regions and their margins forbid");
  } else {
    outline.kind = OutlineKind::rectangle;
  }
  const bool shaped = path.kind == PathKind::surface || outline.kind != OutlineKind::bone;
  if (s.when(shaped)) {
    s.numbers("outline_x_mm", outline.x, kMm, any(),
              "x of the corners: two of a rectangle, one of a circle's middle");
    s.numbers("outline_y_mm", outline.y, kMm, any(), "y of the corners");
    const std::size_t least = outline.kind == OutlineKind::circle      ? 1
                              : outline.kind == OutlineKind::rectangle ? 2
                                                                       : 3;
    if (s.has("outline_x_mm") && s.has("outline_y_mm") &&
        (outline.x.size() != outline.y.size() || outline.x.size() < least ||
         (least < 3 && outline.x.size() > least)))
      s.fault("outline_y_mm",
              "must be as many as outline_x_mm: 1 for a circle, 2 for a "
              "rectangle, 3 or more for a polygon");
    if (least == 2 && outline.x.size() == 2 && outline.y.size() == 2 &&
        !(outline.x[0] < outline.x[1] && outline.y[0] < outline.y[1]))
      s.fault("outline_x_mm", "must rise from the lower corner to the upper, and outline_y_mm too");
  }
  if (s.when(outline.kind == OutlineKind::circle))
    s.number("outline_radius_mm", outline.radius, kMm, positive(), "of the circle");
}

void bind_levels(Section& s, PathCase& path) {
  s.number("top_mm", path.top, kMm, any(), "height at which the bone begins");
  s.number("bottom_mm", path.bottom, kMm, any(), "lowest level of the tip");
  if (s.when(path.kind != PathKind::surface))
    s.number("axial_step_mm", path.axial_step, kMm, positive(), "largest step from level to level",
             Need::optional);
}

void bind_area(Section& s, PathCase& path) {
  bind_outline(s, path);
  s.number("radial_step_mm", path.radial_step, kMm, positive(), "between neighbouring passes",
           Need::optional);
  if (s.when(path.kind == PathKind::raster)) {
    s.number("direction_deg", path.direction, kDeg, between(-180, 180), "of the passes, from x",
             Need::optional);
    s.flag("to_and_fro", path.to_and_fro, "passes in turn forwards and backwards, or all one way");
  }
  if (s.when(path.kind == PathKind::contour))
    s.flag("from_outside", path.from_outside, "from the border to the middle, or the other way");
}

void bind_surface(Section& s, PathCase& path) {
  bind_outline(s, path);
  s.number("scallop_um", path.scallop, {units::um, "um"}, positive(),
           "largest height of the ridges between passes", Need::optional);
  s.number("surface_allowance_mm", path.surface_allowance, kMm, non_negative(),
           "bone that stays on the surface", Need::optional);
  s.number("sample_mm", path.sample, kMm, up_to(5.0), "spacing of points along a pass",
           Need::optional);
  s.flag("along_y", path.along_y, "passes along y rather than x");
}

void bind_swing(Section& s, PathCase& path) {
  s.triple("pivot_mm", path.pivot, kMm, any(), "fixed entry point of the guide");
  s.triple("normal", path.normal, kPlain, any(), "of the cutting plane", Need::optional);
  s.triple("forward", path.forward, kPlain, any(), "direction of insertion at angle 0",
           Need::optional);
  s.number("first_angle_deg", path.first_angle, kDeg, between(-90, 90), "of a swing");
  s.number("last_angle_deg", path.last_angle, kDeg, between(-90, 90), "of a swing");
  s.number("first_insertion_mm", path.first_insertion, kMm, positive(),
           "of the tip beyond the pivot at the first swing");
  s.number("last_insertion_mm", path.last_insertion, kMm, positive(), "at the last swing");
  s.number("advance_mm", path.groove, kMm, positive(), "from swing to swing: a groove of the guide",
           Need::optional);
  s.flag("there_and_back", path.there_and_back,
         "each swing rough down and finishing up before the tool is advanced");
}

void bind_stock_path(Section& s, PathCase& path) {
  const auto is = [&](std::initializer_list<PathKind> kinds) {
    for (PathKind kind : kinds)
      if (path.kind == kind) return true;
    return s.when(false);  // true in a schema walk
  };
  s.number("rapid_mm_per_s", path.rapid_feed, kMmPerS, up_to(1000.0),
           "speed of rapid moves, the machine's own", Need::optional);
  s.flag("skip_air", path.skip_air, "cuts through air that the stock predicts become rapids");
  if (s.when(path.skip_air))
    s.number("air_clearance_mm", path.air_clearance, kMm, non_negative(),
             "before and behind bone the feed is that of the cut", Need::optional);
  if (is({PathKind::lines, PathKind::zigzag, PathKind::one_way, PathKind::rough_finish,
          PathKind::trochoid}))
    bind_lines(s, path);
  if (is({PathKind::lines, PathKind::zigzag, PathKind::one_way, PathKind::raster, PathKind::contour,
          PathKind::trochoid, PathKind::surface}))
    s.number("clearance_mm", path.clearance, kMm, positive(), "height of the ways between passes",
             Need::optional);
  if (is({PathKind::one_way, PathKind::raster, PathKind::contour, PathKind::trochoid}))
    bind_milling(s, path);
  if (is({PathKind::rough_finish})) bind_rough_finish(s, path);
  if (is({PathKind::raster, PathKind::contour})) bind_area(s, path);
  if (is({PathKind::surface})) bind_surface(s, path);
  if (is({PathKind::raster, PathKind::contour, PathKind::trochoid, PathKind::surface}))
    bind_levels(s, path);
  if (is({PathKind::trochoid})) {
    s.number("slot_width_mm", path.slot_width, kMm, positive(), "of the slot");
    s.number("advance_mm", path.advance, kMm, positive(), "of the circles' middle, a turn",
             Need::optional);
  }
  if (is({PathKind::swing})) bind_swing(s, path);
  if (is({PathKind::points})) {
    s.tables("points", "corners of the path of the tip", Need::required,
             [&](Section& point, std::size_t) {
               std::array<double, 3> at{};
               point.number("x_mm", at[0], kMm, any(), "x in the work frame");
               point.number("y_mm", at[1], kMm, any(), "y in the work frame");
               point.number("z_mm", at[2], kMm, any(), "z in the work frame");
               path.points.push_back(at);
             });
    if (s.has("points") && path.points.size() == 1) s.fault("points", "must be two or more");
  }
  if (is({PathKind::gcode, PathKind::cl})) s.file("file", path.file, "G-code program, or CL data");
}

}  // namespace

void bind_path(Section& section, PathCase& path, StockCase& stock) {
  section.table("path", "what the cutter is to do", Need::required, [&](Section& s) {
    const bool profiled = stock.kind == StockKind::line_profile;
    if (s.when(!profiled)) {
      s.choice<PathKind>("kind", path.kind,
                         {{"lines", PathKind::lines},
                          {"zigzag", PathKind::zigzag},
                          {"one-way", PathKind::one_way},
                          {"rough-finish", PathKind::rough_finish},
                          {"raster", PathKind::raster},
                          {"contour", PathKind::contour},
                          {"trochoid", PathKind::trochoid},
                          {"swing", PathKind::swing},
                          {"surface", PathKind::surface},
                          {"points", PathKind::points},
                          {"gcode", PathKind::gcode},
                          {"cl", PathKind::cl}},
                         "how the path is given");
    }
    if (s.when(profiled || !path.from_file())) {
      s.number("feed_mm_per_s", path.feed, kMmPerS, up_to(1000.0), "programmed feed");
      s.number("spindle_speed_rpm", path.spindle_speed, kRpm, up_to(200000.0), "spindle speed");
    }
    if (s.when(profiled)) bind_profiled(s, stock.profile);
    if (s.when(!profiled)) bind_stock_path(s, path);
  });
}

}  // namespace osteomill::io
