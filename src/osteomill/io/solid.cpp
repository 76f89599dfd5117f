// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/solid.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>

#include <cmath>
#include <mutex>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/geometry/mesh_check.hpp"

namespace osteomill::io {

using geometry::Vector3;

struct Solid::Grid {
  openvdb::FloatGrid::Ptr values;
};

Solid::Solid(const geometry::Mesh& mesh, const SolidOptions& options) {
  static std::once_flag once;
  std::call_once(once, openvdb::initialize);
  require_positive("surface.spacing_mm", options.spacing / units::mm, "mm");
  if (mesh.vertices.empty() || !(geometry::volume(mesh) > 0.0))
    throw InvalidInput({"surface", "", "must enclose a solid, corners counter-clockwise", ""});
  std::vector<openvdb::Vec3s> points;
  points.reserve(mesh.vertices.size());
  lower_ = upper_ = mesh.vertices.front().cast<double>();
  for (const Eigen::Vector3f& v : mesh.vertices) {
    points.emplace_back(v.x(), v.y(), v.z());
    lower_ = lower_.cwiseMin(v.cast<double>());
    upper_ = upper_.cwiseMax(v.cast<double>());
  }
  std::vector<openvdb::Vec3I> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  // Bands are counted in voxels; three is the least that OpenVDB keeps right.
  const auto band = [&](double width) {
    return static_cast<float>(std::max(3.0, std::ceil(width / options.spacing)));
  };
  const auto transform = openvdb::math::Transform::createLinearTransform(options.spacing);
  auto grid = std::make_shared<Grid>();
  grid->values = openvdb::tools::meshToSignedDistanceField<openvdb::FloatGrid>(
      *transform, points, triangles, {}, band(options.outside), band(options.inside));
  grid_ = std::move(grid);
}

double Solid::distance(const Vector3& p) const {
  // Without an accessor: a lookup that writes nothing, for any number of threads.
  const openvdb::Vec3d at = grid_->values->transform().worldToIndex({p.x(), p.y(), p.z()});
  float value = 0.0F;
  openvdb::tools::BoxSampler::sample(grid_->values->tree(), at, value);
  return value;
}

}  // namespace osteomill::io
