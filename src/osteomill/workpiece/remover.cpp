// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/remover.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/swept_tool.hpp"

namespace osteomill::workpiece {

// Everything below is in voxel coordinates: voxel (x, y, z) has its centre at (x, y, z).

namespace {

constexpr double kBand = 0.5;  // half the width over which occupancy goes from 1 to 0
// Far below a unit of occupancy, far above rounding: the end of one step is the start of the next,
// and a move is level or vertical.
constexpr double kSamePlace = 1e-6;
constexpr double kLevel = 1e-9;
constexpr double kLeastRadius = 2.0;  // of a cutter: below, occupancy can't tell its shape

double square(double a) { return a * a; }

/// Radius of the body at this signed distance from the cutter, at a height above its tip; < 0 where
/// the body doesn't reach. `offset` is +-kBand.
double section_radius(const cutting::Cutter& cutter, double height, double offset) {
  const double radius = cutter.radius + offset;
  if (cutter.shape == cutting::CutterShape::ball) {
    const double below = cutter.radius - height;
    if (below <= 0.0) return radius;
    return below < radius ? std::sqrt(square(radius) - square(below)) : -1.0;
  }
  return height >= -offset ? radius : -1.0;
}

/// An interval of x in a row.
struct Interval {
  double low, high;
  bool empty() const { return low > high; }
  void clip_above(double rate, double offset) {  // keep rate * x >= offset
    if (rate > 0.0)
      low = std::max(low, offset / rate);
    else if (rate < 0.0)
      high = std::min(high, offset / rate);
    else if (offset > 0.0)
      high = low - 1.0;
  }
};

Interval disk_in_row(double x, double y_offset, double radius) {
  const double rest = square(radius) - square(y_offset);
  if (radius < 0.0 || rest < 0.0) return {1.0, 0.0};
  const double half = std::sqrt(rest);
  return {x - half, x + half};
}

}  // namespace

struct Remover::Step {
  Vector3 from, to;
  double run = 0.0;                    ///< horizontal length
  double hx = 1.0, hy = 0.0;           ///< horizontal direction
  bool level = false, plunge = false;  ///< no rise; no run

  Step(const Vector3& start, const Vector3& end) : from(start), to(end) {
    const Vector3 way = end - start;
    run = std::hypot(way.x(), way.y());
    level = way.z() == 0.0;
    plunge = run == 0.0;
    if (!plunge) {
      hx = way.x() / run;
      hy = way.y() / run;
    }
  }

  /// Where a body that has this radius at the row's height passes through row y; `front` keeps
  /// what is ahead of the start.
  Interval in_row(double y, double radius, bool front) const {
    const double y0 = y - from.y(), y1 = y - to.y();
    const Interval start = disk_in_row(from.x(), y0, radius);
    const Interval end = disk_in_row(to.x(), y1, radius);
    Interval strip{-1e30, 1e30};
    if (plunge) {
      strip = {1.0, 0.0};
    } else {
      // x relative to the start: 0 <= hx x + hy y0 <= run, |hx y0 - hy x| <= radius
      strip.clip_above(hx, -hy * y0);
      strip.clip_above(-hx, hy * y0 - run);
      strip.clip_above(-hy, -radius - hx * y0);
      strip.clip_above(hy, -radius + hx * y0);
      strip.low += from.x();
      strip.high += from.x();
    }
    Interval all{1e30, -1e30};
    for (const Interval& part : {start, end, strip}) {
      if (part.empty()) continue;
      all.low = std::min(all.low, part.low);
      all.high = std::max(all.high, part.high);
    }
    if (front && !all.empty()) {
      all.low -= from.x();
      all.high -= from.x();
      all.clip_above(hx, -hy * y0);
      all.low += from.x();
      all.high += from.x();
    }
    return all;
  }
};

/// Bone that leaves no trace in the map: what was inside the cutter before the step.
struct Remover::NoMap {
  void start_row(int, int) {}
  void add(int, float) {}
  void finish_row() {}
};

/// A level feed: eta is constant in a row, the lateral coordinate is linear in x.
struct Remover::LevelMap {
  ShadowMap& map;
  Vector3 tip;
  float* cells = nullptr;
  float* upper_cells = nullptr;
  float lower_share = 1.0f, upper_share = 0.0f;
  double lateral_start = 0.0, lateral_rate = 0.0;
  int map_row = 0;
  bool touched = false;

