// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/surface.hpp"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <array>
#include <functional>
#include <mutex>

#include "osteomill/base/error.hpp"

namespace osteomill::io {
namespace {

using geometry::GridShape;
using geometry::Vector3;
using geometry::VoxelGrid;

/// Share of a voxel that is bone. Whole bones are never laid out as one dense grid: at 0.1 mm that
/// would be several times what the bone itself takes.
using Share = std::function<float(int x, int y, int z)>;

/// Means over blocks; a block that the border cuts counts what is outside as nothing.
VoxelGrid<float> coarsened(const GridShape& from, const Share& fine, int factor) {
  GridShape to;
  to.spacing = from.spacing * factor;
  to.origin = from.origin + 0.5 * (factor - 1) * from.spacing;
  for (std::size_t axis = 0; axis < 3; ++axis)
    to.size[axis] = (from.size[axis] + factor - 1) / factor;
  VoxelGrid<float> coarse(to);
  const float share = 1.0F / static_cast<float>(factor * factor * factor);
  for (int z = 0; z < from.size[2]; ++z)
    for (int y = 0; y < from.size[1]; ++y)
      for (int x = 0; x < from.size[0]; ++x)
        coarse.at(x / factor, y / factor, z / factor) += share * fine(x, y, z);
  return coarse;
}

/// Without what lies beyond the plane; voxels that it cuts keep their share.
Share cut_open(const GridShape& shape, const Share& share, const CutPlane& plane) {
  const Vector3 away = plane.away.normalized();
  const double across = shape.spacing.cwiseAbs().dot(away.cwiseAbs());  // a voxel, along `away`
  return [=](int x, int y, int z) {
    const double beyond = away.dot(shape.centre(x, y, z) - plane.point) / across;
    return std::min(share(x, y, z), static_cast<float>(std::clamp(0.5 - beyond, 0.0, 1.0)));
  };
}

/// One half minus the occupancy: positive outside, as in a level set. One layer of air goes around,
/// so that bone at the border is closed there. Leaves far from the surface are left out.
openvdb::FloatGrid::Ptr level_set_of(const GridShape& shape, const Share& share) {
  static std::once_flag once;
  std::call_once(once, openvdb::initialize);
  constexpr int kLeaf = 8, kWide = kLeaf + 2;
  const auto grid = openvdb::FloatGrid::create(0.5F);
  openvdb::FloatGrid::Accessor to = grid->getAccessor();
  std::array<float, kWide * kWide * kWide> values{};  // of a leaf and one voxel around it
  for (int z0 = -kLeaf; z0 <= shape.size[2]; z0 += kLeaf)
    for (int y0 = -kLeaf; y0 <= shape.size[1]; y0 += kLeaf)
      for (int x0 = -kLeaf; x0 <= shape.size[0]; x0 += kLeaf) {
        float least = 1.0F, most = 0.0F;
        std::size_t at = 0;
        for (int z = z0 - 1; z <= z0 + kLeaf; ++z)
          for (int y = y0 - 1; y <= y0 + kLeaf; ++y)
            for (int x = x0 - 1; x <= x0 + kLeaf; ++x) {
              const float value = shape.contains(x, y, z) ? share(x, y, z) : 0.0F;
              values[at++] = value;
              least = std::min(least, value);
              most = std::max(most, value);
            }
        if (most == 0.0F) continue;
        if (least == 1.0F) {
          to.addTile(1, {x0, y0, z0}, -0.5F, true);
          continue;
        }
        for (int z = 0; z < kLeaf; ++z)
          for (int y = 0; y < kLeaf; ++y)
            for (int x = 0; x < kLeaf; ++x)
              to.setValue(
                  {x0 + x, y0 + y, z0 + z},
                  0.5F -
                      values[static_cast<std::size_t>(((z + 1) * kWide + y + 1) * kWide + x + 1)]);
      }
  return grid;
}

geometry::Mesh surface_of(const GridShape& given_shape, const Share& given,
                          const SurfaceOptions& options) {
  if (options.coarsen < 1 || !(options.simplify >= 0.0 && options.simplify <= 1.0))
    throw InvalidInput({"surface",
                        fmt::format("coarsen {}, simplify {}", options.coarsen, options.simplify),
                        "coarsen must be 1 or more, simplify 0 … 1", ""});
  GridShape shape = given_shape;
  Share share = options.cut ? cut_open(shape, given, *options.cut) : given;
  VoxelGrid<float> coarse;
  if (options.coarsen > 1) {
    coarse = coarsened(shape, share, options.coarsen);
    shape = coarse.shape();
    share = [&](int x, int y, int z) { return coarse.at(x, y, z); };
  }
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(*level_set_of(shape, share), points, triangles, quads, 0.0,
                               options.simplify);
  geometry::Mesh mesh;
  for (const openvdb::Vec3s& p : points)
    mesh.vertices.push_back(
        (shape.origin + shape.spacing.cwiseProduct(Vector3(p.x(), p.y(), p.z()))).cast<float>());
  for (const openvdb::Vec3I& t : triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
  for (const openvdb::Vec4I& q : quads) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

}  // namespace

geometry::Mesh surface_of(const VoxelGrid<float>& occupancy, const SurfaceOptions& options) {
  return surface_of(
      occupancy.shape(), [&](int x, int y, int z) { return occupancy.at(x, y, z); }, options);
}

geometry::Mesh surface_of(const workpiece::Stock& stock, const SurfaceOptions& options) {
  const GridShape& shape = stock.shape();
  const auto occupancy = [&](int x, int y, int z) {
    return static_cast<float>(stock.occupancy(x, y, z));
  };
  geometry::Mesh mesh = surface_of(shape, occupancy, options);
  const double reach = std::max(1.0, 0.5 * options.coarsen + 0.5);
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    // The mean over the bone around the vertex: the voxel it lies in may be air.
    const Vector3 at = (vertex.cast<double>() - shape.origin).cwiseQuotient(shape.spacing);
    const auto low = [&](int axis) { return static_cast<int>(std::ceil(at[axis] - reach)); };
    const auto high = [&](int axis) { return static_cast<int>(std::floor(at[axis] + reach)); };
    double weight = 0.0;
    double sum = 0.0;
    for (int z = low(2); z <= high(2); ++z)
      for (int y = low(1); y <= high(1); ++y)
        for (int x = low(0); x <= high(0); ++x) {
          if (!shape.contains(x, y, z)) continue;
          const double share = occupancy(x, y, z);
          weight += share;
          if (share > 0.0) sum += share * stock.material(x, y, z).density;
        }
    mesh.values.push_back(weight > 0.0 ? static_cast<float>(sum / weight) : 0.0F);
  }
  return mesh;
}

void colour_by(geometry::Mesh& mesh, const VoxelGrid<float>& field) {
  mesh.values.clear();
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    mesh.values.push_back(static_cast<float>(geometry::sample(field, vertex.cast<double>())));
}

}  // namespace osteomill::io
