// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/stock.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::workpiece {

namespace {

constexpr std::size_t kMostMaterials = 65535;

struct MaterialHash {
  std::size_t operator()(const BoneMaterial& material) const {
    return std::hash<double>()(material.density) * 31 + std::hash<double>()(material.force_scale);
  }
};
struct SameMaterial {
  bool operator()(const BoneMaterial& a, const BoneMaterial& b) const {
    return a.density == b.density && a.force_scale == b.force_scale;
  }
};

/// Materials in the order in which they were first met.
class Palette {
 public:
  std::uint16_t index(const BoneMaterial& material) {
    // Neighbours are mostly of one material.
    if (last_ < materials_.size() && SameMaterial()(material, materials_[last_]))
      return static_cast<std::uint16_t>(last_);
    const auto [place, is_new] = index_.try_emplace(material, materials_.size());
    if (is_new) {
      if (materials_.size() == kMostMaterials) throw_too_many();
      materials_.push_back(material);
    }
    last_ = place->second;
    return static_cast<std::uint16_t>(last_);
  }
  const std::vector<BoneMaterial>& materials() const { return materials_; }

 private:
  [[noreturn]] static void throw_too_many() {
    throw InvalidInput(Fault{"stock.material", fmt::format("more than {}", kMostMaterials),
                             "must not have more different materials than that",
                             "round densities, for instance to 1 kg/m³"});
  }
  std::unordered_map<BoneMaterial, std::size_t, MaterialHash, SameMaterial> index_;
  std::vector<BoneMaterial> materials_;
  std::size_t last_ = 0;
};

int tiles_over(int voxels, int tile) { return (voxels + tile - 1) / tile; }

void check(const geometry::GridShape& shape) {
  const double spacing = shape.spacing.x();
  require_positive("stock.spacing_mm", spacing / units::mm, "mm");
  if ((shape.spacing.array() - spacing).abs().maxCoeff() > 1e-9 * spacing)
    throw InvalidInput(
        Fault{"stock.spacing_mm",
              fmt::format("{} x {} x {} mm", spacing / units::mm, shape.spacing.y() / units::mm,
                          shape.spacing.z() / units::mm),
              "must be the same along x, y and z", "resample to cubes"});
  for (int size : shape.size)
    // The tiles of a slab are counted in 32 bits.
    require_within("stock.size", size, 1, (1 << 17) - 1, "voxels");
}

}  // namespace

/// The tiles of kTile layers, with places in `materials` for the palette.
Stock::Slab Stock::build_slab(const geometry::GridShape& shape, int first_layer,
                              const std::function<BoneSample(const Vector3&)>& bone,
                              std::vector<BoneMaterial>& materials, std::int64_t* layer_units) {
  const int along_x = tiles_over(shape.size[0], kTile), along_y = tiles_over(shape.size[1], kTile);
  const double per_metre = 1.0 / shape.spacing.x();
  Slab slab;
  slab.tiles.assign(static_cast<std::size_t>(along_x) * static_cast<std::size_t>(along_y), 0);
  slab.row_units.assign(static_cast<std::size_t>(along_y), 0);
  std::vector<Occupancy> occupancy(kTileVoxels, 0);
  std::vector<std::uint16_t> material(kTileVoxels, 0);
  Palette palette;
  for (std::size_t tile = 0; tile < slab.tiles.size(); ++tile) {
    const std::size_t start = occupancy.size();
    occupancy.resize(start + kTileVoxels, 0);
    material.resize(start + kTileVoxels, 0);
    const int tile_y = static_cast<int>(tile) / along_x;
    const int x0 = static_cast<int>(tile) % along_x * kTile, y0 = tile_y * kTile;
    std::int64_t units = 0;
    for (int z = first_layer; z < std::min(first_layer + kTile, shape.size[2]); ++z)
      for (int y = y0; y < std::min(y0 + kTile, shape.size[1]); ++y)
        for (int x = x0; x < std::min(x0 + kTile, shape.size[0]); ++x) {
          const BoneSample sample = bone(shape.centre(x, y, z));
          const double share = std::clamp(0.5 - sample.signed_distance * per_metre, 0.0, 1.0);
          const auto taken = static_cast<Occupancy>(std::lround(share * kFull));
          if (taken == 0) continue;
          const std::size_t at = start + static_cast<std::size_t>((z - first_layer) * kTileLayer +
                                                                  (y - y0) * kTile + (x - x0));
          occupancy[at] = taken;
          material[at] = palette.index(sample.material);
          units += taken;
          layer_units[z - first_layer] += taken;
        }
    if (units == 0) {
      occupancy.resize(start);
      material.resize(start);
      continue;
    }
    slab.tiles[tile] = static_cast<std::uint32_t>(start / kTileVoxels);
    slab.row_units[static_cast<std::size_t>(tile_y)] += units;
  }
  slab.occupancy.assign(occupancy.begin(), occupancy.end());
  slab.material.assign(material.begin(), material.end());
  materials = palette.materials();
  return slab;
}

