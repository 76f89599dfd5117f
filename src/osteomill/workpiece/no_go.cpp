// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/no_go.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/meridian.hpp"
#include "osteomill/workpiece/region.hpp"
#include "osteomill/workpiece/swept_tool.hpp"

namespace osteomill::workpiece {

namespace {

constexpr double kPrecision = 10e-6;      // m, of the least distance
constexpr double kPoseSpacing = 0.25e-3;  // m, where the axis turns

std::string in_mm(const Vector3& p) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm", p.x() / units::mm, p.y() / units::mm,
                     p.z() / units::mm);
}

struct Triangle {
  std::array<Vector3, 3> corners;
  Vector3 centre() const { return (corners[0] + corners[1] + corners[2]) / 3.0; }
  double radius() const {
    const Vector3 c = centre();
    return std::sqrt(std::max({(corners[0] - c).squaredNorm(), (corners[1] - c).squaredNorm(),
                               (corners[2] - c).squaredNorm()}));
  }
};

/// A tree of balls around triangles.
class BallTree {
 public:
  explicit BallTree(const geometry::Mesh& mesh) {
    for (const auto& t : mesh.triangles)
      triangles_.push_back({{mesh.vertices[t[0]].cast<double>(), mesh.vertices[t[1]].cast<double>(),
                             mesh.vertices[t[2]].cast<double>()}});
    if (!triangles_.empty()) build(0, triangles_.size());
  }
  bool empty() const { return triangles_.empty(); }

  /// The least value of a function that changes by at most the distance moved (a distance does),
  /// where it is below `best`: `best` and `place` then become it.
  template <class Distance>
  void least(const Distance& distance, double& best, Vector3& place) const {
    if (!nodes_.empty()) visit(0, distance, best, place);
  }

 private:
  struct Node {
    Vector3 centre;
    double radius = 0.0;
    std::size_t begin = 0, end = 0;   // of the triangles
    std::size_t left = 0, right = 0;  // 0: a leaf
  };

  std::size_t build(std::size_t begin, std::size_t end) {
    Node node;
    node.begin = begin;
    node.end = end;
    Vector3 low = triangles_[begin].corners[0], high = low;
    for (std::size_t i = begin; i < end; ++i)
      for (const Vector3& corner : triangles_[i].corners) {
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
      }
    node.centre = 0.5 * (low + high);
    for (std::size_t i = begin; i < end; ++i)
      for (const Vector3& corner : triangles_[i].corners)
        node.radius = std::max(node.radius, (corner - node.centre).norm());
    const std::size_t at = nodes_.size();
    nodes_.push_back(node);
    if (end - begin <= 4) return at;
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto from = triangles_.begin() + static_cast<std::ptrdiff_t>(begin);
    std::nth_element(from, triangles_.begin() + static_cast<std::ptrdiff_t>(middle),
                     triangles_.begin() + static_cast<std::ptrdiff_t>(end),
                     [axis](const Triangle& a, const Triangle& b) {
                       return a.centre()[axis] < b.centre()[axis];
                     });
    const std::size_t left = build(begin, middle);
    const std::size_t right = build(middle, end);
    nodes_[at].left = left;
    nodes_[at].right = right;
    return at;
  }

  template <class Distance>
  void visit(std::size_t at, const Distance& distance, double& best, Vector3& place) const {
    const Node& node = nodes_[at];
    if (node.left == 0) {
      for (std::size_t i = node.begin; i < node.end; ++i)
        divide(triangles_[i], distance, best, place);
      return;
    }
    double to_left = bound(node.left, distance), to_right = bound(node.right, distance);
    std::size_t first = node.left, second = node.right;
    if (to_right < to_left) {
      std::swap(to_left, to_right);
      std::swap(first, second);
    }
    if (to_left < best - kPrecision) visit(first, distance, best, place);
    if (to_right < best - kPrecision) visit(second, distance, best, place);
  }
  template <class Distance>
  double bound(std::size_t at, const Distance& distance) const {
    return distance(nodes_[at].centre) - nodes_[at].radius;
  }

