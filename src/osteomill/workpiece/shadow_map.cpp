// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/shadow_map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/lanes.hpp"
#include "osteomill/workpiece/swept_tool.hpp"

namespace osteomill::workpiece {

namespace {

const double kTurnThatEmpties = std::cos(20.0 * units::deg);
// A pitch that moves the front by less leaves coverage and stencil as they are, in cells.
constexpr double kPitchTolerance = 0.25;
constexpr float kForgotten =
    1e-6f;  // of a full cell: far below the noise of sampling, no denormals

// A patch that sweeps less than this of what it would without the turn stands still: its contact
// can't be told.
constexpr double kLeastShare = 0.05;

// Columns beside the cutter's: the voxels of a window (FourShadows) that have nothing.
constexpr int kWindow = 4;

constexpr double kShadowTurn = 1e-3;  // of the axes, that leaves the shadows as they are

bool along_an_axis(const Vector3& direction) {
  return direction.cwiseAbs().maxCoeff() > 1.0 - 1e-12;
}

/// Phases of a lattice against the cells, and their weights.
struct Phase {
  double offset, weight;
};
std::vector<Phase> phases(const VoxelShadow& shadow, const Vector3& axis) {
  if (along_an_axis(axis)) return {{0.0, 1.0}};  // the layers lie on the cells
  constexpr int n = 12;
  std::vector<Phase> all;
  double sum = 0.0;
  for (int k = 0; k < n; ++k) {
    const double offset = shadow.half_width() * ((2.0 * k + 1.0) / n - 1.0);
    all.push_back({offset, shadow.at(offset)});
    sum += all.back().weight;
  }
  for (Phase& phase : all) phase.weight /= sum;
  return all;
}

}  // namespace

PatchGrid patches_for(const cutting::Cutter& cutter, double spacing) {
  PatchGrid patches;
  patches.slices =
      std::clamp(static_cast<int>(std::lround(cutter.cutting_length / spacing)), 1, 64);
  patches.slice_height = cutter.cutting_length / patches.slices;
  const double around = 2.0 * std::numbers::pi * cutter.radius / spacing;
  patches.angles = std::clamp(4 * static_cast<int>(std::lround(around / 4.0)), 48, 360);
  return patches;
}

ShadowMap::ShadowMap(const cutting::Cutter& cutter, double spacing, const PatchGrid& patches,
                     double memory)
    : cutter_(scaled(cutter, 1.0 / spacing)),
      meridian_(cutter_),
      patches_(patches),
      memory_(memory),
      middle_height_(meridian_.is_ball() ? cutter_.radius : 0.0),
      slice_height_(patches.slice_height / spacing) {
  require_within("engagement.slices", patches.slices, 1, 4096, "");
  require_within("engagement.angles", patches.angles, 4, 4096, "");
  require_positive("engagement.slice_height_mm", patches.slice_height / units::mm, "mm");
  require_non_negative("engagement.memory", memory, "voxels");
  const double reach = slice_height_ * patches.slices;
  columns_ = 2 * (static_cast<int>(std::ceil(cutter_.radius)) + kWindow) + 5;
  // Any pitch: the cylinder of radius R and this reach, seen from any side.
  rows_ = static_cast<int>(std::ceil(2.0 * cutter_.radius + reach)) + 6;
  stride_ = up_to_four(columns_) + kEight;
  cells_.assign(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(rows_), 0.0f);
  coverage_ = cells_;
  engagement_.slices = patches.slices;
  engagement_.angles = patches.angles;
  engagement_.slice_height = patches.slice_height;
  engagement_.weights.assign(
      static_cast<std::size_t>(patches.slices) * static_cast<std::size_t>(patches.angles), 0.0);
  clear();
}

void ShadowMap::clear() {
  std::fill(cells_.begin(), cells_.end(), 0.0f);
  first_row_ = rows_;
  last_row_ = -1;
  feed_.setZero();
}

void ShadowMap::begin_step(const Step& step) {
  const Vector3& feed = step.feed;
  const double length = step.length;
  const bool turned = feed_.dot(feed) < kTurnThatEmpties;
  z_T_ = step.axis;
  const double sin_pitch = -feed.dot(z_T_);
  const Vector3 across = feed + sin_pitch * z_T_;
  const double horizontal = across.norm();
  if (horizontal > 1e-9)
    x_T_ = across / horizontal;
  else if (std::abs(x_T_.dot(z_T_)) > 1e-9)  // the last one, across the axis
    x_T_ = y_T_.cross(z_T_).norm() > 0.5 ? y_T_.cross(z_T_).normalized() : z_T_.unitOrthogonal();
  y_T_ = z_T_.cross(x_T_);
  const double cos_pitch = horizontal > 1e-9 ? horizontal : 0.0;
  eta_ = sin_pitch * x_T_ + cos_pitch * z_T_;
  turn_T_ = Vector3(step.turn.dot(x_T_), step.turn.dot(y_T_), step.turn.dot(z_T_));
  if (turned) clear();
  feed_ = feed;
  if ((y_T_ - shadow_y_).norm() > kShadowTurn || (eta_ - shadow_eta_).norm() > kShadowTurn) {
    lateral_shadow_ = VoxelShadow(y_T_);
    eta_shadow_ = VoxelShadow(eta_);
    shadow_y_ = y_T_;
    shadow_eta_ = eta_;
  }
  if (turned || !laid_out_ || std::abs(sin_pitch - sin_pitch_) * cutter_.radius > kPitchTolerance)
    lay_out(sin_pitch, cos_pitch, step.middle - middle_height_ * z_T_);

  const double keep = memory_ > 0.0 ? std::exp(-length / memory_) : 0.0;
  gain_ = static_cast<float>(step.unit * (1.0 - keep) / length);
  const float factor = static_cast<float>(keep);
  int first = rows_, last = -1;
  for (int at = first_row_; at <= last_row_; ++at) {
    float* cells = row(at);
    FourInts left = {};
    for (int column = 0; column < stride_; column += kFour) {
      const FourFloats value = load<FourFloats>(cells + column) * factor;
      const FourInts stays = value > kForgotten;
      store(stays ? value : FourFloats{}, cells + column);
      left |= stays;
    }
    if ((left[0] | left[1] | left[2] | left[3]) == 0) continue;
    first = std::min(first, at);
    last = at;
  }
  first_row_ = first;
  last_row_ = last;
}

void ShadowMap::lay_out(double sin_pitch, double cos_pitch, const Vector3& tip) {
  sin_pitch_ = sin_pitch;
  cos_pitch_ = cos_pitch;
  // Cells through the voxel next to the tip: where the feed is along a grid axis all voxels then
  // lie on cells.
  const Vector3 to_lattice = tip.array().round().matrix() - tip;
  const double low = -cutter_.radius * std::abs(sin_pitch);
  const double middle = middle_height_ * cos_pitch;
  const double lateral = y_T_.dot(to_lattice) - (columns_ - 1) / 2;
  const double eta = eta_.dot(to_lattice) + std::floor(low) - 2.0 - middle;
  // What the cells hold goes along by whole cells.
  const int right = laid_out_ ? static_cast<int>(std::lround(lateral_origin_ - lateral)) : 0;
  const int up = laid_out_ ? static_cast<int>(std::lround(eta_origin_ - eta)) : 0;
  lateral_origin_ = laid_out_ && !along_an_axis(y_T_) ? lateral_origin_ - right : lateral;
  eta_origin_ = laid_out_ && !along_an_axis(eta_) ? eta_origin_ - up : eta;
  move_cells(right, up);
  compute_coverage();
  compute_stencil();
  laid_out_ = true;
}

void ShadowMap::move_cells(int right, int up) {
  if ((right == 0 && up == 0) || last_row_ < first_row_) return;
  const std::vector<float> before = std::exchange(cells_, std::vector<float>(cells_.size(), 0.0f));
  const int first = std::max(0, first_row_ + up), last = std::min(rows_ - 1, last_row_ + up);
  for (int at = first; at <= last; ++at) {
    const float* from = before.data() + static_cast<std::ptrdiff_t>(at - up) * stride_;
    const int begin = std::max(0, right), end = stride_ + std::min(0, right);
    std::copy(from + begin - right, from + end - right, row(at) + begin);
  }
  first_row_ = first <= last ? first : rows_;
  last_row_ = first <= last ? last : -1;
}

void ShadowMap::compute_coverage() {
  // The section of what the cutter sweeps on a long way, as occupancy, shared between cells as
  // voxels at every phase are.
  const double far = 4.0 * (cutter_.radius + cutter_.cutting_length);
  const Vector3 direction(cos_pitch_, 0.0, -sin_pitch_);  // in the tool frame
  const Vector3 eta(sin_pitch_, 0.0, cos_pitch_);
  const Vector3 tip = -middle_height_ * Vector3::UnitZ();
  const SweptTool swept(meridian_, tip - far * direction, tip + far * direction);
  const std::vector<Phase> lateral_phases = phases(lateral_shadow_, y_T_);
  const std::vector<Phase> eta_phases = phases(eta_shadow_, eta_);
  // A cell that all its voxels leave or fill needs no sum.
  const double reach = 0.5 + lateral_shadow_.half_width() + eta_shadow_.half_width();
  for (int j = 0; j < rows_; ++j)
    for (int i = 0; i < columns_; ++i) {
      double covered = 0.0;
      const double middle =
          swept.distance((lateral_origin_ + i) * Vector3::UnitY() + (eta_origin_ + j) * eta);
      if (std::abs(middle) > reach) {
        coverage_[static_cast<std::size_t>(j * stride_ + i)] = middle < 0.0 ? 1.0f : 0.0f;
        continue;
      }
      for (const Phase& b : eta_phases)
        for (const Phase& a : lateral_phases) {
          const Vector3 p = (lateral_origin_ + i + a.offset) * Vector3::UnitY() +
                            (eta_origin_ + j + b.offset) * eta;
          covered += a.weight * b.weight * std::clamp(0.5 - swept.distance(p), 0.0, 1.0);
        }
      coverage_[static_cast<std::size_t>(j * stride_ + i)] = static_cast<float>(covered);
    }
}

void ShadowMap::compute_stencil() {
  const auto samples_over = [](double extent) {
    return std::clamp(static_cast<int>(std::ceil(2.0 * extent)), 1, 16);
  };
  const double angle_step = 2.0 * std::numbers::pi / patches_.angles;
  const int per_angle = samples_over(cutter_.radius * angle_step);
  pieces_.clear();
  patch_start_.assign(1, 0);
  fronts_.clear();
  arms_.assign(engagement_.weights.size(), Vector3::Zero());
  std::fill(engagement_.weights.begin(), engagement_.weights.end(), 0.0);
  std::vector<std::pair<int, float>> patch;  // cells and weights
  struct Around {
    double sine, cosine;
  };
  std::vector<Around> around;  // of the samples of all patches of a slice
  for (int k = 0; k < patches_.angles * per_angle; ++k) {
    const double theta = (k + 0.5) / per_angle * angle_step;
    around.push_back({std::sin(theta), std::cos(theta)});
  }
  struct Height {
    double above_middle, radius, sin_kappa, cos_kappa;
  };
  std::vector<Height> heights;
  for (int slice = 0; slice < patches_.slices; ++slice) {
    Front used{rows_, -1, 0, 0};
    // Next to the tip of a ball a slice is much longer than it is high.
    const double low = slice * slice_height_, high = low + slice_height_;
    const int per_slice = samples_over(std::hypot(
        slice_height_, cutting::radius_at(cutter_, high) - cutting::radius_at(cutter_, low)));
    const double share = 1.0 / (per_slice * per_angle);
    heights.clear();
    for (int i = 0; i < per_slice; ++i) {
      const double z = (slice + (i + 0.5) / per_slice) * slice_height_;
      const double kappa = cutting::axial_position_angle(cutter_, z);
      heights.push_back(
          {z - middle_height_, cutting::radius_at(cutter_, z), std::sin(kappa), std::cos(kappa)});
    }
    for (int angle = 0; angle < patches_.angles; ++angle) {
      patch.clear();
      double front = 0.0, covered = 0.0, swept = 0.0;
      Vector3 arm = Vector3::Zero();
      for (const Height& at_z : heights) {
        const double r = at_z.radius, z = at_z.above_middle;
        for (int k = 0; k < per_angle; ++k) {
          const auto [sine, cosine] = around[static_cast<std::size_t>(angle * per_angle + k)];
          const double facing = at_z.sin_kappa * sine * cos_pitch_ + at_z.cos_kappa * sin_pitch_;
          if (facing <= 1e-12) continue;
          front += share;
          swept += facing;
          arm += (r * at_z.cos_kappa + z * at_z.sin_kappa) * Vector3(-cosine, sine, 0.0);
          const double a = r * cosine - lateral_origin_;
          const double b = r * sine * sin_pitch_ + z * cos_pitch_ - eta_origin_;
          const int column = std::clamp(static_cast<int>(std::floor(a)), 0, columns_ - 2);
          const int at = std::clamp(static_cast<int>(std::floor(b)), 0, rows_ - 2);
          for (int corner = 0; corner < 4; ++corner) {
            const int right = corner & 1, up = corner >> 1;
            const double weight = (right == 1 ? a - column : 1.0 - (a - column)) *
                                  (up == 1 ? b - at : 1.0 - (b - at));
            if (weight <= 0.0) continue;
            const int cell = (at + up) * stride_ + column + right;
            covered += weight * static_cast<double>(coverage_[static_cast<std::size_t>(cell)]);
            const auto same = std::find_if(patch.begin(), patch.end(),
                                           [&](const auto& entry) { return entry.first == cell; });
            if (same == patch.end())
              patch.emplace_back(cell, static_cast<float>(weight));
            else
              same->second += static_cast<float>(weight);
          }
        }
      }
      if (covered > 0.0) {
        arms_[patch_of(slice, angle)] = arm / swept;
        for (auto& [cell, weight] : patch) {
          weight *= static_cast<float>(front / covered);
          used.first_row = std::min(used.first_row, cell / stride_);
          used.last_row = std::max(used.last_row, cell / stride_);
        }
        add_pieces(patch);
        const std::size_t at = patch_start_.size() - 1;
        if (used.first_patch == used.end_patch) used.first_patch = at;
        used.end_patch = at + 1;
      }
      patch_start_.push_back(pieces_.size());
    }
    fronts_.push_back(used);
  }
}

void ShadowMap::add_pieces(std::vector<std::pair<int, float>>& cells) {
  std::sort(cells.begin(), cells.end());
  int end = -1;
  for (const auto& [cell, weight] : cells) {
    if (cell >= end) {
      pieces_.push_back({cell, {}});
      end = cell + kFour;
    }
    pieces_.back().weights[cell - pieces_.back().cell] = weight;
  }
}

const cutting::Engagement& ShadowMap::engagement() {
  for (const Front& front : fronts_) {
    double* weights = engagement_.weights.data();
    if (front.last_row < first_row_ || front.first_row > last_row_) {
      std::fill(weights + front.first_patch, weights + front.end_patch, 0.0);
      continue;
    }
    const auto sum = [&](std::size_t patch) {
      FourFloats weight = {};
      for (std::size_t at = patch_start_[patch]; at < patch_start_[patch + 1]; ++at)
        weight += load<FourFloats>(pieces_[at].weights) *
                  load<FourFloats>(cells_.data() + pieces_[at].cell);
      return weight;
    };
    std::size_t patch = front.first_patch;
    for (; patch + kFour <= front.end_patch; patch += kFour) {
      const FourFloats sums = sums_of(sum(patch), sum(patch + 1), sum(patch + 2), sum(patch + 3));
      for (int i = 0; i < kFour; ++i)
        weights[patch + static_cast<std::size_t>(i)] = static_cast<double>(sums[i]);
    }
    for (; patch < front.end_patch; ++patch)
      weights[patch] = static_cast<double>(sum_of(sum(patch)));
  }
  if (turn_T_.isZero(0.0)) return engagement_;
  for (int slice = 0; slice < patches_.slices; ++slice)
    for (int angle = 0; angle < patches_.angles; ++angle) {
      double& weight = engagement_.at(slice, angle);
      if (weight == 0.0) continue;
      const double share = 1.0 + turn_T_.dot(arms_[patch_of(slice, angle)]);
      weight = share > kLeastShare ? weight / share : 0.0;
    }
  return engagement_;
}

}  // namespace osteomill::workpiece