  void start_row(int y, int z) {
    const double eta = map.eta_cell(Vector3(0.0, 0.0, z - tip.z()));
    // A millionth of a cell is rounding: the layer lies on the row.
    map_row = static_cast<int>(std::floor(eta + 1e-6));
    const double upper = eta - map_row;
    cells = map_row >= 0 && map_row < map.rows() ? map.row(map_row) : nullptr;
    upper_cells = upper > 2e-6 && map_row + 1 >= 0 && map_row + 1 < map.rows()
                      ? map.row(map_row + 1)
                      : nullptr;
    upper_share = upper > 2e-6 ? static_cast<float>(upper) * map.gain() : 0.0f;
    lower_share = map.gain() - upper_share;
    lateral_start = map.lateral_cell(Vector3(-tip.x(), y - tip.y(), 0.0));
    lateral_rate = map.y_T().x();
    touched = false;
  }
  void add(int x, float amount) {
    int column = 0;
    const auto& shares = map.lateral_shadow().shares(lateral_start + lateral_rate * x, column);
    touched = true;
    if (cells) add_three(cells + column, shares, lower_share * amount);
    if (upper_cells) add_three(upper_cells + column, shares, upper_share * amount);
  }
  static void add_three(float* at, const std::array<float, 3>& shares, float amount) {
    at[-1] += shares[0] * amount;
    at[0] += shares[1] * amount;
    at[1] += shares[2] * amount;
  }
  void finish_row() {
    if (!touched) return;
    if (cells) map.note_row(map_row);
    if (upper_cells) map.note_row(map_row + 1);
  }
};

/// Any feed: both coordinates are linear in x.
struct Remover::TiltedMap {
  ShadowMap& map;
  Vector3 tip;
  double lateral_start = 0.0, lateral_rate = 0.0, eta_start = 0.0, eta_rate = 0.0;

  void start_row(int y, int z) {
    const Vector3 start = Vector3(0.0, y, z) - tip;
    lateral_start = map.lateral_cell(start);
    eta_start = map.eta_cell(start);
    lateral_rate = map.y_T().x();
    eta_rate = map.eta().x();
  }
  void add(int x, float amount) {
    const double eta = eta_start + eta_rate * x;
    if (eta < 0.5 || eta > map.rows() - 1.5) return;  // above the cutting length
    int column = 0, at = 0;
    const auto& across = map.lateral_shadow().shares(lateral_start + lateral_rate * x, column);
    const auto& up = map.eta_shadow().shares(eta, at);
    amount *= map.gain();
    for (int k = 0; k < 3; ++k)
      LevelMap::add_three(map.row(at + k - 1) + column, across,
                          up[static_cast<std::size_t>(k)] * amount);
    map.note_row(at - 1);
    map.note_row(at + 1);
  }
  void finish_row() {}
};

namespace {

/// The signed distance in one row where it depends on the horizontal offset from the path alone:
/// level moves, and the part of any move where the envelope is upright all along.
struct LevelDistance {
  double along_start, along_rate, lateral_start, lateral_rate, run;
  double inner_sq, outer_sq;  ///< squares of the offset inside which all goes, outside which none
  bool ball;
  double radius;
  double below_sq;  ///< ball: square of the depth below the centre
  double height;    ///< cylinder: above the tip