Stock::Stock(const geometry::GridShape& shape,
             const std::function<BoneSample(const Vector3& p_W)>& bone)
    : shape_(shape) {
  check(shape);
  tiles_along_x_ = tiles_over(shape.size[0], kTile);
  slabs_.resize(static_cast<std::size_t>(tiles_over(shape.size[2], kTile)));
  layer_units_.resize(slabs_.size() * kTile, 0);
  std::vector<std::vector<BoneMaterial>> materials(slabs_.size());
  tbb::parallel_for(std::size_t{0}, slabs_.size(), [&](std::size_t at) {
    slabs_[at] = build_slab(shape, static_cast<int>(at) * kTile, bone, materials[at],
                            &layer_units_[at * kTile]);
  });
  layer_units_.resize(static_cast<std::size_t>(shape.size[2]));

  // In the order of the layers: the palette does not depend on the threads.
  Palette palette;
  for (std::size_t at = 0; at < slabs_.size(); ++at) {
    std::vector<std::uint16_t> global;
    for (const BoneMaterial& material : materials[at]) global.push_back(palette.index(material));
    Slab& slab = slabs_[at];
    for (std::size_t voxel = 0; voxel < slab.material.size(); ++voxel)
      if (slab.occupancy[voxel] > 0) slab.material[voxel] = global[slab.material[voxel]];
  }
  palette_ = palette.materials();
  initial_units_ = remaining_units();
  if (initial_units_ == 0)
    throw InvalidInput(Fault{"stock",
                             fmt::format("{} x {} x {} voxels of {:.4g} mm", shape.size[0],
                                         shape.size[1], shape.size[2], spacing() / units::mm),
                             "must contain bone, 0 voxels do",
                             "check the threshold, the region and the units"});
}

std::size_t Stock::stored_voxels() const {
  std::size_t stored = 0;
  for (const Slab& slab : slabs_) stored += slab.occupancy.size() - kTileVoxels;
  return stored;
}

double Stock::occupancy(int x, int y, int z) const {
  if (!shape_.contains(x, y, z)) return 0.0;
  const Slab& of = slab(z);
  return static_cast<double>(of.occupancy[place(of, x, y, z)]) / kFull;
}

BoneMaterial Stock::material(int x, int y, int z) const {
  if (occupancy(x, y, z) == 0.0) return {};
  const Slab& of = slab(z);
  return palette_[of.material[place(of, x, y, z)]];
}

std::int64_t Stock::remaining_units() const {
  return std::accumulate(layer_units_.begin(), layer_units_.end(), std::int64_t{0});
}

double Stock::initial_volume() const { return static_cast<double>(initial_units_) * unit_volume(); }

double Stock::remaining_volume() const {
  return static_cast<double>(remaining_units()) * unit_volume();
}

double Stock::remaining_mass() const {
  std::vector<std::int64_t> units(palette_.size(), 0);
  for (const Slab& of : slabs_)
    for (std::size_t at = 0; at < of.occupancy.size(); ++at)
      units[of.material[at]] += of.occupancy[at];
  double mass = 0.0;
  for (std::size_t m = 0; m < units.size(); ++m)
    mass += static_cast<double>(units[m]) * palette_[m].density;
  return mass * unit_volume();
}

