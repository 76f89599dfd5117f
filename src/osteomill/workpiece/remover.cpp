// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/remover.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

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

void add_three(float* at, const std::array<float, 3>& shares, float amount) {
  at[-1] += shares[0] * amount;
  at[0] += shares[1] * amount;
  at[1] += shares[2] * amount;
}

// What a layer's removal leaves in the map. Between start_run and finish_run `next` is told the
// amount of one voxel after the other.

/// Bone that leaves no trace: what was inside the cutter before the step.
struct NoMap {
  void start_layer(int) {}
  void start_run(int, int) {}
  void next(float) {}
  void finish_run() {}
};

/// A level feed: eta is constant in a layer, the lateral coordinate is linear in x.
class LevelMap {
 public:
  LevelMap(ShadowMap& map, const Vector3& tip)
      : map_(map),
        tip_(tip),
        rate_(VoxelShadow::fixed(map.y_T().x())),
        along_x_(std::abs(map.y_T().x()) < 1e-12) {}

  void start_layer(int z) {
    const double eta = map_.eta_cell(Vector3(0.0, 0.0, z - tip_.z()));
    // A millionth of a cell is rounding: the layer lies on the row.
    const int row = static_cast<int>(std::floor(eta + 1e-6));
    const double above = eta - row;
    const bool shared = above > 2e-6;
    upper_share_ = shared ? static_cast<float>(above) * map_.gain() : 0.0f;
    lower_share_ = map_.gain() - upper_share_;
    cells_ = row >= 0 && row < map_.rows() ? map_.row(row) : nullptr;
    upper_cells_ = shared && row + 1 >= 0 && row + 1 < map_.rows() ? map_.row(row + 1) : nullptr;
    if (cells_) map_.note_row(row);
    if (upper_cells_) map_.note_row(row + 1);
  }
  void start_run(int y, int x) {
    lateral_ = VoxelShadow::fixed(map_.lateral_cell(Vector3(x, y, 0.0) - tip_));
    sum_ = 0.0f;
  }
  void next(float amount) {
    if (along_x_) {
      sum_ += amount;
    } else {
      share(amount);
      lateral_ += rate_;
    }
  }
  void finish_run() {
    if (along_x_ && sum_ > 0.0f) share(sum_);
  }

 private:
  void share(float amount) {
    int column = 0;
    const auto& shares = map_.lateral_shadow().shares(lateral_, column);
    if (cells_) add_three(cells_ + column, shares, lower_share_ * amount);
    if (upper_cells_) add_three(upper_cells_ + column, shares, upper_share_ * amount);
  }

  ShadowMap& map_;
  Vector3 tip_;
  std::int64_t rate_ = 0, lateral_ = 0;
  bool along_x_ = false;
  float* cells_ = nullptr;
  float* upper_cells_ = nullptr;
  float lower_share_ = 1.0f, upper_share_ = 0.0f, sum_ = 0.0f;
};

/// Any feed: both coordinates are linear in x.
class TiltedMap {
 public:
  TiltedMap(ShadowMap& map, const Vector3& tip)
      : map_(map),
        tip_(tip),
        lateral_rate_(VoxelShadow::fixed(map.y_T().x())),
        eta_rate_(VoxelShadow::fixed(map.eta().x())) {}

  void start_layer(int z) { z_ = z; }
  void start_run(int y, int x) {
    const Vector3 start = Vector3(x, y, z_) - tip_;
    lateral_ = VoxelShadow::fixed(map_.lateral_cell(start));
    eta_ = VoxelShadow::fixed(map_.eta_cell(start));
  }
  void next(float amount) {
    if (amount > 0.0f) share(amount * map_.gain());
    lateral_ += lateral_rate_;
    eta_ += eta_rate_;
  }
  void finish_run() {}

 private:
  void share(float amount) {
    int column = 0, at = 0;
    const auto& across = map_.lateral_shadow().shares(lateral_, column);
    const auto& up = map_.eta_shadow().shares(eta_, at);
    if (at < 1 || at + 1 >= map_.rows()) return;  // above the cutting length
    for (int k = 0; k < 3; ++k)
      add_three(map_.row(at + k - 1) + column, across, up[static_cast<std::size_t>(k)] * amount);
    map_.note_row(at - 1);
    map_.note_row(at + 1);
  }

  ShadowMap& map_;
  Vector3 tip_;
  std::int64_t lateral_rate_ = 0, lateral_ = 0, eta_rate_ = 0, eta_ = 0;
  int z_ = 0;
};

}  // namespace

Remover::Remover(Stock& stock, const cutting::Cutter& cutter, const RemoverOptions& options)
    : stock_(stock),
      meridian_(checked(cutter, stock.shape()), 1.0 / stock.spacing()),
      swath_(meridian_, stock.shape()),
      pose_swath_(meridian_, stock.shape()),
      map_(cutter, stock.spacing(),
           options.patches.slices > 0 ? options.patches : patches_for(cutter, stock.spacing()),
           options.memory) {}

