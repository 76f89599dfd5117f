// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/remover.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/lanes.hpp"

namespace osteomill::workpiece {

// Everything below is in voxel coordinates: voxel (x, y, z) has its centre at (x, y, z).

namespace {

// Far below a unit of occupancy, far above rounding: the end of one step is the start of the next,
// and a move is level or vertical.
constexpr double kSamePlace = 1e-6;
constexpr double kLevel = 1e-9;
// rad a voxel: a turn that moves the far end of a thousand voxels by a thousandth of the way.
constexpr double kLeastTurn = 1e-6;
constexpr double kLeastRadius = 2.0;  // of a cutter: below, occupancy can't tell its shape

const cutting::Cutter& checked(const cutting::Cutter& cutter, const geometry::GridShape& shape) {
  cutting::check(cutter);
  const double spacing = shape.spacing.x();
  const double widest = spacing * std::max(shape.size[0], shape.size[1]);
  const std::string diameter = fmt::format("{:.4g} mm", 2.0 * cutter.radius / units::mm);
  if (2.0 * cutter.radius > widest)
    throw InvalidInput(
        Fault{"cutter.diameter_mm", diameter,
              fmt::format("must not be larger than the region of the stock, {:.4g} x {:.4g} mm",
                          spacing * shape.size[0] / units::mm, spacing * shape.size[1] / units::mm),
              "use a larger region or a smaller cutter"});
  if (cutter.radius < kLeastRadius * spacing)
    throw InvalidInput(
        Fault{"cutter.diameter_mm", diameter,
              fmt::format("must be at least {} voxels, {:.4g} mm", 2.0 * kLeastRadius,
                          2.0 * kLeastRadius * spacing / units::mm),
              "use smaller voxels"});
  return cutter;
}

bool is_upright(const Vector3& axis) { return axis == Vector3::UnitZ(); }

/// What a layer gave.
struct Gathered {
  std::span<const Swath::Run> runs;
  kernel::Amounts amounts;
  bool alike;  ///< all as in the last layer
};

// What the layers leave in the map.

/// Bone that leaves no trace: what was inside the cutter before the step.
struct NoMap {
  void add(int, const Gathered&) {}
};

/// A level feed: eta is constant in a layer, the lateral coordinate is linear in x. The layer's
/// voxels are gathered in one line of cells, which goes to the map once: layers that are alike
/// share it.
class LevelMap {
 public:
  LevelMap(ShadowMap& map, const Vector3& middle, FourShadows& four_shadows,
           std::vector<float>& line)
      : map_(map), middle_(middle) {
    const auto length = static_cast<std::size_t>(map.stride());
    line.resize(4 * length);
    const Vector3& across = map.y_T();
    const VoxelShadow& shadow = map.lateral_shadow();
    const bool along_x = std::abs(across.x()) < 1e-12;
    if (!along_x) four_shadows.prepare(shadow, VoxelShadow::fixed(across.x()));
    line_ = {map.lateral_cell(-middle),
             across.x(),
             across.y(),
             VoxelShadow::kPhaseBits,
             shadow.table(),
             VoxelShadow::kStride,
             four_shadows.table(),
             four_shadows.first_cell(),
             along_x,
             length,
             line.data()};
  }

  void add(int z, const Gathered& layer) {
    const double eta = map_.eta_cell(Vector3(0.0, 0.0, z - middle_.z()));
    // A millionth of a cell is rounding: the layer lies on the row.
    const int row = static_cast<int>(std::floor(eta + 1e-6));
    const double above = eta - row;
    const bool shared = above > 2e-6;
    const bool has_lower = row >= 0 && row < map_.rows();
    const bool has_upper = shared && row + 1 >= 0 && row + 1 < map_.rows();
    if (!has_lower && !has_upper) {
      gathered_ = false;
      return;
    }
    if (!layer.alike || !gathered_)
      any_ = kernel::best().share(line_, layer.runs.data(), layer.runs.size(), layer.amounts);
    gathered_ = true;
    if (!any_) return;
    const float upper_share = shared ? static_cast<float>(above) * map_.gain() : 0.0f;
    if (has_lower) add_line(row, map_.gain() - upper_share);
    if (has_upper) add_line(row + 1, upper_share);
  }

 private:
  void add_line(int row, float share) {
    float* cells = map_.row(row);
    const float* line = line_.cells;
    for (int column = 0; column < map_.stride(); column += kFour)
      store(load<FourFloats>(cells + column) + share * load<FourFloats>(line + column),
            cells + column);
    map_.note_row(row);
  }