Stock::Box Stock::bone_box() const {
  Box box;
  box.first = shape_.size;
  for (int z = 0; z < shape_.size[2]; ++z) {
    if (layer_units_[static_cast<std::size_t>(z)] == 0) continue;
    const Slab& of = slab(z);
    for (int y = 0; y < shape_.size[1]; ++y) {
      if (of.row_units[static_cast<std::size_t>(y / kTile)] == 0) continue;
      for (int x = 0; x < shape_.size[0]; ++x) {
        if (of.occupancy[place(of, x, y, z)] == 0) continue;
        box.first = {std::min(box.first[0], x), std::min(box.first[1], y),
                     std::min(box.first[2], z)};
        box.last = {std::max(box.last[0], x), std::max(box.last[1], y), z};
      }
    }
  }
  return box;
}

geometry::GridShape cubes_over(const Vector3& lower, const Vector3& upper, double spacing) {
  require_positive("stock.spacing_mm", spacing / units::mm, "mm");
  geometry::GridShape shape;
  shape.spacing = Vector3::Constant(spacing);
  shape.origin = lower + 0.5 * shape.spacing;
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = upper[axis] - lower[axis];
    require_positive("stock.size_mm", extent / units::mm, "mm");
    // A millionth of a voxel forgives the rounding of extent / spacing.
    shape.size[static_cast<std::size_t>(axis)] = static_cast<int>(require_within(
        "stock.size", std::ceil(extent / spacing - 1e-6), 1, (1 << 17) - 1, "voxels"));
  }
  return shape;
}

Stock stock_from_hounsfield(const geometry::VoxelGrid<float>& hu_W, double spacing,
                            const BoneFromCt& options) {
  require_positive("bone.density_at_threshold_kg_per_m3",
                   bone::apparent_density(options.threshold_hu, options.density), "kg/m³");
  const geometry::GridShape& ct = hu_W.shape();
  for (int size : ct.size) require_within("ct.size", size, 2, 1 << 20, "voxels");
  float highest = hu_W.values().front();
  for (float hu : hu_W.values()) highest = std::max(highest, hu);
  if (!(highest >= options.threshold_hu))
    throw InvalidInput(Fault{"stock.threshold_hu", fmt::format("{}", options.threshold_hu),
                             fmt::format("must not lie above the highest value of the CT, {} HU: 0 "
                                         "voxels are bone",
                                         highest),
                             "lower the threshold, or check that the file is a CT in Hounsfield "
                             "units and the region holds bone"});

  const double ct_spacing = ct.spacing.minCoeff();
  const double offset = 0.5 * ct_spacing;  // central differences over one voxel of the CT
  const auto bone_at = [&](const Vector3& p_W) {
    BoneSample sample;
    const double hu = geometry::sample(hu_W, p_W);
    Vector3 gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 step = offset * Vector3::Unit(axis);
      gradient[axis] = (geometry::sample(hu_W, p_W + step) - geometry::sample(hu_W, p_W - step)) /
                       (2.0 * offset);
    }
    const double slope = gradient.norm();
    const double above = hu - options.threshold_hu;
    // Where the field is flat the point is far from the surface on the side its value says.
    const double far = 10.0 * spacing;
    sample.signed_distance =
        slope * far > std::abs(above) ? -above / slope : std::copysign(far, -above);
    if (sample.signed_distance > spacing) return sample;
    double inner_hu = std::max(hu, options.threshold_hu);
    if (slope > 0.0 && -sample.signed_distance < ct_spacing)
      inner_hu = std::max(inner_hu, geometry::sample(hu_W, p_W + gradient * (ct_spacing / slope)));
    sample.material.density = std::round(bone::apparent_density(inner_hu, options.density));
    sample.material.force_scale = bone::force_scale(sample.material.density, options.force);
    return sample;
  };
  return Stock(cubes_over(ct.lower_corner(), ct.upper_corner(), spacing), bone_at);
}

}  // namespace osteomill::workpiece
