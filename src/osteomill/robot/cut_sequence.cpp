// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/cut_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <queue>
#include <set>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

// Contact is no collision; a tenth of the placement's own precision would be lost in rounding.
constexpr double kContact = 1e-6;

double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

bool inside(const BoneOutline& bone, const Vector2& p, double shrink) {
  for (std::size_t i = 0; i < bone.size(); ++i) {
    const Vector2 edge = bone[(i + 1) % bone.size()] - bone[i];
    const double length = edge.norm();
    if (length > 0.0 && cross(edge, p - bone[i]) <= shrink * length) return false;
  }
  return bone.size() > 2;
}

double point_to_segment(const Vector2& p, const Vector2& a, const Vector2& b) {
  const Vector2 ab = b - a;
  const double square = ab.squaredNorm();
  const double t = square > 0.0 ? std::clamp((p - a).dot(ab) / square, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

bool cross_each_other(const Vector2& a, const Vector2& b, const Vector2& c, const Vector2& d) {
  const double ab_c = cross(b - a, c - a);
  const double ab_d = cross(b - a, d - a);
  const double cd_a = cross(d - c, a - c);
  const double cd_b = cross(d - c, b - c);
  return ((ab_c > 0.0) != (ab_d > 0.0)) && ((cd_a > 0.0) != (cd_b > 0.0));
}

struct Grid {
  JointRange range1;
  JointRange range2;
  int n1;
  int n2;

  JointAngles at(int cell) const {
    return {range1.low + (range1.high - range1.low) * (cell % n1) / (n1 - 1),
            range2.low + (range2.high - range2.low) * (cell / n1) / (n2 - 1)};
  }
};

double travel(const JointAngles& a, const JointAngles& b) {
  return std::hypot(a.theta1 - b.theta1, a.theta2 - b.theta2);
}

JointAngles between(const JointAngles& a, const JointAngles& b, double t) {
  return {a.theta1 + t * (b.theta1 - a.theta1), a.theta2 + t * (b.theta2 - a.theta2)};
}

/// The copy of an angle (mod 2π) that lies in the range; the angle itself when none does.
double into(const JointRange& range, double angle) {
  const double turn = 2.0 * std::numbers::pi;
  const double off = angle - 0.5 * (range.low + range.high);
  return angle - turn * std::round(off / turn);
}

class PathSearch {
 public:
  PathSearch(const GuidePositioner& robot, const Vector2& axis_position, const BoneOutline& bone,
             double keep, double step)
      : robot_(robot), axis_position_(axis_position), bone_(bone), keep_(keep), step_(step) {}

  std::vector<JointAngles> find(const JointAngles& from, const JointAngles& to) {
    if (free(from, to)) return {from, to};
    const auto cells = [&](const JointRange& range) {
      return std::max(2, static_cast<int>(std::ceil((range.high - range.low) / step_)) + 1);
    };
    const Grid grid{robot_.range1, robot_.range2, cells(robot_.range1), cells(robot_.range2)};
    const int count = grid.n1 * grid.n2;
    std::vector<double> cost(static_cast<std::size_t>(count), -1.0);
    std::vector<int> parent(static_cast<std::size_t>(count), -1);
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    // The start joins the grid at its nearest nodes, and every node near the goal may reach it.
    for (int cell = 0; cell < count; ++cell) {
      const JointAngles node = grid.at(cell);
      if (std::abs(node.theta1 - from.theta1) > step_ ||
          std::abs(node.theta2 - from.theta2) > step_ || !free(from, node)) {
        continue;
      }
      cost[static_cast<std::size_t>(cell)] = travel(from, node);
      open.push({travel(from, node) + travel(node, to), cell});
    }
    while (!open.empty()) {
      const auto [estimate, cell] = open.top();
      open.pop();
      const JointAngles node = grid.at(cell);
      const double here = cost[static_cast<std::size_t>(cell)];
      if (estimate > here + travel(node, to) + 1e-12) continue;
      if (std::abs(node.theta1 - to.theta1) <= step_ &&
          std::abs(node.theta2 - to.theta2) <= step_ && free(node, to)) {
        std::vector<JointAngles> path{to};
        for (int at = cell; at >= 0; at = parent[static_cast<std::size_t>(at)]) {
          path.push_back(grid.at(at));
        }
        path.push_back(from);
        std::reverse(path.begin(), path.end());
        return shortened(path);
      }
      const int i = cell % grid.n1;
      const int j = cell / grid.n1;
      for (int di = -1; di <= 1; ++di) {
        for (int dj = -1; dj <= 1; ++dj) {
          const int ni = i + di;
          const int nj = j + dj;
          if ((di == 0 && dj == 0) || ni < 0 || nj < 0 || ni >= grid.n1 || nj >= grid.n2) continue;
          const int next = nj * grid.n1 + ni;
          const JointAngles there = grid.at(next);
          const double reached = here + travel(node, there);
          double& known = cost[static_cast<std::size_t>(next)];
          if ((known >= 0.0 && known <= reached) || !free(node, there)) continue;
          known = reached;
          parent[static_cast<std::size_t>(next)] = cell;
          open.push({reached + travel(there, to), next});
        }
      }
    }
    return {};
  }

 private:
  bool free(const JointAngles& joints) const {
    const GuidePose pose = forward(robot_, axis_position_, joints);
    return !overlaps(bone_, pose) && clearance(bone_, pose) >= keep_ - kContact;
  }

  /// The straight move, looked at every quarter of the step.
  bool free(const JointAngles& a, const JointAngles& b) const {
    const int pieces = std::max(1, static_cast<int>(std::ceil(4.0 * travel(a, b) / step_)));
    for (int i = 0; i <= pieces; ++i) {
      if (!free(between(a, b, static_cast<double>(i) / pieces))) return false;
    }
    return true;
  }

  std::vector<JointAngles> shortened(const std::vector<JointAngles>& path) const {
    std::vector<JointAngles> kept{path.front()};
    std::size_t at = 0;
    while (at + 1 < path.size()) {
      std::size_t next = path.size() - 1;
      while (next > at + 1 && !free(path[at], path[next])) --next;
      kept.push_back(path[next]);
      at = next;
    }
    return kept;
  }

  const GuidePositioner& robot_;
  Vector2 axis_position_;
  const BoneOutline& bone_;
  double keep_;
  double step_;
};

}  // namespace

bool overlaps(const BoneOutline& bone, const GuidePose& pose) {
  constexpr int kPieces = 64;  // of a guide of some 30 mm: a point every half millimetre
  for (int i = 0; i <= kPieces; ++i) {
    const double t = static_cast<double>(i) / kPieces;
    if (inside(bone, pose.X1 + t * (pose.X2 - pose.X1), kContact)) return true;
  }
  return false;
}

BoneOutline generic_bone(const Profile& profile, double cover) {
  require_non_negative("bone.cover_mm", cover / units::mm, "mm");
  const auto& p = profile.corners;
  std::vector<Vector2> shifted(6);
  const auto outward = [&](std::size_t i) {
    const Vector2 along = (p[i + 1] - p[i]).normalized();
    return Vector2(-along.y(), along.x());
  };
  shifted[0] = p[0] + cover * outward(0);
  shifted[5] = p[5] + cover * outward(4);
  for (std::size_t i = 1; i < 5; ++i) {
    // Both neighbouring cuts move outward by the cover; their crossing moves along the bisector.
    const Vector2 a = outward(i - 1);
    const Vector2 b = outward(i);
    shifted[i] = p[i] + cover * (a + b) / (1.0 + a.dot(b));
  }
  // Corners run clockwise from anterior to posterior; the outline runs the other way round.
  return {shifted.rbegin(), shifted.rend()};
}

BoneOutline after_cut(const BoneOutline& bone, const CutLine& line) {
  // The inner side is the one where the middle of the bone lies.
  Vector2 middle = Vector2::Zero();
  for (const Vector2& p : bone) middle += p / static_cast<double>(bone.size());
  const double side = cross(line.direction, middle - line.entry) >= 0.0 ? 1.0 : -1.0;
  BoneOutline left;
  for (std::size_t i = 0; i < bone.size(); ++i) {
    const Vector2& a = bone[i];
    const Vector2& b = bone[(i + 1) % bone.size()];
    const double da = side * cross(line.direction, a - line.entry);
    const double db = side * cross(line.direction, b - line.entry);
    if (da >= 0.0) left.push_back(a);
    if ((da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0))
      left.push_back(a + da / (da - db) * (b - a));
  }
  return left;
}

std::optional<double> first_bone(const BoneOutline& bone, const CutLine& line) {
  // The line clipped by the half planes of a convex polygon.
  double first = -std::numeric_limits<double>::infinity();
  double last = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < bone.size(); ++i) {
    const Vector2 edge = bone[(i + 1) % bone.size()] - bone[i];
    if (edge.norm() < 1e-12) continue;
    const double at = cross(edge, line.entry - bone[i]) / edge.norm();
    const double slope = cross(edge, line.direction) / edge.norm();
    if (std::abs(slope) < 1e-12) {
      // Along an edge: the line touches the bone, which counts as meeting it.
      if (at < -kContact) return std::nullopt;
      continue;
    }
    (slope > 0.0 ? first : last) =
        slope > 0.0 ? std::max(first, -at / slope) : std::min(last, -at / slope);
  }
  if (bone.size() < 3 || first > last) return std::nullopt;
  return first;
}