  template <class Distance>
  static void divide(const Triangle& triangle, const Distance& distance, double& best,
                     Vector3& place) {
    const Vector3 centre = triangle.centre();
    const double here = distance(centre);
    if (here < best) {
      best = here;
      place = centre;
    }
    if (here - triangle.radius() >= best - kPrecision) return;
    const auto& [a, b, c] = triangle.corners;
    // A distance to a convex body is convex, and smooth outside: nowhere below its tangent. This
    // ends the search where a flat face lies along the tool.
    constexpr double step = 1e-6;
    Vector3 slope;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 offset = step * Vector3::Unit(axis);
      slope[axis] = (distance(centre + offset) - distance(centre - offset)) / (2.0 * step);
    }
    const double tangent =
        here + std::min({slope.dot(a - centre), slope.dot(b - centre), slope.dot(c - centre)});
    if (tangent >= best - kPrecision) return;
    const Vector3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    for (const Triangle& part : {Triangle{{a, ab, ca}}, Triangle{{ab, b, bc}},
                                 Triangle{{ca, bc, c}}, Triangle{{ab, bc, ca}}})
      divide(part, distance, best, place);
  }

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace

NoGo no_go_box(const std::string& name, const Vector3& lower, const Vector3& upper, double margin) {
  NoGo region{name, {}, 0.0, margin};
  for (int axis = 0; axis < 3; ++axis)
    require_positive("no_go.upper_mm", (upper[axis] - lower[axis]) / units::mm, "mm");
  for (int corner = 0; corner < 8; ++corner) {
    Vector3 p = lower;
    for (int axis = 0; axis < 3; ++axis)
      if (((corner >> axis) & 1) != 0) p[axis] = upper[axis];
    region.surface_W.vertices.push_back(p.cast<float>());
  }
  region.surface_W.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return region;
}

NoGo no_go_half_space(const std::string& name, const Vector3& point, const Vector3& normal,
                      double margin) {
  if (!(normal.norm() > 0.0))
    throw InvalidInput(Fault{"no_go.normal", "0", "must not be zero", ""});
  // A box of two metres with one face on the plane: the tool, whose shank has no end, cannot be in
  // it without crossing a face.
  NoGo region = no_go_box(name, Vector3(-1.0, -1.0, 0.0), Vector3(1.0, 1.0, 1.0), margin);
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), normal);
  for (Eigen::Vector3f& vertex : region.surface_W.vertices)
    vertex = (point + turn * vertex.cast<double>()).cast<float>();
  return region;
}

NoGo no_go_ball(const std::string& name, const Vector3& centre, double radius, double margin) {
  require_positive("no_go.radius_mm", radius / units::mm, "mm");
  NoGo region{name, {}, radius, margin};
  region.surface_W.vertices = {centre.cast<float>()};
  region.surface_W.triangles = {{0, 0, 0}};
  return region;
}

Approach nearest_approach(const ToolPath& path, const cutting::Cutter& cutter, const NoGo& region) {
  const BallTree tree(region.surface_W);
  if (tree.empty())
    throw InvalidInput(Fault{"no_go." + region.name, "0 triangles", "must have a surface", ""});
  const Meridian meridian(cutter);
  Approach nearest;
  nearest.distance = std::numeric_limits<double>::infinity();
  const auto meet = [&](const auto& distance, const Vector3& from, const Vector3& to,
                        std::size_t move) {
    double best = nearest.distance;
    Vector3 place = nearest.place_W;
    tree.least(distance, best, place);
    if (!(best < nearest.distance)) return;
    const Vector3 way = to - from;
    const double along =
        std::clamp(way.dot(place - from) / std::max(way.squaredNorm(), 1e-18), 0.0, 1.0);
    nearest = {best, from + along * way, place, move};
  };
  for (std::size_t m = 0; m < path.moves().size(); ++m) {
    const Move& move = path.moves()[m];
    for (std::size_t i = 1; i < move.points_W.size(); ++i) {
      const Vector3& from = move.points_W[i - 1];
      const Vector3& to = move.points_W[i];
      if (move.axes_W.empty()) {
        const SweptTool swept(meridian, from, to);
        meet([&](const Vector3& p) { return swept.distance(p); }, from, to, m);
        continue;
      }
      const int poses = std::max(1, static_cast<int>(std::ceil((to - from).norm() / kPoseSpacing)));
      for (int k = 0; k <= poses; ++k) {
        const double part = static_cast<double>(k) / poses;
        const Vector3 tip = from + part * (to - from);
        const Vector3 axis = turned(move.axes_W[i - 1], move.axes_W[i], part);
        meet(
            [&](const Vector3& p) {
              const double height = axis.dot(p - tip);
              return meridian.distance((p - tip - height * axis).norm(), height);
            },
            tip, tip, m);
      }
    }
  }
  nearest.distance -= region.thickness;
  return nearest;
}

