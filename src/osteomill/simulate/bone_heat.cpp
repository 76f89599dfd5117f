// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/bone_heat.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/thermal/thermal_dose.hpp"

namespace osteomill::simulate {

namespace {

using geometry::Vector3;
constexpr double kMostCells = 2e7;
constexpr double kBone = 0.5;                               // of a cell that is bone
constexpr double kDoseFrom = thermal::kZeroCelsius + 39.0;  // below, 1/256 of a minute a minute

/// How far up its axis a tool can meet the grid.
double shaft_length(const geometry::GridShape& shape, const Vector3& tip, const Vector3& axis,
                    double radius) {
  double length = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double side = axis[i] > 0.0 ? shape.upper_corner()[i] + radius - tip[i]
                                      : tip[i] - shape.lower_corner()[i] + radius;
    if (std::abs(axis[i]) > 1e-12) length = std::min(length, side / std::abs(axis[i]));
  }
  return std::max(0.0, length);
}

/// Cells of the temperature field: where the cutter goes, with a margin, as far as there is bone
/// and a cell of air around it.
struct Cells {
  geometry::GridShape shape;
  int factor = 1;
  std::array<int, 3> first{};
};

Cells cells_of(const workpiece::Stock& stock, const cutting::Cutter& cutter,
               const workpiece::ToolPath& path, const BoneHeatOptions& options) {
  require_positive("heat.spacing_mm", options.spacing / units::mm, "mm");
  require_non_negative("heat.margin_mm", options.margin / units::mm, "mm");
  const geometry::GridShape& voxels = stock.shape();
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const workpiece::Move& move : path.moves()) {
    if (move.kind != workpiece::MoveKind::cut) continue;
    for (std::size_t i = 0; i < move.points_W.size(); ++i) {
      const Vector3& point = move.points_W[i];
      const Vector3 axis = move.axes_W.empty() ? Vector3(Vector3::UnitZ()) : move.axes_W[i];
      const Vector3 end = point + shaft_length(voxels, point, axis, cutter.radius) * axis;
      // A disk across the axis, and the margin under it.
      const Vector3 across = (1.0 - axis.array().square()).max(0.0).sqrt();
      const Vector3 around =
          (cutter.radius + options.margin) * across + options.margin * axis.cwiseAbs();
      low = low.cwiseMin(point - around).cwiseMin(end - around);
      high = high.cwiseMax(point + around).cwiseMax(end + around);
    }
  }
  Cells cells;
  cells.factor = std::max(1, static_cast<int>(std::lround(options.spacing / stock.spacing())));
  const workpiece::Stock::Box box = stock.bone_box();
  cells.shape.spacing = cells.factor * voxels.spacing;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double origin = voxels.origin[a], h = voxels.spacing[a];
    const double first =
        std::max<double>(std::floor((low[a] - origin) / h), box.first[axis] - cells.factor);
    const double last =
        std::min<double>(std::ceil((high[a] - origin) / h), box.last[axis] + cells.factor);
    cells.first[axis] = static_cast<int>(first);
    cells.shape.size[axis] =
        std::max(1, static_cast<int>(std::ceil((last - first + 1.0) / cells.factor)));
    cells.shape.origin[a] = origin + h * (first + 0.5 * (cells.factor - 1));
  }
  const double count = static_cast<double>(cells.shape.count());
  if (count > kMostCells)
    throw InvalidInput(Fault{
        "heat.spacing_mm", fmt::format("{:g} mm: {:.2g} cells", options.spacing / units::mm, count),
        fmt::format("must make at most {:.0e} cells", kMostCells), "use a larger spacing"});
  return cells;
}

struct Content {
  double share = 0.0;    ///< of the cell that is bone
  double density = 0.0;  ///< mean of the bone in it
};

