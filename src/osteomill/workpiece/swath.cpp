// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/swath.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/workpiece/lanes.hpp"

namespace osteomill::workpiece {

namespace {

constexpr double kBand = 0.5;  // half the width over which occupancy goes from 1 to 0
constexpr double kFar = 1e30;
constexpr double kAlongAxis = 1e-12;  // a direction cosine that is none

double square(double a) { return a * a; }

Stock::Occupancy occupancy_at(double distance) {
  return static_cast<Stock::Occupancy>(std::clamp(kBand + distance, 0.0, 1.0) * Stock::kFull + 0.5);
}

}  // namespace

/// Of x in a row.
struct Swath::Interval {
  double low = 1.0, high = 0.0;
  bool empty() const { return low > high; }
  void join(const Interval& other) {
    if (other.empty()) return;
    if (empty()) *this = other;
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
  static Interval of_disk(double x, double y_offset, double radius) {
    const double rest = square(radius) - square(y_offset);
    if (radius < 0.0 || rest < 0.0) return {};
    const double half = std::sqrt(rest);
    return {x - half, x + half};
  }
};

/// What all sections of a row have in common.
struct Swath::Row {
  int y = 0;
  double y0 = 0.0, y1 = 0.0;  ///< offset from the start and the end
  double front = -kFar;       ///< least x (hx > 0) or greatest x (hx < 0) ahead of the start
  Interval beside;            ///< x between start and end along the feed
  double centre = 0.0;        ///< x on the line of the feed, where hy isn't 0
};

void Swath::begin(const Vector3& from, const Vector3& to) {
  from_ = from;
  to_ = to;
  const Vector3 way = to - from;
  run_ = std::hypot(way.x(), way.y());
  rise_ = way.z();
  if (run_ > 0.0) {
    hx_ = way.x() / run_;
    hy_ = way.y() / run_;
  } else {
    hx_ = 1.0;
    hy_ = 0.0;
  }
  per_hx_ = std::abs(hx_) > kAlongAxis ? 1.0 / hx_ : 0.0;
  per_hy_ = std::abs(hy_) > kAlongAxis ? 1.0 / hy_ : 0.0;
  lowest_ = std::min(from.z(), to.z());
  // From here up the envelope is upright all along: a rise makes no difference.
  upright_from_ = std::max(from.z(), to.z()) + cutter_.upright_from(kBand);
  if (rise_ != 0.0) swept_ = SweptTool(cutter_, from, to);
  listed_ = false;
}

void Swath::begin_step(const Vector3& from, const Vector3& to) {
  placing_ = false;
  begin(from, to);
}

void Swath::begin_placing(const Vector3& tip) {
  placing_ = true;
  begin(tip, tip);
}

int Swath::first_layer() const {
  return static_cast<int>(std::ceil(std::max(0.0, lowest_ - kBand)));
}

bool Swath::reaches(int z) const { return run_ > 0.0 || placing_ || !upright(z); }

Swath::Interval Swath::front(const Row& row, double radius) const {
  Interval all = Interval::of_disk(to_.x(), row.y1, radius);
  if (hx_ > kAlongAxis)
    all.low = std::max(all.low, row.front);
  else if (hx_ < -kAlongAxis)
    all.high = std::min(all.high, row.front);
  else if (hy_ * row.y0 < 0.0)
    all = {};
  Interval strip = row.beside;
  if (per_hy_ != 0.0) {
    const double half = radius * std::abs(per_hy_);
    strip.low = std::max(strip.low, row.centre - half);
    strip.high = std::min(strip.high, row.centre + half);
  } else if (std::abs(row.y0) > radius) {
    strip = {};
  }
  if (radius >= 0.0) all.join(strip);
  return all;
}

Swath::Interval Swath::everywhere(const Row& row, double radius) const {
  Interval all = Interval::of_disk(from_.x(), row.y0, radius);
  if (run_ > 0.0) all.join(front(row, radius));
  return all;
}

/// The occupancy of eight voxels of a run from its start() + at on.
template <bool round>
void Swath::fill_level(const Run& run, int at, const Row& row) {
  const double along_y = hy_ * row.y0, lateral_y = hx_ * row.y0;
  const double under = below_ * below_, offset = kBand - cutter_.radius();
  const TwoDoubles zero = {}, length = {run_, run_}, full = {Stock::kFull, Stock::kFull};
  const double x = run.start() + at - from_.x();
  const auto two = [&](double first) {
    const TwoDoubles dx = {first, first + 1.0};
    const TwoDoubles along = hx_ * dx + along_y, lateral = lateral_y - hy_ * dx;
    const TwoDoubles ahead = along - least(most(along, zero), length);
    const TwoDoubles r_sq = ahead * ahead + lateral * lateral;
    TwoDoubles share;  // of the voxel
    if constexpr (round) {
      share = root(r_sq + under) + offset;
    } else {
      const TwoDoubles r = root(r_sq);
      share = TwoDoubles{cutter_.distance(r[0], height_), cutter_.distance(r[1], height_)} + kBand;
    }
    return least(most(share * full, zero), full) + 0.5;
  };
  const TwoDoubles units[4] = {two(x), two(x + 2), two(x + 4), two(x + 6)};
  store(as_shorts(units), fresh_.data() + run.fresh + at);
}

void Swath::add_run(const Interval& part, const Interval& all_gone, const Row& row, int z) {
  if (part.empty()) return;
  Run run;
  run.y = row.y;
  if (part.high < 0.0) return;
  const double low = std::max(part.low, 0.0);
  run.first = static_cast<int>(std::min(low, 1e9));  // rounded down
  if (run.first < low) ++run.first;
  run.last = static_cast<int>(std::min(part.high, shape_.size[0] - 1.0));
  if (run.first > run.last) return;
  run.fresh = fresh_size_;
  fresh_size_ += static_cast<std::size_t>(run.lanes());
  if (fresh_.size() < fresh_size_) fresh_.resize(2 * fresh_size_);
  Stock::Occupancy* fresh = fresh_.data() + run.fresh;
  for (int k = 0; k < run.lanes(); k += kEight) {
    const int x = run.start() + k;
    if (!upright(z)) {
      for (int i = 0; i < kEight; ++i)
        fresh[k + i] = x + i < run.first || x + i > run.last
                           ? kNothing
                           : occupancy_at(swept_.distance(Vector3(x + i, row.y, z)));
    } else if (x >= all_gone.low && x + kEight - 1 <= all_gone.high) {
      store(EightShorts{}, fresh + k);  // between the rims all goes
    } else if (round_) {
      fill_level<true>(run, k, row);
    } else {
      fill_level<false>(run, k, row);
    }
  }
  runs_.push_back(run);
}

bool Swath::list(int z, std::span<const std::int64_t> row_units) {
  const bool is_upright = upright(z);
  const double height = rise_ == 0.0 ? z - from_.z() : is_upright ? kFar : 0.0;
  const double outer = cutter_.section_radius(z - lowest_, kBand);
  const double inner = is_upright ? cutter_.section_radius(height, -kBand) : -1.0;
  const double gone = placing_ ? -1.0 : cutter_.section_radius(z - from_.z(), -kBand);
  // The side of a cylinder and of a shank: every layer is the same.
  const bool whole = is_upright && inner == cutter_.radius() - kBand && gone == inner;
  if (listed_ && whole && whole_) return false;
  listed_ = true;
  whole_ = whole;
  height_ = height;
  round_ = cutter_.is_ball() || height >= cutter_.upright_from(kBand);
  below_ = cutter_.is_ball() ? std::min(0.0, height - cutter_.radius()) : 0.0;
  runs_.clear();
  fresh_size_ = 0;
  if (outer < 0.0) return true;
  const double low_y = std::min(from_.y(), to_.y()) - outer;
  const double high_y = std::max(from_.y(), to_.y()) + outer;
  Row row;
  row.y = static_cast<int>(std::ceil(std::max(0.0, low_y)));
  const int last_y = static_cast<int>(std::floor(std::min(shape_.size[1] - 1.0, high_y)));
  for (; row.y <= last_y; ++row.y) {
    if (!whole && row_units[static_cast<std::size_t>(row.y / 8)] == 0) continue;
    row.y0 = row.y - from_.y();
    row.y1 = row.y - to_.y();
    const double along = hy_ * row.y0;  // 0 <= hx (x - from) + along <= run
    row.front = from_.x() - along * per_hx_;
    if (per_hx_ != 0.0) {
      const double end = row.front + run_ * per_hx_;
      row.beside = {std::min(row.front, end), std::max(row.front, end)};
    } else if (along >= 0.0 && along <= run_) {
      row.beside = {-kFar, kFar};
    } else {
      row.beside = {};
    }
    row.centre = from_.x() + hx_ * row.y0 * per_hy_;
    const bool ahead_only = is_upright && !placing_;
    const Interval reach = ahead_only ? front(row, outer) : everywhere(row, outer);
    if (reach.empty()) continue;
    const Interval all_gone = ahead_only ? front(row, inner) : everywhere(row, inner);
    const Interval before = Interval::of_disk(from_.x(), row.y0, gone);
    if (before.empty()) {
      add_run(reach, all_gone, row, z);
      continue;
    }
    // Before and behind what the cutter has taken already.
    add_run({reach.low, std::min(reach.high, before.low)}, all_gone, row, z);
    add_run({std::max(reach.low, before.high), reach.high}, all_gone, row, z);
  }
  return true;
}

}  // namespace osteomill::workpiece
