// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/voxel_shadow.hpp"

#include <cmath>

namespace osteomill::workpiece {

VoxelShadow::VoxelShadow(const geometry::Vector3& direction) {
  widths_[0] = 1.0;
  boxes_ = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double width = std::abs(direction[axis]);
    // Narrower boxes blur by less than their width squared over 24, below 1e-6, and cancel badly.
    if (width > 4e-3) widths_[static_cast<std::size_t>(boxes_++)] = width;
  }
  for (int box = 0; box < boxes_; ++box)
    half_width_ += 0.5 * widths_[static_cast<std::size_t>(box)];
  for (int phase = 0; phase < kPhases; ++phase) {
    // The middle phase is a voxel on its cell, whose shares then are exact.
    const double offset = static_cast<double>(phase) / kPhases - 0.5;
    double sum = 0.0;
    std::array<double, 3> share{};
    for (int cell = 0; cell < 3; ++cell) {
      share[static_cast<std::size_t>(cell)] = at(offset + 1.0 - cell);
      sum += share[static_cast<std::size_t>(cell)];
    }
    for (std::size_t cell = 0; cell < 3; ++cell)
      table_[static_cast<std::size_t>(phase)][kZeros + cell] =
          static_cast<float>(share[cell] / sum);
  }
}

double VoxelShadow::at(double distance) const {
  if (std::abs(distance) >= half_width_) return 0.0;
  // Convolution of n boxes of widths w: sum over signs of s (t + s·w/2)_+^(n-1) / ((n-1)! prod w).
  double sum = 0.0, scale = 1.0;
  for (int box = 0; box < boxes_; ++box) scale *= widths_[static_cast<std::size_t>(box)];
  for (int box = 2; box < boxes_; ++box) scale *= box;
  for (int signs = 0; signs < (1 << boxes_); ++signs) {
    double t = distance, sign = 1.0;
    for (int box = 0; box < boxes_; ++box) {
      const bool minus = ((signs >> box) & 1) != 0;
      t += (minus ? -0.5 : 0.5) * widths_[static_cast<std::size_t>(box)];
      if (minus) sign = -sign;
    }
    if (t <= 0.0) continue;
    double power = sign;
    for (int box = 1; box < boxes_; ++box) power *= t;
    sum += power;
  }
  return sum / scale;
}

void FourShadows::prepare(const VoxelShadow& shadow, std::int64_t rate) {
  if (!table_.empty() && rate == rate_ && shadow == shadow_) return;
  shadow_ = shadow;
  rate_ = rate;
  table_.assign(std::size_t{VoxelShadow::kPhases} * kVoxels * kCells, 0.0f);
  float* cells = table_.data();
  for (std::int64_t phase = 0; phase < VoxelShadow::kPhases; ++phase) {
    // The middle of the phase: there the others are as often too far as too near.
    const std::int64_t middle = (2 * phase + 1) << (31 - VoxelShadow::kPhaseBits);
    for (int voxel = 0; voxel < kVoxels; ++voxel, cells += kCells) {
      int nearest = 0;
      const float* shares = shadow.shares(middle + voxel * rate - (std::int64_t{1} << 31), nearest);
      for (int k = 0; k < 3; ++k) cells[nearest - 1 - first_cell() + k] = shares[k];
    }
  }
}

}  // namespace osteomill::workpiece