double clearance(const BoneOutline& bone, const GuidePose& pose) {
  if (bone.size() < 3) return std::numeric_limits<double>::infinity();
  if (inside(bone, pose.X1, 0.0) || inside(bone, pose.X2, 0.0)) return 0.0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < bone.size(); ++i) {
    const Vector2& a = bone[i];
    const Vector2& b = bone[(i + 1) % bone.size()];
    if (cross_each_other(pose.X1, pose.X2, a, b)) return 0.0;
    least =
        std::min({least, point_to_segment(pose.X1, a, b), point_to_segment(pose.X2, a, b),
                  point_to_segment(a, pose.X1, pose.X2), point_to_segment(b, pose.X1, pose.X2)});
  }
  return least;
}

std::vector<JointAngles> densified(const std::vector<JointAngles>& path, double step) {
  std::vector<JointAngles> dense;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const double longest = std::max(std::abs(path[i + 1].theta1 - path[i].theta1),
                                    std::abs(path[i + 1].theta2 - path[i].theta2));
    const int pieces = std::max(1, static_cast<int>(std::ceil(longest / step)));
    for (int k = 0; k < pieces; ++k) {
      dense.push_back(between(path[i], path[i + 1], static_cast<double>(k) / pieces));
    }
  }
  if (!path.empty()) dense.push_back(path.back());
  return dense;
}

