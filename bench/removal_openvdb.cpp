// SPDX-License-Identifier: BSD-3-Clause
#include "removal_openvdb.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetMeasure.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <cmath>

namespace osteomill::bench {

namespace {
using geometry::Vector3;
constexpr double kBand = 3.0;  // voxels
constexpr int kLeaf = 8;
}  // namespace

struct VdbStock::Grid {
  openvdb::FloatGrid::Ptr grid;
  double spacing = 0.0;
};

VdbStock::VdbStock(const Vector3& lower, const Vector3& upper, double spacing)
    : grid_(std::make_unique<Grid>()) {
  openvdb::initialize();
  const auto background = static_cast<float>(kBand * spacing);
  grid_->spacing = spacing;
  grid_->grid = openvdb::FloatGrid::create(background);
  grid_->grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid_->grid->setTransform(openvdb::math::Transform::createLinearTransform(spacing));
  auto& tree = grid_->grid->tree();
  const auto index = [&](const Vector3& p) -> Vector3 { return p / spacing; };
  const Vector3 low = index(lower), high = index(upper);
  const openvdb::CoordBBox inside(openvdb::Coord(static_cast<int>(std::ceil(low.x() + kBand)),
                                                 static_cast<int>(std::ceil(low.y() + kBand)),
                                                 static_cast<int>(std::ceil(low.z() + kBand))),
                                  openvdb::Coord(static_cast<int>(std::floor(high.x() - kBand)),
                                                 static_cast<int>(std::floor(high.y() - kBand)),
                                                 static_cast<int>(std::floor(high.z() - kBand))));
  tree.fill(inside, -background, false);
  auto accessor = grid_->grid->getAccessor();
  const auto reach = static_cast<int>(kBand);
  for (int z = static_cast<int>(low.z()) - reach; z <= high.z() + kBand; ++z)
    for (int y = static_cast<int>(low.y()) - reach; y <= high.y() + kBand; ++y)
      for (int x = static_cast<int>(low.x()) - reach; x <= high.x() + kBand; ++x) {
        const openvdb::Coord at(x, y, z);
        if (inside.isInside(at)) {
          x = inside.max().x();
          continue;
        }
        const Vector3 p(x, y, z);
        const double d = (low - p).cwiseMax(p - high).maxCoeff() * spacing;
        if (std::abs(d) < kBand * spacing) accessor.setValue(at, static_cast<float>(d));
      }
}

VdbStock::~VdbStock() = default;

void VdbStock::cut_leaves(const VdbTool& tool, const Vector3& from, const Vector3& to) {
  auto& tree = grid_->grid->tree();
  const double per = 1.0 / grid_->spacing, R = tool.radius * per;
  const auto scale = static_cast<float>(grid_->spacing);
  const auto background = static_cast<float>(kBand * grid_->spacing);
  const Vector3 a = from * per, b = to * per;
  const double run = std::hypot(b.x() - a.x(), b.y() - a.y());
  const double hx = run > 0.0 ? (b.x() - a.x()) / run : 1.0;
  const double hy = run > 0.0 ? (b.y() - a.y()) / run : 0.0;
  const auto distance = [&](double x, double y, double z) {
    const double dx = x - a.x(), dy = y - a.y(), height = z - a.z();
    const double along = hx * dx + hy * dy, lateral = hx * dy - hy * dx;
    const double ahead = along - std::clamp(along, 0.0, run);
    const double r_sq = ahead * ahead + lateral * lateral;
    if (tool.ball) {
      const double below = std::min(0.0, height - R);
      return std::sqrt(r_sq + below * below) - R;
    }
    const double wall = std::sqrt(r_sq) - R;
    if (wall > 0.0 && height < 0.0) return std::sqrt(wall * wall + height * height);
    return std::max(wall, -height);
  };
  const auto leaf_of = [](double p) { return static_cast<int>(std::floor(p / kLeaf)) * kLeaf; };
  const double reach = R + kBand;
  openvdb::CoordBBox box = tree.root().getNodeBoundingBox();
  const int top = std::min(box.max().z(), static_cast<int>(std::ceil(2.0 * kBand)));
  const double half_leaf = 0.5 * kLeaf * std::sqrt(3.0);
  for (int z = leaf_of(a.z() - kBand); z <= top; z += kLeaf)
    for (int y = leaf_of(std::min(a.y(), b.y()) - reach); y <= std::max(a.y(), b.y()) + reach;
         y += kLeaf)
      for (int x = leaf_of(std::min(a.x(), b.x()) - reach); x <= std::max(a.x(), b.x()) + reach;
           x += kLeaf) {
        const double middle = 0.5 * (kLeaf - 1);
        const double d = distance(x + middle, y + middle, z + middle);
        if (d > kBand + half_leaf) continue;
        const openvdb::Coord origin(x, y, z);
        auto* leaf = tree.probeLeaf(origin);
        if (leaf == nullptr && tree.getValue(origin) > 0.0f) continue;  // air
        if (d < -kBand - half_leaf) {
          tree.addTile(1, origin, background, false);
          continue;
        }
        if (leaf == nullptr) leaf = tree.touchLeaf(origin);
        float* values = leaf->buffer().data();
        auto& mask = leaf->getValueMask();
        for (int i = 0; i < kLeaf; ++i)
          for (int j = 0; j < kLeaf; ++j) {
            float* row = values + (i * kLeaf + j) * kLeaf;
            for (int k = 0; k < kLeaf; ++k) {
              const auto tool_d = static_cast<float>(distance(x + i, y + j, z + k)) * scale;
              const float value = std::clamp(std::max(row[k], -tool_d), -background, background);
              if (value == row[k]) continue;
              row[k] = value;
              const auto at = static_cast<openvdb::Index>((i * kLeaf + j) * kLeaf + k);
              mask.set(at, std::abs(value) < background);
            }
          }
      }
}

void VdbStock::cut_csg(const VdbTool& tool, const Vector3& tip) {
  const Vector3 centre = tip + tool.radius * Vector3::UnitZ();
  const auto ball = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
      static_cast<float>(tool.radius),
      openvdb::Vec3f(static_cast<float>(centre.x()), static_cast<float>(centre.y()),
                     static_cast<float>(centre.z())),
      static_cast<float>(grid_->spacing), static_cast<float>(kBand), false);
  openvdb::tools::csgDifference(*grid_->grid, *ball);
}

double VdbStock::volume() const { return openvdb::tools::levelSetVolume(*grid_->grid); }

}  // namespace osteomill::bench