template <bool one_material, class Source, class Map>
void Remover::carve_layer(const Source& source, int z, Map& map, Totals& totals) {
  const std::size_t layer = stock_.row_index(0, z);
  const BoneMaterial* palette = stock_.palette_.data();
  map.start_layer(z);
  std::int64_t layer_units = 0;
  const std::span<const Swath::Run> runs = source.runs();
  for (std::size_t at = 0; at < runs.size(); ++at) {
    const Swath::Run& run = runs[at];
    if (at + 4 < runs.size()) {
      // Rows are short and far apart in memory: fetch ahead.
      const Swath::Run& soon = runs[at + 4];
      const Stock::Row& ahead = stock_.rows_[layer + static_cast<std::size_t>(soon.y)];
      const int offset = std::clamp(soon.first - ahead.first, 0, ahead.length);
      __builtin_prefetch(stock_.occupancy_.data() + ahead.start + static_cast<std::size_t>(offset),
                         1);
    }
    const std::size_t row_at = layer + static_cast<std::size_t>(run.y);
    if (stock_.row_units_[row_at] == 0) continue;
    const Stock::Row& row = stock_.rows_[row_at];
    const int first = std::max(run.first, row.first);
    const int last = std::min(run.last, row.first + row.length - 1);
    if (first > last) continue;
    const std::size_t begin = row.start + static_cast<std::size_t>(first - row.first);
    Stock::Occupancy* occupancy = stock_.occupancy_.data() + begin;
    const std::uint16_t* material = stock_.material_.data() + begin;
    const Stock::Occupancy* fresh =
        source.fresh() + run.fresh + static_cast<std::size_t>(first - run.first);
    const int count = last - first + 1;
    std::uint32_t units = 0;
    map.start_run(run.y, first);
    for (int x = 0; x < count; ++x) {
      // Without a branch while there is nothing to look up: old and new are mixed at the rim.
      const int taken = std::max(0, occupancy[x] - fresh[x]);
      occupancy[x] = std::min(occupancy[x], fresh[x]);
      units += static_cast<std::uint32_t>(taken);
      if constexpr (one_material) {
        map.next(static_cast<float>(taken));
      } else {
        const BoneMaterial& bone = palette[material[x]];
        const double scaled = taken * bone.force_scale;
        totals.unit_density += taken * bone.density;
        totals.unit_scale += scaled;
        map.next(static_cast<float>(scaled));
      }
    }
    map.finish_run();
    stock_.row_units_[row_at] -= units;
    layer_units += units;
  }
  stock_.layer_units_[static_cast<std::size_t>(z)] -= layer_units;
  totals.units += layer_units;
}

template <class Source, class Map>
void Remover::carve(Source& source, Map&& map, Totals& totals) {
  const geometry::GridShape& shape = stock_.shape_;
  const bool one_material = stock_.palette_.size() == 1;
  const auto rows = static_cast<std::size_t>(shape.size[1]);
  for (int z = source.first_layer(); z < shape.size[2] && source.reaches(z); ++z) {
    if (stock_.layer_units_[static_cast<std::size_t>(z)] == 0) continue;
    source.list(z, {stock_.row_units_.data() + stock_.row_index(0, z), rows});
    if (one_material)
      carve_layer<true>(source, z, map, totals);
    else
      carve_layer<false>(source, z, map, totals);
  }
  if (one_material) {
    totals.unit_density = static_cast<double>(totals.units) * stock_.palette_[0].density;
    totals.unit_scale = static_cast<double>(totals.units) * stock_.palette_[0].force_scale;
  }
}

Eigen::Matrix3d Remover::R_WT() const {
  Eigen::Matrix3d axes;
  axes << map_.x_T(), map_.y_T(), map_.z_T();
  return axes;
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
  const double length = (to.tip_W - from.tip_W).norm();
  const double turn = angle_between(from.axis_W, to.axis_W);
  if (length == 0.0) {
    if (turn == 0.0) return;
    pose_swath_.begin_step(from, to);
    carve(pose_swath_, NoMap{}, buried);
    return;
  }
  ShadowMap::Step step;
  step.feed = (to.tip_W - from.tip_W) / length;
  step.tip = from.tip_W;
  step.axis = from.axis_W;
  step.turn = Vector3::Zero();
  if (turn > kLeastTurn * length) {
    step.axis = turned(from.axis_W, to.axis_W, 0.5);
    step.turn = from.axis_W.cross(to.axis_W).normalized() * (turn / length);
  }
  step.length = length;
  // With one material the map is filled in units, otherwise in units × force scale.
  const double scale = stock_.palette_.size() == 1 ? stock_.palette_[0].force_scale : 1.0;
  step.unit = scale / Stock::kFull;
  map_.begin_step(step);
  if (!is_upright(from.axis_W) || !is_upright(to.axis_W)) {
    pose_swath_.begin_step(from, to);
    carve(pose_swath_, TiltedMap(map_, from.tip_W), cut);
    return;
  }
  swath_.begin_step(from.tip_W, to.tip_W);
  if (to.tip_W.z() == from.tip_W.z())
    carve(swath_, LevelMap(map_, from.tip_W), cut);
  else
    carve(swath_, TiltedMap(map_, from.tip_W), cut);
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
