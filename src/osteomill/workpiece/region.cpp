// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/region.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

Region half_space(const Vector3& point, const Vector3& normal) {
  require_positive("region.normal", normal.norm(), "");
  const Vector3 n = normal.normalized();
  return [point, n](const Vector3& p) { return -n.dot(p - point); };
}

Region box(const Vector3& lower, const Vector3& upper) {
  for (int axis = 0; axis < 3; ++axis)
    require_positive("region.size_mm", (upper[axis] - lower[axis]) / units::mm, "mm");
  return [lower, upper](const Vector3& p) {
    const Vector3 beyond = (lower - p).cwiseMax(p - upper);
    return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
  };
}

Region ball(const Vector3& centre, double radius) {
  require_positive("region.radius_mm", radius / units::mm, "mm");
  return [centre, radius](const Vector3& p) { return (p - centre).norm() - radius; };
}

Region prism(const Outline& outline, double z_low, double z_high) {
  require_positive("region.height_mm", (z_high - z_low) / units::mm, "mm");
  if (outline.empty())
    throw InvalidInput(Fault{"region.outline", "nothing", "must enclose an area", ""});
  return [outline, z_low, z_high](const Vector3& p) {
    double nearest = std::numeric_limits<double>::infinity();
    bool inside = false;
    for (const Polygon& polygon : outline.polygons)
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vector2& a = polygon[i];
        const Vector2& b = polygon[(i + 1) % polygon.size()];
        const Vector2 at = p.head<2>();
        const double t = std::clamp((at - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (at - a - t * (b - a)).norm());
        // Even-odd, which holes of an outline are made for.
        if ((a.y() > at.y()) != (b.y() > at.y()) &&
            at.x() < a.x() + (at.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
          inside = !inside;
      }
    const double side = inside ? -nearest : nearest;
    const double height = std::max(z_low - p.z(), p.z() - z_high);
    return std::hypot(std::max(side, 0.0), std::max(height, 0.0)) +
           std::min(0.0, std::max(side, height));
  };
}

Region any_of(std::vector<Region> regions) {
  if (regions.empty()) throw InvalidInput(Fault{"region", "none", "must have a part", ""});
  return [regions = std::move(regions)](const Vector3& p) {
    double least = std::numeric_limits<double>::infinity();
    for (const Region& region : regions) least = std::min(least, region(p));
    return least;
  };
}

Region all_of(std::vector<Region> regions) {
  if (regions.empty()) throw InvalidInput(Fault{"region", "none", "must have a part", ""});
  return [regions = std::move(regions)](const Vector3& p) {
    double largest = -std::numeric_limits<double>::infinity();
    for (const Region& region : regions) largest = std::max(largest, region(p));
    return largest;
  };
}

Region outside(Region region) {
  return [region = std::move(region)](const Vector3& p) { return -region(p); };
}

PlanResult compare(const Stock& before, const Stock& after, const Region& plan) {
  const geometry::GridShape& shape = before.shape();
  if (shape.size != after.shape().size || shape.origin != after.shape().origin)
    throw InvalidInput(Fault{"stock", "two grids", "must be the same before and after", ""});
  const double h = before.spacing(), voxel = shape.voxel_volume();
  const Stock::Box box = before.bone_box();
  PlanResult result;
  for (int z = box.first[2]; z <= box.last[2]; ++z)
    for (int y = box.first[1]; y <= box.last[1]; ++y)
      for (int x = box.first[0]; x <= box.last[0]; ++x) {
        const double was = before.occupancy(x, y, z);
        if (was == 0.0) continue;
        const double left = after.occupancy(x, y, z);
        const double d = plan(shape.centre(x, y, z));
        const double inside = std::clamp(0.5 - d / h, 0.0, 1.0);
        // A voxel on the border keeps its bone on the side away from the plan, and a cut up to the
        // border takes what lies on the other.
        const double planned = std::max(0.0, std::min(was, inside + was - 1.0));
        const double kept = was - planned;
        const double over = std::max(0.0, kept - left);
        result.planned_volume += planned * voxel;
        result.uncut_volume += std::max(0.0, left - kept) * voxel;
        result.over_cut_volume += over * voxel;
        result.removed_volume += (was - left - over) * voxel;
        if (left >= 0.5) result.uncut_height = std::max(result.uncut_height, -d - 0.5 * h);
        if (was - left >= 0.5 * was && was >= 0.5)
          result.over_cut_depth = std::max(result.over_cut_depth, d - 0.5 * h);
      }
  return result;
}

}  // namespace osteomill::workpiece