std::vector<Approach> check_no_go(const ToolPath& path, const cutting::Cutter& cutter,
                                  const std::vector<NoGo>& regions) {
  std::vector<Approach> approaches;
  FaultList faults;
  for (const NoGo& region : regions)
    faults.gather([&] {
      const Approach near = nearest_approach(path, cutter, region);
      approaches.push_back(near);
      if (near.distance >= region.margin) return;
      const Move& move = path.moves()[near.move];
      throw InvalidInput(Fault{
          "no_go." + region.name,
          fmt::format("the {} of line {} comes {} with the tip near {}, at {} of the region",
                      move.kind == MoveKind::rapid ? "rapid" : "cut", move.line,
                      near.distance > 0.0
                          ? fmt::format("within {:.2f} mm", near.distance / units::mm)
                          : fmt::format("{:.2f} mm into it", -near.distance / units::mm),
                      in_mm(near.tip_W), in_mm(near.place_W)),
          fmt::format("must keep a margin of {:g} mm: {:.2f} mm are missing",
                      region.margin / units::mm, (region.margin - near.distance) / units::mm),
          move.kind == MoveKind::rapid
              ? "go over it with a larger path.clearance_mm"
              : "make the outline of the path smaller there (path.avoid_no_go), tilt the work "
                "frame, or use a smaller cutter"});
    });
  faults.raise();
  return approaches;
}

namespace {

/// The part of a triangle that reaches a height, seen from above.
Polygon shadow_above(const std::array<Vector3, 3>& corners, double height) {
  Polygon shadow;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 &a = corners[k], &b = corners[(k + 1) % 3];
    const double over_a = a.z() - height, over_b = b.z() - height;
    if (over_a >= 0.0) shadow.push_back(a.head<2>());
    if ((over_a < 0.0) != (over_b < 0.0))
      shadow.push_back((a + over_a / (over_a - over_b) * (b - a)).head<2>());
  }
  return shadow;
}

}  // namespace

Outline forbidden(const NoGo& region, const cutting::Cutter& cutter, double tip_z) {
  std::vector<Polygon> shadows;
  for (const auto& t : region.surface_W.triangles) {
    std::array<Vector3, 3> corners;
    double top = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = region.surface_W.vertices[t[k]].cast<double>();
      top = std::max(top, corners[k].z());
    }
    if (top + region.thickness + region.margin < tip_z) continue;
    if (region.thickness > 0.0) {
      shadows.push_back(circle(corners[0].head<2>(), region.thickness).polygons.front());
      continue;
    }
    const Polygon shadow = shadow_above(corners, tip_z - region.margin);
    if (shadow.size() >= 3) shadows.push_back(shadow);
  }
  if (shadows.empty()) return {};
  // A hundredth of a millimetre is more than the rounding of offsets.
  return grown(outline_of(shadows), cutter.radius + region.margin + 0.01 * units::mm);
}

