// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/surface_passes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/path_writer.hpp"

namespace osteomill::workpiece {

namespace {

constexpr double kTouching = 0.5e-6;  // m: the ball is down

struct Touch {
  Vector3 centre;
  Vector3 contact;
};
using Pass = std::vector<Touch>;

/// The ball let down from the top until it touches or reaches the bottom. A step of the distance
/// left can't go through, since the distance falls no faster than the ball.
Touch let_down(const SurfacePasses& surface, const Vector2& at) {
  const double gap = surface.ball_radius + surface.allowance;
  Vector3 centre(at.x(), at.y(), surface.top + surface.ball_radius);
  const double lowest = surface.bottom + surface.ball_radius;
  while (centre.z() > lowest) {
    const double left = surface.keep(centre) - gap;
    if (left < kTouching) break;
    centre.z() = std::max(lowest, centre.z() - left);
  }
  Vector3 slope;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 offset = 10e-6 * Vector3::Unit(axis);
    slope[axis] = surface.keep(centre + offset) - surface.keep(centre - offset);
  }
  const bool resting = surface.keep(centre) - gap < 10.0 * kTouching && slope.norm() > 0.0;
  const Vector3 out = resting ? Vector3(slope.normalized()) : Vector3::UnitZ();
  return {centre, centre - surface.ball_radius * out};
}

Pass pass_at(const SurfacePasses& surface, double across) {
  const int along = surface.along_y ? 1 : 0;
  const double from = surface.lower[along], to = surface.upper[along];
  const int count = std::max(1, static_cast<int>(std::ceil((to - from) / surface.sample)));
  Pass pass;
  for (int k = 0; k <= count; ++k) {
    const double at = from + (to - from) * k / count;
    pass.push_back(let_down(surface, surface.along_y ? Vector2(across, at) : Vector2(at, across)));
  }
  return pass;
}

double largest_gap(const Pass& a, const Pass& b) {
  double gap = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    gap = std::max({gap, (a[i].centre - b[i].centre).norm(), (a[i].contact - b[i].contact).norm()});
  return gap;
}

}  // namespace

double scallop_height(double ball_radius, double step_over) {
  require_positive("path.ball_radius_mm", ball_radius / units::mm, "mm");
  require_within("path.step_over_mm", step_over / units::mm, 0.0, 2.0 * ball_radius / units::mm,
                 "mm");
  return ball_radius - std::sqrt(ball_radius * ball_radius - 0.25 * step_over * step_over);
}

double step_over_for(double ball_radius, double scallop) {
  require_positive("path.scallop_um", scallop / units::um, "um");
  require_within("path.scallop_um", scallop / units::um, 0.0, ball_radius / units::um, "um");
  return 2.0 * std::sqrt(2.0 * ball_radius * scallop - scallop * scallop);
}

ToolPath surface_passes(const SurfacePasses& surface, const CutSettings& cut) {
  require_positive("path.sample_mm", surface.sample / units::mm, "mm");
  const double step = step_over_for(surface.ball_radius, surface.scallop);
  const int side = surface.along_y ? 0 : 1;
  for (int axis = 0; axis < 2; ++axis)
    require_positive("path.upper_mm", (surface.upper[axis] - surface.lower[axis]) / units::mm,
                     "mm");
  if (!(surface.bottom < surface.top) || !(surface.top < surface.clearance_z))
    throw InvalidInput(Fault{"path.top_mm", fmt::format("{:g} mm", surface.top / units::mm),
                             "must lie above path.bottom_mm and below the clearance", ""});
  // Walls can't be finished from above: there the passes come no nearer than a tenth of the step.
  const double nearest = 0.1 * step;
  std::vector<Pass> passes{pass_at(surface, surface.lower[side])};
  double across = surface.lower[side];
  while (across < surface.upper[side] - 1e-9) {
    double advance = std::min(step, surface.upper[side] - across);
    Pass next = pass_at(surface, across + advance);
    for (double gap = largest_gap(passes.back(), next); gap > step && advance > nearest;
         gap = largest_gap(passes.back(), next)) {
      advance = std::max(nearest, 0.98 * advance * step / gap);
      next = pass_at(surface, across + advance);
    }
    across += advance;
    passes.push_back(std::move(next));
    require_within("path.passes", static_cast<double>(passes.size()), 1, 100000, "");
  }
  PathWriter writer(cut, surface.clearance_z);
  int line = 0;
  for (Pass& pass : passes) {
    if (++line % 2 == 0) std::reverse(pass.begin(), pass.end());
    std::vector<Vector3> points;
    for (const Touch& touch : pass)
      points.push_back(touch.centre - surface.ball_radius * Vector3::UnitZ());
    if (line == 1) {
      writer.travel(points.front(), line);
      points.erase(points.begin());
    }
    writer.pass(std::move(points), line);
  }
  return ToolPath(writer.take());
}

}  // namespace osteomill::workpiece
