// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/placement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/robot/placement_search.hpp"

namespace osteomill::robot {
namespace {

double sign(Branch branch) { return branch == Branch::outermost ? 1.0 : -1.0; }

std::string names(const std::vector<Cut>& cuts) {
  std::string text;
  for (const Cut cut : cuts) text += (text.empty() ? "" : ", ") + std::string(name(cut));
  return text;
}

/// Why nothing is allowed: the position of the least violation, and the cuts that fail there.
void explain(const GuidePositioner& robot, const PerCut<CutLine>& lines,
             const PlacementOptions& options, Placement& placement) {
  const DeepestPoint deepest = deepest_point(robot, lines, options.precision);
  std::vector<Cut> failing;
  for (const Cut cut : kCuttingOrder) {
    const double depth = cut_depth(robot, deepest.position, lines[index(cut)]);
    // Cuts that bind at the least violation, to ten times the search's precision.
    if (depth <= deepest.depth + 10.0 * options.precision) failing.push_back(cut);
  }
  placement.axis_position = deepest.position;
  placement.limiting_cut = failing.front();
  if (deepest.depth < 0.0) {
    placement.reason = fmt::format(
        "no position of the first axis serves all five cuts: at best {} fail by {:.2f} mm; "
        "lengthen L1 = {:g} mm, shorten L2 = {:g} mm, or choose another size",
        names(failing), -deepest.depth / units::mm, robot.link1 / units::mm,
        robot.link2 / units::mm);
  } else {
    placement.reason = fmt::format(
        "no position stays allowed when the first axis is off by {:.2f} mm: {} leave at most "
        "{:.2f} mm; lower options.placement_margin_mm or change L1, L2",
        options.margin / units::mm, names(failing), deepest.depth / units::mm);
  }
}

}  // namespace

std::optional<double> gap(const GuidePositioner& robot, const Vector2& axis_position,
                          const CutLine& line, Branch branch) {
  const Vector2 from_entry = axis_position - line.entry;
  const Vector2& c = line.direction;
  const double off = c.x() * from_entry.y() - c.y() * from_entry.x();
  const double discriminant = (robot.link1 - off) * (robot.link1 + off);
  if (!(discriminant > 0.0)) return std::nullopt;
  return sign(branch) * std::sqrt(discriminant) - from_entry.dot(c) - robot.link2;
}

Vector2 gap_gradient(const GuidePositioner& robot, const Vector2& axis_position,
                     const CutLine& line, Branch branch) {
  const Vector2 from_entry = axis_position - line.entry;
  const Vector2& c = line.direction;
  const Vector2 normal{-c.y(), c.x()};
  const double off = normal.dot(from_entry);
  const double root = std::sqrt((robot.link1 - off) * (robot.link1 + off));
  return -sign(branch) * off / root * normal - c;
}

GapReport gaps_at(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                  const Vector2& axis_position, BranchRule rule) {
  GapReport report;
  report.allowed = true;
  report.largest_gap = -std::numeric_limits<double>::infinity();
  double worst = 0.0;
  for (const Cut cut : kCuttingOrder) {
    const CutLine& line = lines[index(cut)];
    auto& g = report.gaps[index(cut)];
    auto& branch = report.branches[index(cut)];
    g = gap(robot, axis_position, line, Branch::outermost);
    branch = Branch::outermost;
    if (rule == BranchRule::nearest && g) {
      const auto inner = gap(robot, axis_position, line, Branch::innermost);
      if (inner && *inner >= 0.0) {
        g = inner;
        branch = Branch::innermost;
      }
    }
    const double violation = !g ? std::numeric_limits<double>::infinity() : -*g;
    if (violation > 0.0) {
      if (report.allowed || violation > worst) {
        worst = violation;
        report.limiting_cut = cut;
      }
      report.allowed = false;
    } else if (report.allowed && *g > report.largest_gap) {
      report.largest_gap = *g;
      report.limiting_cut = cut;
    }
  }
  if (!report.allowed) report.largest_gap = 0.0;
  return report;
}

Placement place(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                const PlacementOptions& options) {
  check(robot);
  require_within("options.precision_mm", options.precision / units::mm, 1e-6, 10.0, "mm");
  require_non_negative("options.placement_margin_mm", options.margin / units::mm, "mm");
  require_within("options.max_boxes", options.max_boxes, 100.0, 1e9, "");
  Placement placement;
  const SearchResult found = search_placement(robot, lines, options);
  placement.boxes = found.boxes;
  placement.feasible = found.found;
  placement.converged = found.converged;
  if (!found.found) {
    if (found.converged) {
      explain(robot, lines, options, placement);
    } else {
      placement.reason = fmt::format(
          "the search stopped after {} boxes without an allowed position; raise options.max_boxes",
          found.boxes);
    }
    return placement;
  }
  placement.axis_position = found.position;
  placement.lower_bound = found.lower_bound;
  const GapReport report = gaps_at(robot, lines, found.position, options.branch);
  placement.largest_gap = report.largest_gap;
  placement.limiting_cut = report.limiting_cut;
  placement.branches = report.branches;
  for (const Cut cut : kCuttingOrder) {
    const double g = *report.gaps[index(cut)];
    placement.gaps[index(cut)] = g;
    // 1 µm is below what this robot can resolve; the position itself is known to `precision`.
    if (g < std::max(1e-6, 10.0 * options.precision)) placement.touching.push_back(cut);
  }
  placement.gradient = gap_gradient(robot, found.position, lines[index(report.limiting_cut)],
                                    report.branches[index(report.limiting_cut)]);
  placement.required_stroke = placement.largest_gap;
  placement.residual_gap = std::max(0.0, placement.largest_gap - robot.slide_stroke);
  if (!found.converged) {
    placement.reason = fmt::format(
        "the search stopped after {} boxes with {:.4f} mm between bound and solution; raise "
        "options.max_boxes",
        found.boxes, (placement.largest_gap - placement.lower_bound) / units::mm);
  }
  return placement;
}

GapMap gap_map(const GuidePositioner& robot, const PerCut<CutLine>& lines, const Vector2& low,
               const Vector2& high, double step, BranchRule rule) {
  check(robot);
  require_positive("map.step_mm", step / units::mm, "mm");
  if (!((high - low).minCoeff() > 0.0)) {
    throw InvalidInput(Fault{"map.high_mm", "", "must be above map.low_mm in x and y", ""});
  }
  const Eigen::Array2d counts = ((high - low) / step).array().round() + 1.0;
  if (counts.prod() > 1e7) {
    throw InvalidInput(Fault{"map.step_mm", fmt::format("{:g} mm", step / units::mm),
                             "must not make more than 10 million positions", "take a larger step"});
  }
  GapMap map;
  for (int i = 0; i < static_cast<int>(counts.x()); ++i) map.x.push_back(low.x() + i * step);
  for (int i = 0; i < static_cast<int>(counts.y()); ++i) map.y.push_back(low.y() + i * step);
  map.largest.reserve(map.x.size() * map.y.size());
  for (const double y : map.y) {
    for (const double x : map.x) {
      const GapReport report = gaps_at(robot, lines, {x, y}, rule);
      map.largest.push_back(report.allowed ? std::optional(report.largest_gap) : std::nullopt);
    }
  }
  return map;
}

PlacementTolerance placement_tolerance(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                                       const Vector2& axis_position, double radius) {
  PlacementTolerance tolerance;
  double free = std::numeric_limits<double>::infinity();
  for (const CutLine& line : lines) {
    free = std::min(free, cut_depth(robot, axis_position, line));
  }
  tolerance.to_forbidden = std::max(0.0, free);
  const double used = std::min(radius, tolerance.to_forbidden);
  const GapReport here = gaps_at(robot, lines, axis_position);
  tolerance.worst_gap = here.largest_gap;
  if (used > 0.0) {
    // 720 directions: the largest gap between two of them is missed by less than
    // (1 − cos 0.25°) = 1e-5 of the rise, for a gap that grows outward.
    for (int i = 0; i < 720; ++i) {
      const double angle = i * std::numbers::pi / 360.0;
      // Just inside the circle, so that rounding cannot step over its edge.
      const Vector2 p =
          axis_position + used * (1.0 - 1e-9) * Vector2(std::cos(angle), std::sin(angle));
      const GapReport there = gaps_at(robot, lines, p);
      if (there.allowed) tolerance.worst_gap = std::max(tolerance.worst_gap, there.largest_gap);
    }
  }
  return tolerance;
}

SafeZone safe_zone(const GuidePositioner& robot, const PerCut<CutLine>& lines, double precision) {
  check(robot);
  SafeZone zone;
  const DeepestPoint deepest = deepest_point(robot, lines, precision);
  if (!(deepest.depth > 0.0)) return zone;
  zone.exists = true;
  zone.centre = deepest.position;
  zone.radius = deepest.depth;
  zone.largest_gap = gaps_at(robot, lines, deepest.position).largest_gap;
  return zone;
}

}  // namespace osteomill::robot