  ShadowMap& map_;
  Vector3 middle_;
  kernel::Line line_{};
  bool gathered_ = false, any_ = false;  ///< line_ holds a layer, which took something
};

/// Any feed: both coordinates are linear in x.
class TiltedMap {
 public:
  TiltedMap(ShadowMap& map, const Vector3& middle, FourShadows& lateral, FourShadows& eta)
      : map_(map), middle_(middle) {
    const Vector3* const axes[] = {&map.y_T(), &map.eta()};
    FourShadows* const shadows[] = {&lateral, &eta};
    lateral.prepare(map.lateral_shadow(), VoxelShadow::fixed(map.y_T().x()));
    eta.prepare(map.eta_shadow(), VoxelShadow::fixed(map.eta().x()));
    for (int i = 0; i < 2; ++i) {
      plane_.x_rate[i] = axes[i]->x();
      plane_.y_rate[i] = axes[i]->y();
      plane_.four_shares[i] = shadows[i]->table();
      plane_.first_cell[i] = shadows[i]->first_cell();
    }
    plane_.phase_bits = VoxelShadow::kPhaseBits;
    plane_.gain = map.gain();
    plane_.rows = map.rows();
    plane_.stride = map.stride();
    plane_.cells = map.row(0);
  }

  void add(int z, const Gathered& layer) {
    const Vector3 start = Vector3(0.0, 0.0, z) - middle_;
    plane_.origin[0] = map_.lateral_cell(start);
    plane_.origin[1] = map_.eta_cell(start);
    const kernel::RowRange rows =
        kernel::best().share_plane(plane_, layer.runs.data(), layer.runs.size(), layer.amounts);
    if (rows.first > rows.last) return;
    map_.note_row(rows.first);
    map_.note_row(rows.last);
  }