Content content_of(const workpiece::Stock& stock, const std::array<int, 3>& first, int factor,
                   int x, int y, int z) {
  double share = 0.0, mass = 0.0;
  for (int k = 0; k < factor; ++k)
    for (int j = 0; j < factor; ++j)
      for (int i = 0; i < factor; ++i) {
        const int vx = first[0] + factor * x + i, vy = first[1] + factor * y + j,
                  vz = first[2] + factor * z + k;
        const double occupancy = stock.occupancy(vx, vy, vz);
        if (occupancy == 0.0) continue;
        share += occupancy;
        mass += occupancy * stock.material(vx, vy, vz).density;
      }
  const double voxels = static_cast<double>(factor) * factor * factor;
  return {share / voxels, share > 0.0 ? mass / share : 0.0};
}

thermal::HeatField field_over(const workpiece::Stock& stock, const Cells& cells,
                              const thermal::HeatOptions& options) {
  return thermal::HeatField(
      cells.shape,
      [&](int x, int y, int z) {
        const Content content = content_of(stock, cells.first, cells.factor, x, y, z);
        return content.share >= kBone ? thermal_material(content.density)
                                      : thermal::ThermalMaterial{};
      },
      options);
}

}  // namespace

thermal::ThermalMaterial thermal_material(double density) {
  const double solid = std::clamp(density / 1900.0, 0.0, 1.0);
  const double cortical = std::clamp((density - 400.0) / 1500.0, 0.0, 1.0);
  return {0.29 + cortical * (0.55 - 0.29), density * 1300.0 + (1.0 - solid) * 2.2e6};
}

std::vector<thermal::PatchCut> patch_cuts(const cutting::EngagedForce& whole,
                                          const cutting::EngagedForce* edge,
                                          const cutting::Cutter& cutter,
                                          const cutting::Engagement& engagement,
                                          const cutting::Condition& condition, double time) {
  const auto all = whole.work(engagement, condition);
  std::vector<cutting::EngagedForce::PatchWork> rubs;
  if (edge != nullptr) rubs = edge->work(engagement, condition);
  std::vector<thermal::PatchCut> cuts(all.size());
  const double turned = condition.spindle_speed * time;
  const double step = 2.0 * std::numbers::pi / engagement.angles;
  std::size_t at = 0;
  for (int slice = 0; slice < engagement.slices; ++slice) {
    const double speed = condition.spindle_speed *
                         cutting::radius_at(cutter, (slice + 0.5) * engagement.slice_height);
    for (int angle = 0; angle < engagement.angles; ++angle, ++at) {
      if (all[at].torque == 0.0) continue;
      // h = c sin(theta): in the first quarter turn from +y the chip grows.
      const double slope = std::abs(std::cos((angle + 0.5) * step));
      cuts[at] = {all[at].torque * turned,
                  rubs.empty() ? 0.0 : rubs[at].torque * turned,
                  speed,
                  all[at].chip,
                  0.5 * step * slope * condition.feed_per_tooth,
                  4 * angle < engagement.angles};
    }
  }
  return cuts;
}

BoneHeat::BoneHeat(const workpiece::Stock& stock, const cutting::Cutter& cutter,
                   const workpiece::ToolPath& path, const BoneHeatOptions& options)
    : cutter_(cutter),
      options_(options),
      field_(field_over(stock, cells_of(stock, cutter, path, options), options.field)) {
  const Cells cells = cells_of(stock, cutter, path, options);
  factor_ = cells.factor;
  first_voxel_ = cells.first;
  peak_.assign(cells.shape.count(), static_cast<float>(options.field.initial_temperature));
  dose_.assign(cells.shape.count(), 0.0f);
  above_47_ = above_50_ = dose_;
  hottest_ = options.field.initial_temperature;
  hottest_now_ = hottest_;
}

void BoneHeat::watch(const workpiece::Stock& left) {
  const geometry::GridShape& shape = field_.shape();
  stays_.clear();
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x)
        stays_.push_back(share_of_bone(left, x, y, z) >= kBone ? 1 : 0);
}

double BoneHeat::share_of_bone(const workpiece::Stock& stock, int x, int y, int z) const {
  return content_of(stock, first_voxel_, factor_, x, y, z).share;
}