namespace {

constexpr double kFarAway = 1.0;  // m; a section that goes on that far leaves every opening
constexpr int kSides = 72;        // of a leaning tool's section

/// Depth of a leaning tool's section with a level plane within an opening, m, < 0 where it is
/// outside; infinite when the tool does not meet the plane, or when it is sure to be `enough`.
double leaning_gap(const Meridian& meridian, const ToolPose& pose, const Region& opening,
                   double height, double enough) {
  const auto distance = [&](const Vector3& p) {
    const Vector3 from_tip = p - pose.tip_W;
    const double up = pose.axis_W.dot(from_tip);
    return meridian.distance((from_tip - up * pose.axis_W).norm(), up);
  };
  // The deepest point in the tool lies, by symmetry, in the upright plane of the axis. The distance
  // to a convex body is convex along a line.
  const Vector3 foot(pose.tip_W.x(), pose.tip_W.y(), height);
  const Vector3 lean(pose.axis_W.x(), pose.axis_W.y(), 0.0);
  const Vector3 along = lean.normalized();
  double low = -kFarAway, high = kFarAway;
  for (int k = 0; k < 80; ++k) {
    const double third = (high - low) / 3.0;
    const bool below = distance(foot + (low + third) * along) <=  // flat ends: to the tip's side
                       distance(foot + (high - third) * along);
    (below ? high : low) = below ? high - third : low + third;
  }
  const Vector3 middle = foot + 0.5 * (low + high) * along;
  const double infinite = std::numeric_limits<double>::infinity();
  if (distance(middle) >= 0.0) return infinite;
  const auto border = [&](const Vector3& direction) {
    double inside = 0.0, outside = kFarAway;
    for (int halving = 0; halving < 30; ++halving) {
      const double half = 0.5 * (inside + outside);
      (distance(middle + half * direction) < 0.0 ? inside : outside) = half;
    }
    return inside;
  };
  const auto depth = [&](const Vector3& p) { return -opening(Vector3(p.x(), p.y(), 0.0)); };
  const double reach = std::max(border(along), border(-along)) + meridian.radius();
  if (depth(middle) - reach > enough) return infinite;
  const Vector3 across = Vector3::UnitZ().cross(along);
  double gap = infinite;
  for (int k = 0; k < kSides; ++k) {
    const double angle = 2.0 * M_PI * k / kSides;
    const Vector3 direction = std::cos(angle) * along + std::sin(angle) * across;
    gap = std::min(gap, depth(middle + border(direction) * direction));
  }
  return gap;
}

/// The same for an upright tool, whose section is a disk.
double upright_gap(const Meridian& meridian, const Vector3& tip, const Region& opening,
                   double height) {
  const double above = height - tip.z();
  if (above < 0.0) return std::numeric_limits<double>::infinity();
  return -opening(Vector3(tip.x(), tip.y(), 0.0)) -
         std::max(0.0, meridian.section_radius(above, 0.0));
}

}  // namespace

double check_access(const ToolPath& path, const cutting::Cutter& cutter,
                    const AccessWindow& window) {
  const Region opening = prism(window.outline, -1.0, 1.0);
  const Meridian meridian(cutter);
  double least = std::numeric_limits<double>::infinity();
  Vector3 worst = Vector3::Zero();
  int line = 0;
  // Radius and distance change slowly: a tenth of a millimetre between places is fine enough.
  const int places = std::max(1, static_cast<int>(std::ceil(path.length() / (0.1 * units::mm))));
  for (int k = 0; k <= places; ++k) {
    const PathPoint at = path.at(path.length() * k / places);
    const bool upright = at.axis_W.z() > 0.0 && at.axis_W.head<2>().norm() < 1e-9;
    const double distance = upright
                                ? upright_gap(meridian, at.position_W, opening, window.height)
                                : leaning_gap(meridian, at.pose(), opening, window.height, least);
    if (distance >= least) continue;
    least = distance;
    worst = at.position_W;
    line = path.moves()[at.move].line;
  }
  if (least < 0.0)
    throw InvalidInput(Fault{"access",
                             fmt::format("line {} with the tip at {}", line, in_mm(worst)),
                             fmt::format("must leave the tool inside the window: it is {:.2f} mm "
                                         "outside",
                                         -least / units::mm),
                             "move or enlarge the window, or use a smaller cutter"});
  return least;
}

}  // namespace osteomill::workpiece
