// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "osteomill/workpiece/swath.hpp"
#include "osteomill/workpiece/tool_pose.hpp"

namespace osteomill::workpiece {

/// What Swath is, for a tool axis of any direction that may turn during the step. Lengths in
/// voxels.
///
/// Seen from the tool a point moves past it: from q0 = R0 (p - tip0) to q1 = R1 (p - tip1). Where
/// the axis does not turn that is a straight line; where it does the line between q0 and q1 stands
/// for it, which is off by at most (a² reach + 2 a travel)/8, a the turn in rad and `reach` the
/// distance of the farthest voxel of the grid that the tool meets: see pieces(). The occupancy left
/// is clamp(1/2 + d), d the least distance of the cutter (Meridian) to that line: both ends are
/// exact, so a path in pieces leaves the same stock within that bound.
///
/// In a row of voxels the stretch that the cutter comes near to and the one that it has taken
/// already are worked out for balls and cylinders, and the distances of several voxels at once
/// (layer_kernel.hpp); for other outlines, rows are walked with steps as long as the distances
/// allow (a distance changes by no more than the way). Voxels from which the cutter's surface goes
/// away are left out.
class PoseSwath {
 public:
  using Run = Swath::Run;

  /// Both must outlive it.
  PoseSwath(const Meridian& cutter_in_voxels, const geometry::GridShape& shape)
      : cutter_(cutter_in_voxels), shape_(shape) {}

  /// In how many pieces a step has to be done for the swept surface to be right within kError, and
  /// for each piece to be short against the cutter.
  int pieces(const ToolPose& from, const ToolPose& to) const;
  static constexpr double kError = 1e-3;  ///< voxels

  /// A step of a cutter that has already taken all it can at `from`.
  void begin_step(const ToolPose& from, const ToolPose& to);
  /// The cutter put down at a place where it has not been.
  void begin_placing(const ToolPose& pose);

  int first_layer() const { return first_layer_; }
  bool reaches(int z) const { return z <= last_layer_; }
  /// Lists the runs of a layer. See Swath.
  bool list(int z, std::span<const std::int64_t> row_units);
  std::span<const Run> runs() const { return runs_; }
  const Stock::Occupancy* fresh() const { return fresh_.data(); }
  std::size_t fresh_size() const { return fresh_.size(); }

  /// Signed distance of a point to what the step sweeps: the reference of the walk.
  double distance(const Vector3& p) const;

 private:
  /// Rows: two directions across the axis, and the axis.
  using Frame = Eigen::Matrix3d;
  void begin(const ToolPose& from, const ToolPose& to);
  double above_tip(const ToolPose& pose) const;
  double at(const Vector3& q) const;
  bool recedes(const Vector3& q, const Vector3& way) const;
  double nearest(const Vector3& q0, const Vector3& q1, double first, double last) const;
  struct Voxel {
    Stock::Occupancy fresh = Swath::kNothing;
    int alike = 1;  ///< so many voxels of the row have nothing new
  };
  Voxel look(const Vector3& q0, const Vector3& q1) const;
  void walk(int y, int z, int first, int last);
  kernel::View view(const Frame& frame, const Vector3& tip, int z) const;
  void list_rows(int z, int first_y, int last_y, std::span<const std::int64_t> row_units);

  const Meridian& cutter_;
  const geometry::GridShape& shape_;
  bool placing_ = false;
  ToolPose from_, to_, middle_;
  Frame from_frame_ = Frame::Identity(), to_frame_ = Frame::Identity();
  Frame middle_frame_ = Frame::Identity();
  double height_ = 0.0;        ///< of the part of the tool that can meet the grid
  double reach_ = 0.0;         ///< around the axis of `middle_`: radius, rim and half the way
  double upright_from_ = 0.0;  ///< height from which the wall is nearest
  bool turns_ = false;         ///< the axis does
  bool level_ = false;         ///< the tool goes across its axis, which doesn't turn
  int first_layer_ = 0, last_layer_ = -1;
  std::vector<int> stretches_;  ///< four arrays, see kernel::Stretches
  std::vector<Run> runs_;
  std::vector<Stock::Occupancy> fresh_;
};

}  // namespace osteomill::workpiece
