// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/area_paths.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/path_writer.hpp"

namespace osteomill::workpiece {

namespace {

Vector3 at_height(const Vector2& p, double z) { return {p.x(), p.y(), z}; }

void check(const AreaCut& area) {
  require_positive("path.step_over_mm", area.step_over / units::mm, "mm");
  const bool nothing = std::all_of(area.outline_at.begin(), area.outline_at.end(),
                                   [](const Outline& outline) { return outline.empty(); });
  if (area.outline_at.empty() ? area.outline.empty() : nothing)
    throw InvalidInput(Fault{"path.outline", "nothing", "must enclose an area for the tool's axis",
                             "use a smaller cutter, a larger outline or no wall"});
  for (double level : area.levels)
    if (!(level < area.clearance_z))
      throw InvalidInput(Fault{"path.clearance_mm",
                               fmt::format("{:g} mm", area.clearance_z / units::mm),
                               "must lie above every level of the path", ""});
}

const Outline& outline_of_level(const AreaCut& area, std::size_t level) {
  return area.outline_at.empty() ? area.outline : area.outline_at[level];
}

ToolPath finished(PathWriter& writer) {
  if (writer.empty())
    throw InvalidInput(Fault{"path", "no pass", "must have at least one pass within the outline",
                             "use a smaller path.step_over_mm"});
  return ToolPath(writer.take());
}

/// The ring that starts at its corner nearest to a point.
Polygon starting_near(Polygon ring, const Vector2& p) {
  const auto nearest =
      std::min_element(ring.begin(), ring.end(), [&](const Vector2& a, const Vector2& b) {
        return (a - p).squaredNorm() < (b - p).squaredNorm();
      });
  std::rotate(ring.begin(), nearest, ring.end());
  return ring;
}

}  // namespace

std::vector<double> levels(double top, double bottom, double step) {
  require_positive("path.axial_step_mm", step / units::mm, "mm");
  if (!(bottom < top))
    throw InvalidInput(Fault{"path.bottom_mm", fmt::format("{:g} mm", bottom / units::mm),
                             fmt::format("must lie below path.top_mm = {:g} mm", top / units::mm),
                             ""});
  // A millionth of a step is rounding.
  const double count =
      require_within("path.levels", std::ceil((top - bottom) / step - 1e-6), 1, 10000, "");
  std::vector<double> heights;
  for (int n = 1; n <= static_cast<int>(count); ++n)
    heights.push_back(top + (bottom - top) * n / count);
  return heights;
}

ToolPath raster(const AreaCut& area, const Raster& how, const CutSettings& cut) {
  check(area);
  const Vector2 u(std::cos(how.direction), std::sin(how.direction));
  const Vector2 v(-u.y(), u.x());
  Vector2 low = Vector2::Constant(std::numeric_limits<double>::infinity());
  Vector2 high = -low;
  // Of all levels together, so that passes stand over each other.
  for (std::size_t level = 0; level < area.levels.size(); ++level)
    for (const Polygon& polygon : outline_of_level(area, level).polygons)
      for (const Vector2& p : polygon) {
        low = low.cwiseMin(Vector2(u.dot(p), v.dot(p)));
        high = high.cwiseMax(Vector2(u.dot(p), v.dot(p)));
      }
  // Passes equally apart, half a step from the borders on which a line would only touch.
  const int count = std::max(1, static_cast<int>(std::ceil((high.y() - low.y()) / area.step_over)));
  const double step = (high.y() - low.y()) / count;
  // Passes advance to +v, left of u. Down-milling has the bone that is left on the right.
  const bool backwards = area.milling == Milling::down;
  PathWriter writer(cut, area.clearance_z);
  int line = 0;
  for (std::size_t level = 0; level < area.levels.size(); ++level) {
    const double z = area.levels[level];
    const Outline& outline = outline_of_level(area, level);
    for (int n = 0; n < count; ++n) {
      const double at = low.y() + (n + 0.5) * step;
      const bool turned = how.to_and_fro ? line % 2 == 1 : backwards;
      Vector2 from = u * (low.x() - area.step_over) + v * at;
      Vector2 to = u * (high.x() + area.step_over) + v * at;
      if (turned) std::swap(from, to);
      const auto pieces = within(outline, from, to);
      if (!pieces.empty()) ++line;
      for (const auto& piece : pieces) {
        const bool joined = how.to_and_fro && !writer.empty() && writer.last().z() == z &&
                            (writer.last().head<2>() - piece[0]).norm() < 3.0 * area.step_over &&
                            reaches(outline, writer.last().head<2>(), piece[0]);
        if (!joined) writer.travel(at_height(piece[0], z), line);
        if (joined)
          writer.pass({at_height(piece[0], z), at_height(piece[1], z)}, line);
        else
          writer.pass({at_height(piece[1], z)}, line);
      }
    }
  }
  return finished(writer);
}

ToolPath contour_parallel(const AreaCut& area, bool from_outside, const CutSettings& cut) {
  check(area);
  // Borders run counter-clockwise, what lies within them on the left: up-milling from outside.
  const bool turned = from_outside == (area.milling == Milling::down);
  PathWriter writer(cut, area.clearance_z);
  int line = 0;
  for (std::size_t level = 0; level < area.levels.size(); ++level) {
    const double z = area.levels[level];
    const Outline& outline = outline_of_level(area, level);
    std::vector<Outline> rings;
    // Ring n comes from the outline itself: rounding does not add up.
    for (Outline ring = outline; !ring.empty();
         ring = grown(outline, -area.step_over * static_cast<double>(rings.size())))
      rings.push_back(ring);
    if (!from_outside) std::reverse(rings.begin(), rings.end());
    for (const Outline& ring : rings) {
      ++line;
      for (Polygon polygon : ring.polygons) {
        if (turned) std::reverse(polygon.begin(), polygon.end());
        if (!writer.empty()) polygon = starting_near(std::move(polygon), writer.last().head<2>());
        const Vector3 start = at_height(polygon.front(), z);
        const bool joined = !writer.empty() && writer.last().z() == z &&
                            (writer.last() - start).norm() < 2.0 * area.step_over &&
                            reaches(outline, writer.last().head<2>(), polygon.front());
        std::vector<Vector3> points;
        if (!joined)
          writer.travel(start, line);
        else
          points.push_back(start);
        for (std::size_t i = 1; i < polygon.size(); ++i) points.push_back(at_height(polygon[i], z));
        points.push_back(start);
        writer.pass(std::move(points), line);
      }
    }
  }
  return finished(writer);
}

ToolPath trochoidal_slot(const Trochoid& slot, const CutSettings& cut) {
  const double length = std::hypot(slot.along_W.x(), slot.along_W.y());
  require_positive("path.along_mm", length / units::mm, "mm");
  require_positive("path.advance_mm", slot.advance / units::mm, "mm");
  require_positive("path.chord_error_mm", slot.chord_error / units::mm, "mm");
  if (std::abs(slot.along_W.z()) > 1e-9 * length)
    throw InvalidInput(Fault{"path.along_mm",
                             fmt::format("z {:g} mm", slot.along_W.z() / units::mm),
                             "must be level for a trochoidal slot", "use path.axial_step_mm"});
  const double r = 0.5 * slot.slot_width - slot.cutter_radius;
  if (!(r > 0.0))
    throw InvalidInput(Fault{
        "path.slot_width_mm", fmt::format("{:g} mm", slot.slot_width / units::mm),
        fmt::format("must be wider than the cutter, {:g} mm", 2.0 * slot.cutter_radius / units::mm),
        "use kind = \"lines\" for a slot as wide as the cutter"});
  if (slot.advance > 2.0 * slot.cutter_radius)
    throw InvalidInput(Fault{"path.advance_mm", fmt::format("{:g} mm", slot.advance / units::mm),
                             "must not be larger than the cutter's diameter", ""});
  const Vector3 u = slot.along_W / length;
  const Vector3 v = Vector3::UnitZ().cross(u) * (slot.milling == Milling::down ? 1.0 : -1.0);
  const double turns = length / slot.advance;
  const double widest = 2.0 * std::acos(1.0 - std::min(slot.chord_error / (r + slot.advance), 0.5));
  const int chords = static_cast<int>(std::ceil(turns * 2.0 * std::numbers::pi / widest));
  require_within("path.points", chords, 1, 10000000, "");
  PathWriter writer(cut, slot.clearance_z);
  int line = 0;
  for (double z : slot.levels) {
    const auto at = [&](int k) -> Vector3 {
      const double part = static_cast<double>(k) / chords;
      const double t = 2.0 * std::numbers::pi * turns * part;
      Vector3 p = slot.start_W + length * part * u + r * (std::cos(t) * u + std::sin(t) * v);
      p.z() = z;
      return p;
    };
    writer.travel(at(0), ++line);
    std::vector<Vector3> points;
    for (int k = 1; k <= chords; ++k) points.push_back(at(k));
    writer.pass(std::move(points), line);
  }
  return finished(writer);
}

}  // namespace osteomill::workpiece
