// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/outline.hpp"

#include <algorithm>
#include <cmath>
#include <polyclipping/clipper.hpp>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

namespace {

namespace cl = ClipperLib;
constexpr double kUnit = 1e-8;          // m an integer step
constexpr double kArcTolerance = 1e-6;  // m

cl::IntPoint to_clipper(const Vector2& p) {
  return {std::llround(p.x() / kUnit), std::llround(p.y() / kUnit)};
}

Vector2 from_clipper(const cl::IntPoint& p) {
  return Vector2(static_cast<double>(p.X), static_cast<double>(p.Y)) * kUnit;
}

cl::Path to_clipper(const Polygon& polygon) {
  cl::Path path;
  path.reserve(polygon.size());
  for (const Vector2& p : polygon) path.push_back(to_clipper(p));
  return path;
}

cl::Paths to_clipper(const Outline& outline) {
  cl::Paths paths;
  for (const Polygon& polygon : outline.polygons) paths.push_back(to_clipper(polygon));
  return paths;
}

Outline from_clipper(const cl::Paths& paths) {
  Outline outline;
  for (const cl::Path& path : paths) {
    if (path.size() < 3) continue;
    Polygon polygon;
    polygon.reserve(path.size());
    for (const cl::IntPoint& p : path) polygon.push_back(from_clipper(p));
    outline.polygons.push_back(std::move(polygon));
  }
  return outline;
}

Outline combined(const Outline& a, const Outline& b, cl::ClipType how) {
  cl::Clipper clipper;
  clipper.AddPaths(to_clipper(a), cl::ptSubject, true);
  clipper.AddPaths(to_clipper(b), cl::ptClip, true);
  cl::Paths solution;
  clipper.Execute(how, solution, cl::pftNonZero, cl::pftNonZero);
  return from_clipper(solution);
}

}  // namespace

double area(const Outline& outline) {
  double sum = 0.0;
  for (const Polygon& polygon : outline.polygons)
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vector2& p = polygon[i];
      const Vector2& q = polygon[(i + 1) % polygon.size()];
      sum += 0.5 * (p.x() * q.y() - q.x() * p.y());
    }
  return sum;
}

Outline outline_of(const std::vector<Polygon>& polygons) {
  cl::Clipper clipper;
  for (const Polygon& polygon : polygons) {
    cl::Path path = to_clipper(polygon);
    if (!cl::Orientation(path)) cl::ReversePath(path);
    clipper.AddPath(path, cl::ptSubject, true);
  }
  cl::Paths solution;
  clipper.Execute(cl::ctUnion, solution, cl::pftNonZero, cl::pftNonZero);
  return from_clipper(solution);
}

Outline rectangle(const Vector2& lower, const Vector2& upper) {
  return {{{lower, {upper.x(), lower.y()}, upper, {lower.x(), upper.y()}}}};
}

Outline circle(const Vector2& centre, double radius) {
  require_positive("path.radius_mm", radius / units::mm, "mm");
  const int sides =
      std::max(8, static_cast<int>(std::ceil(M_PI / std::acos(1.0 - kArcTolerance / radius))));
  Polygon polygon;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * M_PI * i / sides;
    polygon.push_back(centre + radius * Vector2(std::cos(angle), std::sin(angle)));
  }
  return {{polygon}};
}

Outline grown(const Outline& outline, double by) {
  cl::ClipperOffset offset(2.0, kArcTolerance / kUnit);
  offset.AddPaths(to_clipper(outline), cl::jtRound, cl::etClosedPolygon);
  cl::Paths solution;
  offset.Execute(solution, by / kUnit);
  return from_clipper(solution);
}

Outline without(const Outline& outline, const Outline& taken) {
  return combined(outline, taken, cl::ctDifference);
}

Outline united(const Outline& a, const Outline& b) { return combined(a, b, cl::ctUnion); }

std::vector<std::array<Vector2, 2>> within(const Outline& outline, const Vector2& from,
                                           const Vector2& to) {
  cl::Clipper clipper;
  clipper.AddPath({to_clipper(from), to_clipper(to)}, cl::ptSubject, false);
  clipper.AddPaths(to_clipper(outline), cl::ptClip, true);
  cl::PolyTree tree;
  clipper.Execute(cl::ctIntersection, tree, cl::pftNonZero, cl::pftNonZero);
  cl::Paths open;
  cl::OpenPathsFromPolyTree(tree, open);
  const Vector2 along = (to - from).normalized();
  std::vector<std::array<Vector2, 2>> pieces;
  for (const cl::Path& path : open) {
    std::array<Vector2, 2> piece{from_clipper(path.front()), from_clipper(path.back())};
    if (along.dot(piece[1] - piece[0]) < 0.0) std::swap(piece[0], piece[1]);
    pieces.push_back(piece);
  }
  std::sort(pieces.begin(), pieces.end(), [&](const auto& a, const auto& b) {
    return along.dot(a[0] - from) < along.dot(b[0] - from);
  });
  return pieces;
}

bool reaches(const Outline& outline, const Vector2& from, const Vector2& to) {
  const double length = (to - from).norm();
  double inside = 0.0;
  for (const auto& piece : within(outline, from, to)) inside += (piece[1] - piece[0]).norm();
  // Ends on the border are rounded to the grid of integers.
  return inside > length - 10.0 * kUnit;
}

Outline shadow(const Stock& stock, double z_low, double z_high) {
  const geometry::GridShape& shape = stock.shape();
  const double h = stock.spacing();
  const Stock::Box box = stock.bone_box();
  std::vector<Polygon> runs;
  for (int y = box.first[1]; y <= box.last[1]; ++y) {
    int begin = -1;
    for (int x = box.first[0]; x <= box.last[0] + 1; ++x) {
      bool bone = false;
      for (int z = box.first[2]; x <= box.last[0] && z <= box.last[2] && !bone; ++z) {
        const double height = shape.centre(x, y, z).z();
        bone = height > z_low && height < z_high && stock.occupancy(x, y, z) >= 0.5;
      }
      if (bone && begin < 0) begin = x;
      if (bone || begin < 0) continue;
      const Vector3 first = shape.centre(begin, y, 0), last = shape.centre(x - 1, y, 0);
      // A trace of overlap makes neighbouring rows one.
      const double half = 0.5 * h + 2.0 * kUnit;
      runs.push_back(
          rectangle({first.x() - half, first.y() - half}, {last.x() + half, last.y() + half})
              .polygons.front());
      begin = -1;
    }
  }
  // Steps of the voxels are closed and opened again by half a voxel.
  return grown(grown(outline_of(runs), 0.75 * h), -0.75 * h);
}

}  // namespace osteomill::workpiece
