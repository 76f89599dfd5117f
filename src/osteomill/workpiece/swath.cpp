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

Stock::Occupancy occupancy_at(double distance) {
  return static_cast<Stock::Occupancy>(std::clamp(kBand + distance, 0.0, 1.0) * Stock::kFull + 0.5);
}

}  // namespace

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
  lowest_ = std::min(from.z(), to.z());
  // From here up the envelope is upright all along: a rise makes no difference.
  upright_from_ = std::max(from.z(), to.z()) + cutter_.upright_from(kBand);
  if (rise_ != 0.0) swept_ = SweptTool(cutter_, from, to);
  listed_ = false;
  begin_rows();
}

void Swath::begin_rows() {
  const double reach = cutter_.radius() + kBand;
  const double low = std::max(0.0, std::min(from_.y(), to_.y()) - reach);
  const double high = std::min(shape_.size[1] - 1.0, std::max(from_.y(), to_.y()) + reach);
  first_y_ = static_cast<int>(std::ceil(std::min(low, 1e9)));
  last_y_ = static_cast<int>(std::floor(std::max(high, -1.0)));
  if (first_y_ > last_y_) return;
  const std::size_t size = up_to_eight(static_cast<std::size_t>(last_y_ - first_y_ + 1));
  rows_.resize(7 * size);
  stretches_.resize(6 * size);
  runs_.resize(2 * size);
  double* const at = rows_.data();
  row_arrays_ = {
      at, at + size, at + 2 * size, at + 3 * size, at + 4 * size, at + 5 * size, at + 6 * size};
  int* const out = stretches_.data();
  stretch_arrays_ = {
      {out, out + size}, {out + 2 * size, out + 3 * size}, out + 4 * size, out + 5 * size};
  const double per_hx = std::abs(hx_) > kAlongAxis ? 1.0 / hx_ : 0.0;
  const double per_hy = std::abs(hy_) > kAlongAxis ? 1.0 / hy_ : 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    const double y = first_y_ + static_cast<double>(i);
    const double y0 = y - from_.y(), y1 = y - to_.y();
    const double along = hy_ * y0;  // 0 <= hx (x - from) + along <= run
    double ahead_low = -kFar, ahead_high = kFar, beside_low = -kFar, beside_high = kFar;
    const double start = from_.x() - along * per_hx, end = start + run_ * per_hx;
    if (per_hx != 0.0) {
      (per_hx > 0.0 ? ahead_low : ahead_high) = start;
      beside_low = std::min(start, end);
      beside_high = std::max(start, end);
    } else {
      if (along < 0.0) ahead_low = kFar;
      if (along < 0.0 || along > run_) beside_low = kFar;
    }
    double* row = at + i;
    for (const double value : {y0 * y0, y1 * y1, ahead_low, ahead_high, beside_low, beside_high,
                               from_.x() + hx_ * y0 * per_hy}) {
      *row = value;
      row += size;
    }
  }
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

inline void Swath::add_run(int row, int part) {
  const int first = stretch_arrays_.first[part][row], last = stretch_arrays_.last[part][row];
  if (first > last) return;
  Run& run = runs_[run_count_++];
  run = {first_y_ + row,
         first,
         last,
         fresh_size_,
         stretch_arrays_.gone_first[row],
         stretch_arrays_.gone_last[row]};
  fresh_size_ += static_cast<std::size_t>(kernel::lanes_of(run));
}

/// The occupancies of the voxels of the runs of a layer.
void Swath::fill(int z) {
  if (fresh_.size() < fresh_size_) fresh_.resize(2 * fresh_size_);
  const bool is_upright = upright(z);
  if (is_upright && (cutter_.is_ball() || height_ >= cutter_.upright_from(kBand))) {
    const double below = cutter_.is_ball() ? std::min(0.0, height_ - cutter_.radius()) : 0.0;
    kernel::best().fill(
        {from_.x(), from_.y(), hx_, hy_, run_, below * below, kBand - cutter_.radius()},
        runs_.data(), run_count_, fresh_.data());
    return;
  }
  for (const Run& run : runs()) {
    const double y = run.y - from_.y();
    Stock::Occupancy* fresh = fresh_.data() + run.fresh;
    const int start = kernel::start_of(run), end = start + kernel::lanes_of(run);
    for (int x = start; x < end; ++x, ++fresh) {
      if (x < run.first || x > run.last) {
        *fresh = kNothing;
      } else if (x >= run.gone_first && x <= run.gone_last) {
        *fresh = 0;
      } else if (!is_upright) {
        *fresh = occupancy_at(swept_.distance(Vector3(x, run.y, z)));
      } else {
        const double dx = x - from_.x(), along = hx_ * dx + hy_ * y;
        const double ahead = along - std::clamp(along, 0.0, run_), lateral = hx_ * y - hy_ * dx;
        *fresh =
            occupancy_at(cutter_.distance(std::sqrt(ahead * ahead + lateral * lateral), height_));
      }
    }
  }
}

bool Swath::list(int z, std::span<const std::int64_t> row_units) {
  const bool is_upright = upright(z);
  const double height = rise_ == 0.0 ? z - from_.z() : is_upright ? kFar : 0.0;
  kernel::Section section{};
  section.from_x = from_.x();
  section.to_x = to_.x();
  section.outer = cutter_.section_radius(z - lowest_, kBand);
  section.inner = is_upright ? cutter_.section_radius(height, -kBand) : -1.0;
  section.gone = placing_ ? -1.0 : cutter_.section_radius(z - from_.z(), -kBand);
  section.slant = std::abs(hy_) > kAlongAxis ? 1.0 / std::abs(hy_) : 0.0;
  section.from_too = !is_upright || placing_;
  section.moves = run_ > 0.0;
  section.last_x = shape_.size[0] - 1.0;
  // The side of a cylinder and of a shank: every layer is the same.
  const bool whole =
      is_upright && section.inner == cutter_.radius() - kBand && section.gone == section.inner;
  if (listed_ && whole && whole_) return false;
  listed_ = true;
  whole_ = whole;
  height_ = height;
  run_count_ = 0;
  fresh_size_ = 0;
  if (section.outer < 0.0 || first_y_ > last_y_) return true;
  const double low_y = std::min(from_.y(), to_.y()) - section.outer;
  const double high_y = std::max(from_.y(), to_.y()) + section.outer;
  const int first =
      std::max(first_y_, static_cast<int>(std::ceil(std::max(low_y, 0.0)))) - first_y_;
  const int last = std::min(last_y_, static_cast<int>(std::floor(high_y))) - first_y_;
  if (first > last) return true;
  kernel::best().stretches(row_arrays_, section, first, last, stretch_arrays_);
  for (int row = first; row <= last; ++row) {
    if (!whole && row_units[static_cast<std::size_t>((first_y_ + row) / 8)] == 0) continue;
    add_run(row, 0);
    add_run(row, 1);
  }
  fill(z);
  return true;
}

}  // namespace osteomill::workpiece