  double operator()(int x) const {
    const double along = along_start + along_rate * x;
    const double lateral = lateral_start + lateral_rate * x;
    const double ahead = along - std::clamp(along, 0.0, run);
    const double r_sq = ahead * ahead + lateral * lateral;
    if (r_sq <= inner_sq) return -kBand;
    if (r_sq >= outer_sq) return kBand;
    if (ball) return std::sqrt(r_sq + below_sq) - radius;
    const double wall = std::sqrt(r_sq) - radius;
    if (wall > 0.0 && height < 0.0) return std::sqrt(wall * wall + height * height);
    return std::max(wall, -height);
  }
};

/// The signed distance by the reference, for what isn't level.
struct SweptDistance {
  const SweptTool& swept;
  Vector3 row;
  double operator()(int x) const { return swept.distance(Vector3(x, row.y(), row.z())); }
};

}  // namespace

namespace {

const cutting::Cutter& checked(const cutting::Cutter& cutter, const geometry::GridShape& shape) {
  cutting::check(cutter);
  const double spacing = shape.spacing.x();
  const double widest = spacing * std::max(shape.size[0], shape.size[1]);
  if (2.0 * cutter.radius > widest)
    throw InvalidInput(
        Fault{"cutter.diameter_mm", fmt::format("{:.4g} mm", 2.0 * cutter.radius / units::mm),
              fmt::format("must not be larger than the region of the stock, {:.4g} x {:.4g} mm",
                          spacing * shape.size[0] / units::mm, spacing * shape.size[1] / units::mm),
              "use a larger region or a smaller cutter"});
  if (cutter.radius < kLeastRadius * spacing)
    throw InvalidInput(
        Fault{"cutter.diameter_mm", fmt::format("{:.4g} mm", 2.0 * cutter.radius / units::mm),
              fmt::format("must be at least {} voxels, {:.4g} mm", 2.0 * kLeastRadius,
                          2.0 * kLeastRadius * spacing / units::mm),
              "use smaller voxels"});
  return cutter;
}

}  // namespace

Remover::Remover(Stock& stock, const cutting::Cutter& cutter, const RemoverOptions& options)
    : stock_(stock),
      cutter_(checked(cutter, stock.shape())),
      map_(cutter, stock.spacing(),
           options.patches.slices > 0 ? options.patches : patches_for(cutter, stock.spacing()),
           options.memory) {
  cutter_.radius /= stock.spacing();
  cutter_.cutting_length /= stock.spacing();
}

template <class Distance, class Map>
void Remover::carve_row(int y, int z, int first, int last, const Distance& distance, Map& map,
                        Totals& totals) {
  Stock::Row& row = stock_.rows_[stock_.row_index(y, z)];
  first = std::max(first, row.first);
  last = std::min(last, row.first + row.length - 1);
  if (first > last) return;
  Stock::Occupancy* occupancy = stock_.occupancy_.data() + row.start - row.first;
  const std::uint16_t* material = stock_.material_.data() + row.start - row.first;
  const BoneMaterial* palette = stock_.palette_.data();
  std::uint32_t units = 0;
  for (int x = first; x <= last; ++x) {
    const int old = occupancy[x];
    if (old == 0) continue;
    const double d = distance(x);
    if (d >= kBand) continue;
    const int fresh = d <= -kBand ? 0 : static_cast<int>((kBand + d) * Stock::kFull + 0.5);
    if (fresh >= old) continue;
    occupancy[x] = static_cast<Stock::Occupancy>(fresh);
    const int taken = old - fresh;
    const BoneMaterial& bone = palette[material[x]];
    const double scaled = taken * bone.force_scale;
    units += static_cast<std::uint32_t>(taken);
    totals.unit_density += taken * bone.density;
    totals.unit_scale += scaled;
    map.add(x, static_cast<float>(scaled * (1.0 / Stock::kFull)));
  }
  row.units -= units;
  stock_.layer_units_[static_cast<std::size_t>(z)] -= units;
  totals.units += units;
}

void Remover::carve(const Step& step, Totals& totals) {
  const geometry::GridShape& shape = stock_.shape_;
  const double lowest = std::min(step.from.z(), step.to.z());
  const double highest = std::max(step.from.z(), step.to.z());
  // From here up the envelope is upright: a rise makes no difference.
  const double upright_from =
      highest + (cutter_.shape == cutting::CutterShape::ball ? cutter_.radius : kBand);
  const SweptTool swept(cutter_, step.from, step.to);
  LevelMap level_map{map_, step.from};
  TiltedMap tilted_map{map_, step.from};

  const int first_z = std::max(0, static_cast<int>(std::ceil(lowest - kBand)));
  for (int z = first_z; z < shape.size[2]; ++z) {
    if (stock_.layer_units_[static_cast<std::size_t>(z)] == 0) continue;
    const bool upright = step.level || z >= upright_from;
    if (upright && step.plunge) break;  // nothing new above
    const double outer = section_radius(cutter_, z - lowest, kBand);
    if (outer < 0.0) continue;
    const double inner = section_radius(cutter_, z - step.from.z(), -kBand);
    const int first_y =
        std::max(0, static_cast<int>(std::ceil(std::min(step.from.y(), step.to.y()) - outer)));
    const int last_y =
        std::min(shape.size[1] - 1,
                 static_cast<int>(std::floor(std::max(step.from.y(), step.to.y()) + outer)));
    for (int y = first_y; y <= last_y; ++y) {
      const Stock::Row& row = stock_.row(y, z);
      if (row.units == 0) continue;
      const Interval reach = step.in_row(y, outer, upright);
      if (reach.empty()) continue;
      const Interval gone = disk_in_row(step.from.x(), y - step.from.y(), inner);
      // Up to two stretches: before and behind what the cutter has already taken.
      Interval parts[2] = {reach, {1.0, 0.0}};
      if (!gone.empty()) {
        parts[0].high = std::min(reach.high, gone.low);
        parts[1] = {std::max(reach.low, gone.high), reach.high};
      }
      const auto walk = [&](const auto& distance, auto& map) {
        map.start_row(y, z);
        for (const Interval& part : parts)
          if (!part.empty())
            carve_row(y, z, static_cast<int>(std::ceil(std::max(part.low, -1.0))),
                      static_cast<int>(std::floor(std::min<double>(part.high, shape.size[0]))),
                      distance, map, totals);
        map.finish_row();
      };
      if (upright) {
        const double y0 = y - step.from.y();
        LevelDistance distance{};
        distance.along_start = step.hy * y0 - step.hx * step.from.x();
        distance.along_rate = step.hx;
        distance.lateral_start = step.hx * y0 + step.hy * step.from.x();
        distance.lateral_rate = -step.hy;
        distance.run = step.run;
        distance.outer_sq = square(outer);
        distance.inner_sq = inner > 0.0 ? square(inner) : -1.0;
        distance.ball = cutter_.shape == cutting::CutterShape::ball;
        distance.radius = cutter_.radius;
        distance.height = step.level ? z - step.from.z() : kBand;
        distance.below_sq = square(std::max(0.0, cutter_.radius - (z - step.from.z())));
        if (step.level)
          walk(distance, level_map);
        else
          walk(distance, tilted_map);
      } else {
        walk(SweptDistance{swept, Vector3(0.0, y, z)}, tilted_map);
      }
    }
  }
}

double Remover::bury(const Vector3& tip) {
  const geometry::GridShape& shape = stock_.shape_;
  const SweptTool still(cutter_, tip, tip);
  const double outer = cutter_.radius + kBand;
  Totals totals;
  NoMap none;
  const auto from = [](double at) { return std::max(0, static_cast<int>(std::ceil(at))); };
  const int last_y = std::min(shape.size[1] - 1, static_cast<int>(std::floor(tip.y() + outer)));
  for (int z = from(tip.z() - kBand); z < shape.size[2]; ++z) {
    if (stock_.layer_units_[static_cast<std::size_t>(z)] == 0) continue;
    for (int y = from(tip.y() - outer); y <= last_y; ++y) {
      const Interval reach = disk_in_row(tip.x(), y - tip.y(), outer);
      if (reach.empty()) continue;
      carve_row(y, z, from(reach.low),
                static_cast<int>(std::floor(std::min<double>(reach.high, shape.size[0]))),
                SweptDistance{still, Vector3(0.0, y, z)}, none, totals);
    }
  }
  return static_cast<double>(totals.units) * stock_.unit_volume();
}

Removal Remover::step(const Vector3& from_W, const Vector3& to_W) {
  const auto to_voxels = [&](const Vector3& p_W) -> Vector3 {
    return (p_W - stock_.shape_.origin) / stock_.spacing();
  };
  Removal removal;
  if (const Vector3 from = to_voxels(from_W); !placed_ || (from - tip_).norm() > kSamePlace) {
    removal.buried_volume = bury(from);
    map_.clear();
    tip_ = from;
    placed_ = true;
  }
  Vector3 to = to_voxels(to_W);
  if (std::abs(to.z() - tip_.z()) < kLevel) to.z() = tip_.z();
  if (std::hypot(to.x() - tip_.x(), to.y() - tip_.y()) < kLevel) to.head<2>() = tip_.head<2>();
  const double length = (to - tip_).norm();
  if (length == 0.0) return removal;
  const Step step(tip_, to);
  tip_ = to;
  map_.begin_step((step.to - step.from) / length, step.from, length);
  Totals totals;
  carve(step, totals);
  removal.volume = static_cast<double>(totals.units) * stock_.unit_volume();
  removal.mass = totals.unit_density * stock_.unit_volume();
  removal.scaled_volume = totals.unit_scale * stock_.unit_volume();
  return removal;
}

}  // namespace osteomill::workpiece
