// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/placement_search.hpp"

#include <algorithm>
#include <cmath>

namespace osteomill::robot {
namespace {

struct Box {
  Vector2 centre;
  Vector2 half;
  double bound;  ///< no allowed position in the box has a smaller largest gap
};

/// For a heap with the smallest bound on top. Ties go to the smaller box, so that a plateau is
/// descended and not swept.
bool later(const Box& a, const Box& b) {
  if (a.bound != b.bound) return a.bound > b.bound;
  return a.half.sum() > b.half.sum();
}

/// What the search needs of a cut, in the frame of its line.
struct Line {
  Vector2 entry;
  Vector2 c;
  Vector2 n;
};

/// Distance from a position to the ray of a cut, and its gradient.
double ray_distance(const Line& line, double link2, const Vector2& p, Vector2& gradient) {
  const Vector2 r = p - line.entry;
  const double past = r.dot(line.c) + link2;  // > 0: before the ray's end, on the side of the bone
  const double off = r.dot(line.n);
  if (past <= 0.0) {
    gradient = off < 0.0 ? Vector2(-line.n) : line.n;
    return std::abs(off);
  }
  const double distance = std::hypot(past, off);
  gradient = distance > 0.0 ? Vector2((past * line.c + off * line.n) / distance) : Vector2(0, 0);
  return distance;
}

PerCut<Line> lines_of(const PerCut<CutLine>& cuts) {
  PerCut<Line> lines;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    lines[i] = {cuts[i].entry, cuts[i].direction,
                Vector2(-cuts[i].direction.y(), cuts[i].direction.x())};
  }
  return lines;
}

/// The box around all positions within `reach` of every ray, at most 1 m wide.
Box first_box(const PerCut<Line>& lines, double link2, double reach) {
  Vector2 low(-0.5, -0.5);
  Vector2 high(0.5, 0.5);
  for (const Line& line : lines) {
    const Vector2 end = line.entry - link2 * line.c;
    for (int k = 0; k < 2; ++k) {
      // The ray runs along −c: it bounds from below where −c has no negative component.
      if (line.c[k] <= 0.0) low[k] = std::max(low[k], end[k] - reach);
      if (line.c[k] >= 0.0) high[k] = std::min(high[k], end[k] + reach);
    }
  }
  return {0.5 * (low + high), 0.5 * (high - low), 0.0};
}

/// Lower bound of the outermost gap on a box: it is concave, so that its smallest value is at a
/// corner; where a corner may be outside the workspace its linear part bounds it.
double outer_bound(const Line& line, double link1, double link2, const Box& box) {
  const Vector2 r = box.centre - line.entry;
  const double u = r.dot(line.c) + link2;
  const double off = r.dot(line.n);
  const double spread = line.n.cwiseAbs().dot(box.half);
  if (std::abs(off) + spread >= link1) return -u - line.c.cwiseAbs().dot(box.half);
  const double du_x = line.c.x() * box.half.x();
  const double du_y = line.c.y() * box.half.y();
  const double dn_x = line.n.x() * box.half.x();
  const double dn_y = line.n.y() * box.half.y();
  double bound = std::numeric_limits<double>::infinity();
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const double n = off + sx * dn_x + sy * dn_y;
      bound = std::min(bound, std::sqrt((link1 - n) * (link1 + n)) - u - sx * du_x - sy * du_y);
    }
  }
  return bound;
}

/// Lower bound of the innermost gap, which is convex: its tangent plane, or the interval bound.
double inner_bound(const Line& line, double link1, double link2, const Box& box) {
  const Vector2 r = box.centre - line.entry;
  const double u = r.dot(line.c) + link2;
  const double off = r.dot(line.n);
  const double near = std::max(0.0, std::abs(off) - line.n.cwiseAbs().dot(box.half));
  if (near >= link1) return std::numeric_limits<double>::infinity();
  double bound = -std::sqrt((link1 - near) * (link1 + near)) - u - line.c.cwiseAbs().dot(box.half);
  if (std::abs(off) < link1) {
    const double root = std::sqrt((link1 - off) * (link1 + off));
    const Vector2 gradient = off / root * line.n - line.c;
    bound = std::max(bound, -root - u - gradient.cwiseAbs().dot(box.half));
  }
  return bound;
}

/// Upper bound of the innermost gap on a box.
double inner_ceiling(const Line& line, double link1, double link2, const Box& box) {
  const Vector2 r = box.centre - line.entry;
  const double far = std::abs(r.dot(line.n)) + line.n.cwiseAbs().dot(box.half);
  const double root = far < link1 ? std::sqrt((link1 - far) * (link1 + far)) : 0.0;
  return -root - r.dot(line.c) - link2 + line.c.cwiseAbs().dot(box.half);
}

}  // namespace