void BoneHeat::take_away(const workpiece::Stock& stock, const Vector3& tip_W,
                         const Vector3& axis_W) {
  const geometry::GridShape& shape = field_.shape();
  const double reach = cutter_.radius + shape.spacing.x();
  const Vector3 end = tip_W + shaft_length(shape, tip_W, axis_W, reach) * axis_W;
  std::array<int, 3> first{}, last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double around = reach * std::sqrt(std::max(0.0, 1.0 - axis_W[a] * axis_W[a])) +
                          shape.spacing[a] * std::abs(axis_W[a]);
    const double from = std::min(tip_W[a], end[a]) - around;
    const double to = std::max(tip_W[a], end[a]) + around;
    first[axis] = static_cast<int>(
        std::clamp((from - shape.origin[a]) / shape.spacing[a], 0.0, shape.size[axis] - 1.0));
    last[axis] = static_cast<int>(
        std::clamp((to - shape.origin[a]) / shape.spacing[a] + 1.0, 0.0, shape.size[axis] - 1.0));
  }
  const double reach_sq = (reach + shape.spacing.x()) * (reach + shape.spacing.x());
  for (int z = first[2]; z <= last[2]; ++z)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int x = first[0]; x <= last[0]; ++x) {
        const Vector3 p = shape.centre(x, y, z) - tip_W;
        const double up = axis_W.dot(p);
        if (p.squaredNorm() - up * up > reach_sq) continue;
        if (!field_.is_bone(x, y, z) || share_of_bone(stock, x, y, z) >= kBone) continue;
        field_.remove(x, y, z);
        cut_cells_.push_back({x, y, z});
      }
}

void BoneHeat::make_patches(const cutting::Engagement& engagement) {
  const double turn = 2.0 * std::numbers::pi / engagement.angles;
  for (int slice = 0; slice < engagement.slices; ++slice)
    for (int angle = 0; angle < engagement.angles; ++angle) {
      const double z = (slice + 0.5) * engagement.slice_height;
      const double theta = (angle + 0.5) * turn;
      const double r = cutting::radius_at(cutter_, z);
      const double kappa = cutting::axial_position_angle(cutter_, z);
      Patch patch;
      patch.p_T = Vector3(r * std::sin(theta), r * std::cos(theta), z);
      patch.n_T = Vector3(std::sin(kappa) * std::sin(theta), std::sin(kappa) * std::cos(theta),
                          -std::cos(kappa));
      patches_.push_back(patch);
    }
}

/// The cell that a patch heats, half a cell or so into what is left, and the part of its heat that
/// goes there: all of it where that is bone; where less than half of it is, what there is of it,
/// into the nearest cell of bone beside.
BoneHeat::Heated BoneHeat::beside(const workpiece::Stock& stock, const Vector3& patch_W,
                                  const Vector3& n_W) const {
  const geometry::GridShape& shape = field_.shape();
  const auto in_cells = [&](double depth) -> Vector3 {
    return (patch_W + depth * shape.spacing.x() * n_W - shape.origin).cwiseQuotient(shape.spacing);
  };
  const auto is_bone = [&](const Cell& c) {
    return shape.contains(c[0], c[1], c[2]) && field_.is_bone(c[0], c[1], c[2]);
  };
  const auto cell_at = [](const Vector3& p) -> Cell {
    return {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())),
            static_cast<int>(std::lround(p.z()))};
  };
  for (const double depth : {0.5, 1.0, 1.5})
    if (const Cell c = cell_at(in_cells(depth)); is_bone(c)) return {c, 1.0};
  const Vector3 p = in_cells(0.5);
  const Cell middle = cell_at(p), here = cell_at(in_cells(0.0));
  double share = 0.0;
  for (const Cell& c : {here, middle})
    if (shape.contains(c[0], c[1], c[2]))
      share = std::max(share, share_of_bone(stock, c[0], c[1], c[2]));
  if (share == 0.0) return {};
  Heated nearest;
  double least_sq = std::numeric_limits<double>::infinity();
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) {
        const Cell c{middle[0] + i, middle[1] + j, middle[2] + k};
        const double sq = (Vector3(c[0], c[1], c[2]) - p).squaredNorm();
        if (sq >= least_sq || !is_bone(c)) continue;
        nearest = {c, std::min(1.0, share / kBone)};
        least_sq = sq;
      }
  return nearest;
}

