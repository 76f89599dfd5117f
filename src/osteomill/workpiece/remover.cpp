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

void add_three(float* at, const float* shares, float amount) {
  at[-1] += shares[0] * amount;
  at[0] += shares[1] * amount;
  at[1] += shares[2] * amount;
}

/// What a layer gave: amounts of the voxels of each run, beside their fresh occupancies.
struct Gathered {
  std::span<const Swath::Run> runs;
  const std::uint32_t* units;  ///< of each run; without any it has no amounts
  const float* amounts;
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
  LevelMap(ShadowMap& map, const Vector3& tip, std::vector<float>& line)
      : map_(map),
        tip_(tip),
        line_(line),
        rate_(VoxelShadow::fixed(map.y_T().x())),
        along_x_(std::abs(map.y_T().x()) < 1e-12) {
    line_.assign(static_cast<std::size_t>(kBefore + map.stride()), 0.0f);
  }

  void add(int z, const Gathered& layer) {
    const double eta = map_.eta_cell(Vector3(0.0, 0.0, z - tip_.z()));
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
    if (!layer.alike || !gathered_) gather(layer);
    if (!any_) return;
    const float upper_share = shared ? static_cast<float>(above) * map_.gain() : 0.0f;
    if (has_lower) add_line(row, map_.gain() - upper_share);
    if (has_upper) add_line(row + 1, upper_share);
  }

 private:
  /// Cells before the first of the map: whole lanes may begin there, with nothing in it.
  static constexpr int kBefore = kFour;

  void gather(const Gathered& layer) {
    std::fill(line_.begin(), line_.end(), 0.0f);
    any_ = false;
    gathered_ = true;
    for (std::size_t at = 0; at < layer.runs.size(); ++at) {
      if (layer.units[at] == 0) continue;
      any_ = true;
      const Swath::Run& run = layer.runs[at];
      const std::int64_t lateral =
          VoxelShadow::fixed(map_.lateral_cell(Vector3(run.start(), run.y, 0.0) - tip_));
      const float* amounts = layer.amounts + run.fresh;
      if (along_x_)
        share_sum(lateral, amounts, run.lanes());
      else
        share_each(lateral, amounts, run.lanes());
    }
  }
  void share_sum(std::int64_t lateral, const float* amounts, int length) {
    FourFloats sum = {};
    for (int k = 0; k < length; k += kFour) sum += load<FourFloats>(amounts + k);
    int column = 0;
    const float* shares = map_.lateral_shadow().shares(lateral, column);
    add_three(line_.data() + kBefore + column, shares, sum_of(sum));
  }
  /// Four voxels reach no more than eight cells, whose sums stay in registers.
  void share_each(std::int64_t lateral, const float* amounts, int length) {
    const VoxelShadow& shadow = map_.lateral_shadow();
    for (int k = 0; k < length; k += kFour, lateral += kFour * rate_) {
      const FourFloats four = load<FourFloats>(amounts + k);
      if (all_zero(four)) continue;
      int lowest = 0;
      shadow.shares(rate_ < 0 ? lateral + (kFour - 1) * rate_ : lateral, lowest);
      FourFloats low = {}, high = {};
      for (int i = 0; i < kFour; ++i) {
        int column = 0;
        const float* shares = shadow.shares(lateral + i * rate_, column) - (column - lowest);
        low += four[i] * load<FourFloats>(shares);
        high += four[i] * load<FourFloats>(shares + kFour);
      }
      float* cells = line_.data() + kBefore + lowest - 1;
      store(load<FourFloats>(cells) + low, cells);
      store(load<FourFloats>(cells + kFour) + high, cells + kFour);
    }
  }
  void add_line(int row, float share) {
    float* cells = map_.row(row);
    const float* line = line_.data() + kBefore;
    for (int column = 0; column < map_.stride(); column += kFour)
      store(load<FourFloats>(cells + column) + share * load<FourFloats>(line + column),
            cells + column);
    map_.note_row(row);
  }

  ShadowMap& map_;
  Vector3 tip_;
  std::vector<float>& line_;
  std::int64_t rate_ = 0;
  bool along_x_ = false;
  bool gathered_ = false, any_ = false;  ///< line_ holds a layer, which took something
};

/// Any feed: both coordinates are linear in x.
class TiltedMap {
 public:
  TiltedMap(ShadowMap& map, const Vector3& tip)
      : map_(map),
        tip_(tip),
        lateral_rate_(VoxelShadow::fixed(map.y_T().x())),
        eta_rate_(VoxelShadow::fixed(map.eta().x())) {}

  void add(int z, const Gathered& layer) {
    for (std::size_t at = 0; at < layer.runs.size(); ++at) {
      if (layer.units[at] == 0) continue;
      const Swath::Run& run = layer.runs[at];
      const Vector3 start = Vector3(run.start(), run.y, z) - tip_;
      std::int64_t lateral = VoxelShadow::fixed(map_.lateral_cell(start));
      std::int64_t eta = VoxelShadow::fixed(map_.eta_cell(start));
      const float* amounts = layer.amounts + run.fresh;
      for (int k = 0; k < run.lanes(); ++k) {
        if (amounts[k] > 0.0f) share(lateral, eta, amounts[k] * map_.gain());
        lateral += lateral_rate_;
        eta += eta_rate_;
      }
    }
  }

