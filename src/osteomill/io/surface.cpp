// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/surface.hpp"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <mutex>

#include "osteomill/base/error.hpp"

namespace osteomill::io {
namespace {

using geometry::GridShape;
using geometry::Vector3;
using geometry::VoxelGrid;

/// Means over blocks; a block that the border cuts counts what is outside as nothing.
VoxelGrid<float> coarsened(const VoxelGrid<float>& fine, int factor) {
  const GridShape& from = fine.shape();
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
        coarse.at(x / factor, y / factor, z / factor) += share * fine.at(x, y, z);
  return coarse;
}

/// Without what lies beyond the plane; voxels that it cuts keep their share.
VoxelGrid<float> cut_open(VoxelGrid<float> occupancy, const CutPlane& plane) {
  const GridShape& shape = occupancy.shape();
  const Vector3 away = plane.away.normalized();
  const double across = shape.spacing.cwiseAbs().dot(away.cwiseAbs());  // a voxel, along `away`
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x) {
        const double beyond = away.dot(shape.centre(x, y, z) - plane.point) / across;
        float& share = occupancy.at(x, y, z);
        share = std::min(share, static_cast<float>(std::clamp(0.5 - beyond, 0.0, 1.0)));
      }
  return occupancy;
}

/// One half minus the occupancy: positive outside, as in a level set. One layer of air goes around,
/// so that bone at the border is closed there.
openvdb::FloatGrid::Ptr level_set_of(const VoxelGrid<float>& occupancy) {
  static std::once_flag once;
  std::call_once(once, openvdb::initialize);
  const GridShape& shape = occupancy.shape();
  const auto grid = openvdb::FloatGrid::create(0.5F);
  openvdb::FloatGrid::Accessor to = grid->getAccessor();
  for (int z = -1; z <= shape.size[2]; ++z)
    for (int y = -1; y <= shape.size[1]; ++y)
      for (int x = -1; x <= shape.size[0]; ++x)
        to.setValue({x, y, z}, 0.5F - (shape.contains(x, y, z) ? occupancy.at(x, y, z) : 0.0F));
  return grid;
}

}  // namespace

geometry::Mesh surface_of(const VoxelGrid<float>& given, const SurfaceOptions& options) {
  if (options.coarsen < 1 || !(options.simplify >= 0.0 && options.simplify <= 1.0))
    throw InvalidInput({"surface",
                        fmt::format("coarsen {}, simplify {}", options.coarsen, options.simplify),
                        "coarsen must be 1 or more, simplify 0 … 1", ""});
  VoxelGrid<float> occupancy = options.cut ? cut_open(given, *options.cut) : given;
  if (options.coarsen > 1) occupancy = coarsened(occupancy, options.coarsen);
  const GridShape& shape = occupancy.shape();
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(*level_set_of(occupancy), points, triangles, quads, 0.0,
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

geometry::Mesh surface_of(const workpiece::Stock& stock, const SurfaceOptions& options) {
  const GridShape& shape = stock.shape();
  VoxelGrid<float> occupancy(shape);
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x)
        occupancy.at(x, y, z) = static_cast<float>(stock.occupancy(x, y, z));
  geometry::Mesh mesh = surface_of(occupancy, options);
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
          const double share = occupancy.at(x, y, z);
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
