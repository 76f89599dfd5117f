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

/// One z-layer while it is built.
struct Layer {
  struct Span {
    int first = 0, length = 0;
    std::uint32_t units = 0;
  };
  std::vector<Span> spans;  // one a y
  std::vector<Stock::Occupancy> occupancy;
  std::vector<std::uint16_t> material;
  Palette palette;
};

Layer build_layer(const geometry::GridShape& shape, int z,
                  const std::function<BoneSample(const Vector3&)>& bone) {
  Layer layer;
  layer.spans.resize(static_cast<std::size_t>(shape.size[1]));
  const double per_metre = 1.0 / shape.spacing.x();
  std::vector<Stock::Occupancy> occupancy(static_cast<std::size_t>(shape.size[0]));
  std::vector<std::uint16_t> material(occupancy.size());
  for (int y = 0; y < shape.size[1]; ++y) {
    int first = shape.size[0], last = -1;
    std::uint32_t units = 0;
    for (int x = 0; x < shape.size[0]; ++x) {
      const std::size_t at = static_cast<std::size_t>(x);
      const BoneSample sample = bone(shape.centre(x, y, z));
      const double share = std::clamp(0.5 - sample.signed_distance * per_metre, 0.0, 1.0);
      occupancy[at] = static_cast<Stock::Occupancy>(std::lround(share * Stock::kFull));
      material[at] = 0;
      if (occupancy[at] == 0) continue;
      material[at] = layer.palette.index(sample.material);
      units += occupancy[at];
      first = std::min(first, x);
      last = x;
    }
    if (last < first) continue;
    layer.spans[static_cast<std::size_t>(y)] = {first, last - first + 1, units};
    layer.occupancy.insert(layer.occupancy.end(), occupancy.begin() + first,
                           occupancy.begin() + last + 1);
    layer.material.insert(layer.material.end(), material.begin() + first,
                          material.begin() + last + 1);
  }
  return layer;
}

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
    // A row's bone is counted in 32 bits.
    require_within("stock.size", size, 1, (1 << 17) - 1, "voxels");
}

}  // namespace

Stock::Stock(const geometry::GridShape& shape,
             const std::function<BoneSample(const Vector3& p_W)>& bone)
    : shape_(shape) {
  check(shape);
  const std::size_t layers = static_cast<std::size_t>(shape.size[2]);
  std::vector<Layer> built(layers);
  tbb::parallel_for(std::size_t{0}, layers, [&](std::size_t z) {
    built[z] = build_layer(shape, static_cast<int>(z), bone);
  });

  // In the order of the layers: the palette does not depend on the threads.
  std::size_t stored = 0;
  for (const Layer& layer : built) stored += layer.occupancy.size();
  occupancy_.reserve(stored);
  material_.reserve(stored);
  rows_.reserve(layers * static_cast<std::size_t>(shape.size[1]));
  row_units_.reserve(rows_.capacity());
  layer_units_.resize(layers, 0);
  Palette palette;
  for (std::size_t z = 0; z < layers; ++z) {
    Layer& layer = built[z];
    std::size_t start = occupancy_.size();
    for (const Layer::Span& span : layer.spans) {
      rows_.push_back({start, span.first, span.length});
      row_units_.push_back(span.units);
      start += static_cast<std::size_t>(span.length);
      layer_units_[z] += span.units;
    }
    occupancy_.insert(occupancy_.end(), layer.occupancy.begin(), layer.occupancy.end());
    std::vector<std::uint16_t> global;
    for (const BoneMaterial& material : layer.palette.materials())
      global.push_back(palette.index(material));
    for (std::size_t at = 0; at < layer.material.size(); ++at)
      material_.push_back(layer.occupancy[at] == 0 ? std::uint16_t{0} : global[layer.material[at]]);
    layer = Layer{};
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

double Stock::occupancy(int x, int y, int z) const {
  if (!shape_.contains(x, y, z)) return 0.0;
  const Row& at = row(y, z);
  if (x < at.first || x >= at.first + at.length) return 0.0;
  return static_cast<double>(occupancy_[at.start + static_cast<std::size_t>(x - at.first)]) / kFull;
}

BoneMaterial Stock::material(int x, int y, int z) const {
  if (occupancy(x, y, z) == 0.0) return {};
  const Row& at = row(y, z);
  return palette_[material_[at.start + static_cast<std::size_t>(x - at.first)]];
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
  for (std::size_t at = 0; at < occupancy_.size(); ++at) units[material_[at]] += occupancy_[at];
  double mass = 0.0;
  for (std::size_t m = 0; m < units.size(); ++m)
    mass += static_cast<double>(units[m]) * palette_[m].density;
  return mass * unit_volume();
}

Stock::Box Stock::bone_box() const {
  Box box;
  box.first = shape_.size;
  for (int z = 0; z < shape_.size[2]; ++z)
    for (int y = 0; y < shape_.size[1]; ++y) {
      const Row& at = row(y, z);
      if (row_units_[row_index(y, z)] == 0) continue;
      const auto begin = occupancy_.begin() + static_cast<std::ptrdiff_t>(at.start);
      const auto has_bone = [](Occupancy occupancy) { return occupancy > 0; };
      const auto first = std::find_if(begin, begin + at.length, has_bone);
      auto last = begin + at.length - 1;
      while (*last == 0) --last;
      box.first = {std::min(box.first[0], at.first + static_cast<int>(first - begin)),
                   std::min(box.first[1], y), std::min(box.first[2], z)};
      box.last = {std::max(box.last[0], at.first + static_cast<int>(last - begin)),
                  std::max(box.last[1], y), z};
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