 private:
  void share(std::int64_t lateral, std::int64_t eta, float amount) {
    int column = 0, at = 0;
    const float* across = map_.lateral_shadow().shares(lateral, column);
    const float* up = map_.eta_shadow().shares(eta, at);
    if (at < 1 || at + 1 >= map_.rows()) return;  // above the cutting length
    for (int k = 0; k < 3; ++k) add_three(map_.row(at + k - 1) + column, across, up[k] * amount);
    map_.note_row(at - 1);
    map_.note_row(at + 1);
  }

  ShadowMap& map_;
  Vector3 tip_;
  std::int64_t lateral_rate_ = 0, eta_rate_ = 0;
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

/// Takes what a run says; returns the units. `alike` stays where the amounts are those that were
/// there before.
template <bool one_material>
std::uint32_t Remover::take_run(const Swath::Run& run, const Stock::Occupancy* fresh, int z,
                                Totals& totals, bool& alike) {
  Stock::Slab& slab = stock_.slabs_[static_cast<std::size_t>(z / Stock::kTile)];
  const std::uint32_t* tiles = slab.tiles.data() + (run.y / Stock::kTile) * stock_.tiles_along_x_ +
                               run.start() / Stock::kTile;
  const auto in_tile = static_cast<std::size_t>((z % Stock::kTile) * Stock::kTileLayer +
                                                run.y % Stock::kTile * Stock::kTile);
  float* amounts = amounts_.data() + run.fresh;
  fresh += run.fresh;
  FourInts units = {}, same = ~FourInts{};
  for (int k = 0; k < run.lanes(); k += kEight, ++tiles) {
    const std::size_t place = std::size_t{*tiles} * Stock::kTileVoxels + in_tile;
    Stock::Occupancy* occupancy = slab.occupancy.data() + place;
    __builtin_prefetch(occupancy + Stock::kTileLayer, 1);  // of the next layer
    const auto old = load<EightShorts>(occupancy);
    const EightShorts taken = less(old, load<EightShorts>(fresh + k));
    store(old - taken, occupancy);
    const FourInts low = first_four(taken), high = last_four(taken);
    units += low + high;
    FourFloats low_amounts = as_floats(low), high_amounts = as_floats(high);
    if constexpr (!one_material) {
      const std::uint16_t* material = slab.material.data() + place;
      for (int i = 0; i < kEight; ++i) {
        if (taken[i] == 0) continue;
        const BoneMaterial& bone = stock_.palette_[material[i]];
        const double scaled = taken[i] * bone.force_scale;
        totals.unit_density += taken[i] * bone.density;
        totals.unit_scale += scaled;
        (i < kFour ? low_amounts[i] : high_amounts[i - kFour]) = static_cast<float>(scaled);
      }
    }
    same &= (load<FourFloats>(amounts + k) == low_amounts) &
            (load<FourFloats>(amounts + k + kFour) == high_amounts);
    store(low_amounts, amounts + k);
    store(high_amounts, amounts + k + kFour);
  }
  alike = alike && (same[0] & same[1] & same[2] & same[3]) != 0;
  return static_cast<std::uint32_t>(sum_of(units));
}

/// Returns whether all was as in the last layer, if that had the same list.
template <bool one_material, class Source>
bool Remover::take_layer(const Source& source, int z, Totals& totals) {
  Stock::Slab& slab = stock_.slabs_[static_cast<std::size_t>(z / Stock::kTile)];
  const std::span<const Swath::Run> runs = source.runs();
  if (amounts_.size() < source.fresh_size()) amounts_.resize(2 * source.fresh_size());
  if (run_units_.size() < runs.size()) run_units_.resize(2 * runs.size());
  std::int64_t layer_units = 0;
  bool alike = true;
  for (std::size_t at = 0; at < runs.size(); ++at) {
    std::int64_t& row_units = slab.row_units[static_cast<std::size_t>(runs[at].y / Stock::kTile)];
    std::uint32_t units = 0;
    if (row_units > 0) units = take_run<one_material>(runs[at], source.fresh(), z, totals, alike);
    row_units -= units;
    layer_units += units;
    alike = alike && run_units_[at] == units;
    run_units_[at] = units;
  }
  stock_.layer_units_[static_cast<std::size_t>(z)] -= layer_units;
  totals.units += layer_units;
  return alike;
}

template <class Source, class Map>
void Remover::carve(Source& source, Map&& map, Totals& totals) {
  const bool one_material = stock_.palette_.size() == 1;
  for (int z = source.first_layer(); z < stock_.shape_.size[2] && source.reaches(z); ++z) {
    if (stock_.layer_units_[static_cast<std::size_t>(z)] == 0) continue;
    const bool is_new = source.list(z, stock_.slab(z).row_units);
    const bool alike =
        one_material ? take_layer<true>(source, z, totals) : take_layer<false>(source, z, totals);
    map.add(z, {source.runs(), run_units_.data(), amounts_.data(), alike && !is_new});
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
    carve(swath_, LevelMap(map_, from.tip_W, line_), cut);
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