void BoneHeat::put_in(const workpiece::Stock& stock, const Vector3& tip_W,
                      const Eigen::Matrix3d& R_WT, std::span<const thermal::PatchCut> patches) {
  for (std::size_t at = 0; at < patches.size(); ++at) {
    if (!(patches[at].work > 0.0)) continue;
    const double heat = thermal::shares_of_patch(patches[at], options_.partition).bone;
    const Patch& patch = patches_[at];
    const Heated to = beside(stock, tip_W + R_WT * patch.p_T, R_WT * patch.n_T);
    if (to.part > 0.0) field_.add_heat(to.cell[0], to.cell[1], to.cell[2], to.part * heat);
    unplaced_heat_ += (1.0 - to.part) * heat;
  }
}

void BoneHeat::advance(const workpiece::Stock& stock, const Vector3& tip_W,
                       const Eigen::Matrix3d& R_WT, const cutting::Engagement& grid,
                       std::span<const thermal::PatchCut> patches, double time) {
  if (patches_.empty()) make_patches(grid);
  take_away(stock, tip_W, R_WT.col(2));
  put_in(stock, tip_W, R_WT, patches);
  rest(time);
}

void BoneHeat::rest(double time) {
  field_.advance(time);
  hottest_now_ = options_.field.initial_temperature;
  const geometry::GridShape& shape = field_.shape();
  std::size_t at = 0;
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x, ++at) {
        if (!field_.is_bone(x, y, z)) continue;
        const double temperature = field_.temperature(x, y, z);
        peak_[at] = std::max(peak_[at], static_cast<float>(temperature));
        hottest_ = std::max(hottest_, temperature);
        if (stays_.empty() || stays_[at] != 0) hottest_now_ = std::max(hottest_now_, temperature);
        if (temperature < kDoseFrom) continue;
        dose_[at] += static_cast<float>(thermal::cem43_minutes(temperature, time));
        if (temperature >= thermal::k47For60s.temperature)
          above_47_[at] += static_cast<float>(time);
        if (temperature >= thermal::k50For30s.temperature)
          above_50_[at] += static_cast<float>(time);
      }
}

/// Bone left with a value of the limit or more.
Damage BoneHeat::beyond(const std::vector<float>& values, double limit) const {
  Damage damage;
  const geometry::GridShape& shape = field_.shape();
  double deepest_sq = 0.0;
  std::size_t at = 0;
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x, ++at) {
        if (!field_.is_bone(x, y, z) || static_cast<double>(values[at]) < limit) continue;
        damage.volume += shape.voxel_volume();
        double nearest_sq = std::numeric_limits<double>::infinity();
        for (const std::array<int, 3>& cut : cut_cells_)
          nearest_sq =
              std::min(nearest_sq, (Vector3(x - cut[0], y - cut[1], z - cut[2])).squaredNorm());
        if (std::isfinite(nearest_sq)) deepest_sq = std::max(deepest_sq, nearest_sq);
      }
  // From the centre of a cell to that of the next cut one: half a cell of each.
  if (deepest_sq > 0.0) damage.depth = (std::sqrt(deepest_sq) - 0.5) * shape.spacing.x();
  return damage;
}

BoneHeatSummary BoneHeat::summary() const {
  BoneHeatSummary summary;
  summary.hottest = hottest_;
  summary.hottest_left = options_.field.initial_temperature;
  summary.heat_in_bone = field_.added_energy();
  summary.unplaced_heat = unplaced_heat_;
  const geometry::GridShape& shape = field_.shape();
  std::size_t at = 0;
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x, ++at) {
        if (!field_.is_bone(x, y, z)) continue;
        summary.hottest_left = std::max(summary.hottest_left, static_cast<double>(peak_[at]));
        summary.largest_dose = std::max(summary.largest_dose, static_cast<double>(dose_[at]));
      }
  summary.by_dose = beyond(dose_, thermal::kBoneDamageCem43);
  // Sums of many periods in single precision.
  const double least = 1.0 - 1e-5;
  summary.by_47c_60s = beyond(above_47_, least * thermal::k47For60s.time);
  summary.by_50c_30s = beyond(above_50_, least * thermal::k50For30s.time);
  return summary;
}

}  // namespace osteomill::simulate