 private:
  ShadowMap& map_;
  Vector3 middle_;
  kernel::Plane plane_{};
};

}  // namespace

Remover::Remover(Stock& stock, const cutting::Cutter& cutter, const RemoverOptions& options)
    : stock_(stock),
      meridian_(checked(cutter, stock.shape()), 1.0 / stock.spacing()),
      swath_(meridian_, stock.shape()),
      pose_swath_(meridian_, stock.shape()),
      map_(cutter, stock.spacing(),
           options.patches.slices > 0 ? options.patches : patches_for(cutter, stock.spacing()),
           options.memory) {
  for (const BoneMaterial& material : stock.palette_) {
    densities_.push_back(material.density);
    force_scales_.push_back(material.force_scale);
  }
}

/// Returns whether all was as in the last layer, if that had the same list: otherwise it's `new`.
template <class Source>
bool Remover::take_layer(const Source& source, int z, bool is_new, Totals& totals) {
  Stock::Slab& slab = stock_.slabs_[static_cast<std::size_t>(z / Stock::kTile)];
  const std::span<const Swath::Run> runs = source.runs();
  if (voxel_amounts_.size() < source.fresh_size()) voxel_amounts_.resize(2 * source.fresh_size());
  if (run_units_.size() < runs.size()) {
    run_units_.resize(2 * runs.size());
    run_amounts_.resize(2 * runs.size());
  }
  const kernel::Layer layer{slab.tiles.data(),
                            stock_.tiles_along_x_,
                            static_cast<std::size_t>(z % Stock::kTile * Stock::kTileLayer),
                            slab.occupancy.data(),
                            slab.material.data(),
                            slab.row_units.data(),
                            densities_.data(),
                            force_scales_.data(),
                            densities_.size() == 1};
  const kernel::Taken taken =
      kernel::best().take(layer, runs.data(), runs.size(), source.fresh(), !is_new, amounts());
  stock_.layer_units_[static_cast<std::size_t>(z)] -= taken.units;
  totals.units += taken.units;
  totals.unit_density += taken.unit_density;
  totals.unit_scale += taken.unit_scale;
  return taken.alike;
}

template <class Source, class Map>
void Remover::carve(Source& source, Map&& map, Totals& totals) {
  for (int z = source.first_layer(); z < stock_.shape_.size[2] && source.reaches(z); ++z) {
    if (stock_.layer_units_[static_cast<std::size_t>(z)] == 0) continue;
    const bool is_new = source.list(z, stock_.slab(z).row_units);
    const bool alike = take_layer(source, z, is_new, totals);
    map.add(z, {source.runs(), amounts(), alike});
  }
}

Eigen::Matrix3d Remover::R_WT() const {
  Eigen::Matrix3d axes;
  axes << map_.x_T(), map_.y_T(), map_.z_T();
  return axes;
}

Remover::Motion Remover::motion() const {
  return {middle_share_, std::asin(std::clamp(map_.feed().dot(map_.z_T()), -1.0, 1.0)),
          map_.turn_T() / stock_.spacing(), map_.middle_height() * stock_.spacing()};
}

Remover::Totals Remover::place(const ToolPose& pose) {
  Totals buried;
  if (is_upright(pose.axis_W)) {
    swath_.begin_placing(pose.tip_W);
    carve(swath_, NoMap{}, buried);
  } else {
    pose_swath_.begin_placing(pose);
    carve(pose_swath_, NoMap{}, buried);
  }
  map_.clear();
  pose_ = pose;
  placed_ = true;
  return buried;
}

void Remover::move(const ToolPose& from, const ToolPose& to, Totals& cut, Totals& buried) {
  const Vector3 way = to.tip_W - from.tip_W + map_.middle_height() * (to.axis_W - from.axis_W);
  const double length = way.norm();
  const double turn = angle_between(from.axis_W, to.axis_W);
  if (length == 0.0 || (turn > 0.0 && length < kSamePlace)) {
    if (turn == 0.0) return;
    pose_swath_.begin_step(from, to);
    carve(pose_swath_, NoMap{}, buried);
    return;
  }
  ShadowMap::Step step;
  step.feed = way / length;
  step.middle = from.tip_W + map_.middle_height() * from.axis_W;
  step.axis = from.axis_W;
  step.turn = Vector3::Zero();
  if (turn > kLeastTurn * length) {
    step.axis = turned(from.axis_W, to.axis_W, 0.5);
    step.turn = from.axis_W.cross(to.axis_W).normalized() * (turn / length);
  }
  step.length = length;
  const double tip_way = (to.tip_W - from.tip_W).norm();
  middle_share_ = tip_way > 0.0 ? length / tip_way : 0.0;
  // With one material the map is filled in units, otherwise in units × force scale.
  const double scale = stock_.palette_.size() == 1 ? stock_.palette_[0].force_scale : 1.0;
  step.unit = scale / Stock::kFull;
  map_.begin_step(step);
  if (!is_upright(from.axis_W) || !is_upright(to.axis_W)) {
    pose_swath_.begin_step(from, to);
    carve(pose_swath_, TiltedMap(map_, step.middle, four_shadows_, four_eta_shadows_), cut);
    return;
  }
  swath_.begin_step(from.tip_W, to.tip_W);
  if (to.tip_W.z() == from.tip_W.z())
    carve(swath_, LevelMap(map_, step.middle, four_shadows_, line_), cut);
  else
    carve(swath_, TiltedMap(map_, step.middle, four_shadows_, four_eta_shadows_), cut);
}

Removal Remover::step(const ToolPose& from_W, const ToolPose& to_W) {
  const auto to_voxels = [&](const ToolPose& pose) -> ToolPose {
    return {(pose.tip_W - stock_.shape_.origin) / stock_.spacing(), pose.axis_W};
  };
  const ToolPose from = to_voxels(from_W);
  Totals cut, buried;
  if (!placed_ || (from.tip_W - pose_.tip_W).norm() > kSamePlace ||
      angle_between(from.axis_W, pose_.axis_W) > kSamePlace)
    buried = place(from);
  ToolPose to = to_voxels(to_W);
  if (is_upright(to.axis_W)) {
    if (std::abs(to.tip_W.z() - pose_.tip_W.z()) < kLevel) to.tip_W.z() = pose_.tip_W.z();
    if (std::hypot(to.tip_W.x() - pose_.tip_W.x(), to.tip_W.y() - pose_.tip_W.y()) < kLevel)
      to.tip_W.head<2>() = pose_.tip_W.head<2>();
  }
  const ToolPose start = pose_;
  const bool straight = is_upright(start.axis_W) && is_upright(to.axis_W);
  const int pieces = straight ? 1 : pose_swath_.pieces(start, to);
  for (int k = 1; k <= pieces; ++k) {
    const ToolPose next = k == pieces ? to : between(start, to, static_cast<double>(k) / pieces);
    move(pose_, next, cut, buried);
    pose_ = next;
  }
  Removal removal;
  removal.volume = static_cast<double>(cut.units) * stock_.unit_volume();
  removal.buried_volume = static_cast<double>(buried.units) * stock_.unit_volume();
  removal.mass = cut.unit_density * stock_.unit_volume();
  removal.scaled_volume = cut.unit_scale * stock_.unit_volume();
  return removal;
}

}  // namespace osteomill::workpiece
