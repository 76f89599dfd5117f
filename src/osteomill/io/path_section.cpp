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

}  // namespace

void bind_path(Section& section, PathCase& path, StockCase& stock) {
  simulate::LineProfile& profile = stock.profile;
  section.table("path", "what the cutter is to do", Need::required, [&](Section& s) {
    const bool profiled = stock.kind == StockKind::line_profile;
    if (s.when(!profiled)) {
      s.choice<PathKind>("kind", path.kind,
                         {{"lines", PathKind::lines},
                          {"zigzag", PathKind::zigzag},
                          {"points", PathKind::points},
                          {"gcode", PathKind::gcode}},
                         "how the path is given");
    }
    const bool gcode = !profiled && path.kind == PathKind::gcode;
    if (s.when(!gcode)) {
      s.number("feed_mm_per_s", path.feed, kMmPerS, up_to(1000.0), "programmed feed");
      s.number("spindle_speed_rpm", path.spindle_speed, kRpm, up_to(200000.0), "spindle speed");
    }
    if (s.when(profiled)) {
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
    if (s.when(!profiled)) {
      s.number("rapid_mm_per_s", path.rapid_feed, kMmPerS, up_to(1000.0), "feed of rapid moves",
               Need::optional);
    }
    if (s.when(!profiled && (path.kind == PathKind::lines || path.kind == PathKind::zigzag))) {
      s.triple("start_mm", path.start, kMm, any(), "tip at the start of the first line");
      s.triple("along_mm", path.along, kMm, any(), "from the start to the end of a line");
      s.triple("step_over_mm", path.step_over, kMm, any(), "from one line to the next",
               Need::optional);
      s.integer("count", path.lines, between(1, 10000), "number of lines", Need::optional);
      s.number("clearance_mm", path.clearance, kMm, positive(), "height of the way back",
               Need::optional);
    }
    if (s.when(!profiled && path.kind == PathKind::points)) {
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
    if (s.when(gcode)) s.file("file", path.file, "G-code program");
  });
}

}  // namespace osteomill::io
