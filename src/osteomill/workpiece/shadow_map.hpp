// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/engagement.hpp"
#include "osteomill/geometry/pose.hpp"
#include "osteomill/workpiece/meridian.hpp"
#include "osteomill/workpiece/voxel_shadow.hpp"

namespace osteomill::workpiece {

using geometry::Vector3;

/// The patches on the cutter's envelope that an Engagement is wanted on.
struct PatchGrid {
  int slices = 0;
  int angles = 0;
  double slice_height = 0.0;  ///< m
};

/// Patches about one voxel wide over the whole cutting length: at most 64 slices, 48 to 360 angles,
/// a multiple of 4.
PatchGrid patches_for(const cutting::Cutter& cutter, double spacing);

/// Where bone was removed, seen along the feed.
///
/// Every point of a convex cutter's front (outward normal · feed > 0) projects along the feed to
/// one point of the plane normal to it, and a cell of that plane with bone in front of all of it
/// loses (cell area × feed) in a step, whatever the inclination of the envelope behind it. So
/// removed volume over (area × feed) is a well-conditioned measure of contact everywhere, which
/// bins over the angle of rotation are not: there the volume per bin vanishes at the sides.
///
/// All lengths here are in voxels. Cells are one voxel wide; the plane's axes are y_T, lateral, and
/// eta = x_T sin a + z_T cos a, where the feed points by the angle a towards the tip from across
/// the tool's axis z_T; its origin moves with the tool's middle: the centre of a
/// ball, whose turn then changes nothing, the tip otherwise. Each removed voxel is shared between
/// its neighbouring cells as its shadow is (VoxelShadow); cells sit on the layers of voxels where
/// the feed is along them. So the profile is blurred by about a voxel, also across its rim; what a
/// fully engaged cutter would give is blurred in the same way
/// (`coverage`) and the engagement is the ratio of the two. Nothing is clamped: single weights may
/// pass 1 by the sampling noise.
///
/// The map forgets exponentially over `memory` of travel, by default one voxel: much shorter steps
/// meet voxels one at a time. What it delivers is therefore late by that length; its integral over
/// the path is not changed.
///
/// Where the tool turns while it moves, a patch at p from the middle moves by f + turn × p for a
/// unit of the middle's way and sweeps that share more or less: its weight is divided by n·(f +
/// turn × p) / n·f, so that it is the share of the patch in contact there too. Patches that the
/// turn moves out of the bone get none.
class ShadowMap {
 public:
  ShadowMap(const cutting::Cutter& cutter, double spacing, const PatchGrid& patches, double memory);

  /// How a step goes, in voxels.
  struct Step {
    Vector3 feed;         ///< of the middle, unit vector
    Vector3 middle;       ///< at its start
    Vector3 axis;         ///< of the tool, unit
    Vector3 turn;         ///< of the tool for a unit of the middle's way, rad
    double length = 0.0;  ///< of the middle's way
    double unit = 0.0;    ///< the volume that the step counts in
  };
  /// Turns the map to the step's feed and lets it forget. A turn of the feed by more than 20°
  /// empties it.
  void begin_step(const Step& step);
  void clear();

  /// Direction across the tool's axis that the tool frame's x-axis has, the lateral axis, and the
  /// tool's axis.
  const Vector3& x_T() const { return x_T_; }
  const Vector3& y_T() const { return y_T_; }
  const Vector3& z_T() const { return z_T_; }
  /// Of the tool for a unit of the middle's way, in the tool frame, rad per voxel.
  const Vector3& turn_T() const { return turn_T_; }
  const Vector3& eta() const { return eta_; }
  const Vector3& feed() const { return feed_; }

  /// Height of the middle above the tip.
  double middle_height() const { return middle_height_; }
  /// Cell coordinates of a point relative to the middle.
  double lateral_cell(const Vector3& p) const { return y_T_.dot(p) - lateral_origin_; }
  double eta_cell(const Vector3& p) const { return eta_.dot(p) - eta_origin_; }
  /// How a voxel is shared along the two axes.
  const VoxelShadow& lateral_shadow() const { return lateral_shadow_; }
  const VoxelShadow& eta_shadow() const { return eta_shadow_; }
  int rows() const { return rows_; }
  /// What a unit of removed volume adds to a cell in this step.
  float gain() const { return gain_; }
  /// Cells from one row to the next: enough after the last column for whole lanes (lanes.hpp).
  int stride() const { return stride_; }
  float* row(int at) { return cells_.data() + static_cast<std::ptrdiff_t>(at) * stride_; }
  void note_row(int at) {
    first_row_ = at < first_row_ ? at : first_row_;
    last_row_ = at > last_row_ ? at : last_row_;
  }

  /// Samples the map at the patches. Valid until the next call.
  const cutting::Engagement& engagement();

  /// See base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(columns_, rows_, stride_, cells_, coverage_, first_row_, last_row_, laid_out_, feed_, x_T_,
      y_T_, z_T_, turn_T_, eta_, sin_pitch_, cos_pitch_, lateral_origin_, eta_origin_,
      lateral_shadow_, eta_shadow_, shadow_y_, shadow_eta_, gain_, patch_start_, pieces_, fronts_,
      arms_);
  }

 private:
  void lay_out(double sin_pitch, double cos_pitch, const Vector3& tip);
  void move_cells(int right, int up);
  void compute_coverage();
  void compute_stencil();
  std::size_t patch_of(int slice, int angle) const {
    return static_cast<std::size_t>(slice) * static_cast<std::size_t>(patches_.angles) +
           static_cast<std::size_t>(angle);
  }

  cutting::Cutter cutter_;  // in voxels
  Meridian meridian_;       // in voxels
  PatchGrid patches_;
  double memory_;
  double middle_height_;
  double slice_height_;  // in voxels
  int columns_ = 0, rows_ = 0, stride_ = 0;
  std::vector<float> cells_, coverage_;
  int first_row_ = 0, last_row_ = -1;  // of what isn't empty

  bool laid_out_ = false;
  Vector3 feed_ = Vector3::Zero(), x_T_ = Vector3::UnitX(), y_T_ = Vector3::UnitY(),
          z_T_ = Vector3::UnitZ(), eta_ = Vector3::UnitZ();
  Vector3 turn_T_ = Vector3::Zero();
  double sin_pitch_ = 0.0, cos_pitch_ = 1.0;  // of the layout; pitch > 0 down
  double lateral_origin_ = 0.0, eta_origin_ = 0.0;
  VoxelShadow lateral_shadow_, eta_shadow_;
  // What the shadows were worked out for.
  Vector3 shadow_y_ = Vector3::Zero(), shadow_eta_ = Vector3::Zero();
  float gain_ = 0.0f;

  /// Of a patch's weights: four cells side by side.
  struct Piece {
    int cell;
    float weights[4];
  };
  void add_pieces(std::vector<std::pair<int, float>>& cells);
  std::vector<std::size_t> patch_start_;  // into pieces_, one more than patches
  std::vector<Piece> pieces_;
  /// Of a slice: the rows of cells that its patches look at, and the patches that look at any.
  struct Front {
    int first_row, last_row;
    std::size_t first_patch, end_patch;
  };
  std::vector<Front> fronts_;
  /// Of a patch: what it sweeps is 1 + turn · arm of what it would without the turn; the sum of
  /// p × n over its front divided by that of n · feed.
  std::vector<Vector3> arms_;
  cutting::Engagement engagement_;
};

}  // namespace osteomill::workpiece