std::vector<SequenceStep> plan_sequence(const GuidePositioner& robot, const Profile& profile,
                                        const CutOptions& cuts, const BoneOutline& bone,
                                        const Vector2& axis_position,
                                        const PerCut<Branch>& branches,
                                        const SequenceOptions& options) {
  check(robot);
  require_within("sequence.joint_step_deg", options.joint_step / units::deg, 0.1, 20.0, "deg");
  require_non_negative("sequence.clearance_mm", options.clearance / units::mm, "mm");
  if (std::set<Cut>(options.order.begin(), options.order.end()).size() != 5 ||
      options.order.size() != 5) {
    throw InvalidInput(Fault{"sequence.order", fmt::format("{} cuts", options.order.size()),
                             "must name each of the five cuts once", ""});
  }
  const PerCut<CutLine> lines = cut_lines(profile, cuts);
  // The tool's inner edge makes the surface: it runs on the line of a tool without thickness.
  const PerCut<CutLine> edges = cut_lines(profile, {.distal_overhang = cuts.distal_overhang});
  std::vector<SequenceStep> steps;
  BoneOutline left = bone;
  for (const Cut cut : options.order) {
    SequenceStep step;
    step.cut = cut;
    const CutLine& edge = edges[index(cut)];
    const auto joints = inverse(robot, axis_position, lines[index(cut)], branches[index(cut)]);
    if (!joints) {
      step.trouble = "outside the workspace";
    } else {
      step.joints = {into(robot.range1, joints->theta1), into(robot.range2, joints->theta2)};
      step.pose = forward(robot, axis_position, step.joints);
      step.reachable = within_limits(robot, step.joints);
      if (!step.reachable) {
        step.trouble =
            fmt::format("joint limit: theta1 {:.1f} deg, theta2 {:.1f} deg",
                        step.joints.theta1 / units::deg, step.joints.theta2 / units::deg);
      }
      const auto meets = first_bone(left, edge);
      step.gap = meets ? *meets - (step.pose.X2 - edge.entry).dot(edge.direction) : 0.0;
      step.collides = overlaps(left, step.pose);
      if (step.collides) step.trouble = "the guide stands in bone that is not yet cut";
    }
    if (steps.empty() || !steps.back().reachable || !step.reachable || step.collides ||
        steps.back().collides) {
      step.path_found = steps.empty();
      if (!steps.empty() && step.trouble.empty()) step.trouble = "the cut before has no position";
    } else {
      const SequenceStep& before = steps.back();
      // Nobody can keep more distance on the way than there is at its ends.
      const double keep =
          std::min({options.clearance, clearance(left, before.pose), clearance(left, step.pose)});
      PathSearch search(robot, axis_position, left, keep, options.joint_step);
      step.path = search.find(before.joints, step.joints);
      step.path_found = !step.path.empty();
      if (!step.path_found) step.trouble = "no way past the bone from the cut before";
    }
    steps.push_back(step);
    left = after_cut(left, edge);
  }
  return steps;
}

}  // namespace osteomill::robot