double cut_depth(const GuidePositioner& robot, const Vector2& position, const CutLine& line) {
  Vector2 gradient;
  const Line local{line.entry, line.direction, {-line.direction.y(), line.direction.x()}};
  return robot.link1 - ray_distance(local, robot.link2, position, gradient);
}

DeepestPoint deepest_point(const GuidePositioner& robot, const PerCut<CutLine>& cuts,
                           double precision) {
  const PerCut<Line> lines = lines_of(cuts);
  // The largest distance to a ray is convex; tangent planes bound it from below on a box.
  DeepestPoint best;
  double smallest = std::numeric_limits<double>::infinity();
  const auto visit = [&](Box& box) {
    double value = 0.0;
    box.bound = 0.0;
    for (const Line& line : lines) {
      Vector2 gradient;
      const double distance = ray_distance(line, robot.link2, box.centre, gradient);
      value = std::max(value, distance);
      box.bound = std::max(box.bound, distance - gradient.cwiseAbs().dot(box.half));
    }
    if (value < smallest) {
      smallest = value;
      best.position = box.centre;
    }
  };
  Box all{Vector2::Zero(), Vector2::Constant(0.5), 0.0};
  visit(all);
  std::vector<Box> heap{all};
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), later);
    const Box box = heap.back();
    heap.pop_back();
    if (box.bound > smallest - precision) break;
    const int k = box.half.x() >= box.half.y() ? 0 : 1;
    for (const double side : {-0.5, 0.5}) {
      Box part = box;
      part.centre[k] += side * box.half[k];
      part.half[k] *= 0.5;
      visit(part);
      if (part.bound > smallest - precision) continue;
      heap.push_back(part);
      std::push_heap(heap.begin(), heap.end(), later);
    }
  }
  best.depth = robot.link1 - smallest;
  return best;
}

SearchResult search_placement(const GuidePositioner& robot, const PerCut<CutLine>& cuts,
                              const PlacementOptions& options) {
  const PerCut<Line> lines = lines_of(cuts);
  const double l1 = robot.link1;
  const double l2 = robot.link2;
  const double reach = l1 - options.margin;
  SearchResult result;
  double best = std::numeric_limits<double>::infinity();

  // False when no position of the box is allowed; sets its bound and improves the best position.
  const auto visit = [&](Box& box) {
    ++result.boxes;
    bool centre_allowed = true;
    for (const Line& line : lines) {
      Vector2 gradient;
      const double distance = ray_distance(line, l2, box.centre, gradient);
      // Tangent plane of a convex function: a lower bound of the distance on the box.
      if (distance - gradient.cwiseAbs().dot(box.half) > reach) return false;
      centre_allowed = centre_allowed && distance <= reach;
    }
    box.bound = std::max(0.0, box.bound);
    for (const Line& line : lines) {
      double bound = outer_bound(line, l1, l2, box);
      if (options.branch == BranchRule::nearest && inner_ceiling(line, l1, l2, box) >= 0.0) {
        bound = std::min(bound, inner_bound(line, l1, l2, box));
      }
      box.bound = std::max(box.bound, bound);
    }
    if (!centre_allowed) return true;
    const GapReport report = gaps_at(robot, cuts, box.centre, options.branch);
    if (report.allowed && report.largest_gap < best) {
      best = report.largest_gap;
      result.found = true;
      result.position = box.centre;
    }
    return true;
  };

  std::vector<Box> heap;
  Box all = first_box(lines, l2, reach);
  if (all.half.minCoeff() > 0.0 && visit(all)) heap.push_back(all);
  result.converged = true;
  result.lower_bound = std::numeric_limits<double>::infinity();
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end(), later);
    const Box box = heap.back();
    heap.pop_back();
    if (box.bound >= best - options.precision) {
      result.lower_bound = box.bound;
      break;
    }
    // Smaller than a tenth of the precision and still without an allowed position: what it may
    // hold is thinner than any adjustment.
    if (box.half.maxCoeff() < 0.1 * options.precision) {
      result.lower_bound = std::min(result.lower_bound, box.bound);
      continue;
    }
    if (result.boxes >= options.max_boxes) {
      result.converged = false;
      result.lower_bound = std::min(result.lower_bound, box.bound);
      break;
    }
    const int k = box.half.x() >= box.half.y() ? 0 : 1;
    for (const double side : {-0.5, 0.5}) {
      Box part = box;
      part.centre[k] += side * box.half[k];
      part.half[k] *= 0.5;
      if (!visit(part) || part.bound >= best - options.precision) continue;
      heap.push_back(part);
      std::push_heap(heap.begin(), heap.end(), later);
    }
  }
  result.value = best;
  // Boxes were dropped when their bound came within the precision of the best.
  result.lower_bound = std::min(result.lower_bound, std::max(0.0, best - options.precision));
  return result;
}

}  // namespace osteomill::robot
