// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "osteomill/workpiece/layer_kernel.hpp"
#include "osteomill/workpiece/stock.hpp"
#include "osteomill/workpiece/swept_tool.hpp"

namespace osteomill::workpiece {

/// Which voxels a step can newly touch, layer by layer, and the occupancy that it leaves in them:
/// clamp(1/2 + d), d the distance to the swept volume (SweptTool). All lengths in voxels: voxel (x,
/// y, z) has its centre at (x, y, z).
///
/// Only what is in front of the cutter at the start and not yet inside it is listed. Where layers
/// have the same section (the side of a cylinder, the shank of a ball) they share one list. Lists
/// keep their memory from step to step.
class Swath {
 public:
  /// The fresh occupancy of a voxel that is left alone.
  static constexpr Stock::Occupancy kNothing = 0xffff;

  /// Neighbouring voxels of one row. Fresh occupancies go by whole lanes of eight voxels.
  using Run = kernel::Run;

  /// Both must outlive it.
  Swath(const Meridian& cutter_in_voxels, const geometry::GridShape& shape)
      : cutter_(cutter_in_voxels),
        shape_(shape),
        swept_(cutter_, Vector3::Zero(), Vector3::Zero()) {}

  /// A step of a cutter that has already taken all it can at `from`.
  void begin_step(const Vector3& from, const Vector3& to);
  /// The cutter put down at a place where it has not been.
  void begin_placing(const Vector3& tip);

  int first_layer() const;
  /// False from the layer on above which the step meets nothing new.
  bool reaches(int z) const;
  /// Lists the runs of a layer. `row_units` says how much bone each eight rows have, those without
  /// may be left out. False when the list is that of the last layer.
  bool list(int z, std::span<const std::int64_t> row_units);
  std::span<const Run> runs() const { return {runs_.data(), run_count_}; }
  const Stock::Occupancy* fresh() const { return fresh_.data(); }
  std::size_t fresh_size() const { return fresh_size_; }

 private:
  void begin(const Vector3& from, const Vector3& to);
  void begin_rows();
  bool upright(int z) const { return rise_ == 0.0 || z >= upright_from_; }
  void add_run(int row, int part);
  void fill(int z);

  const Meridian& cutter_;
  const geometry::GridShape& shape_;
  SweptTool swept_;
  Vector3 from_ = Vector3::Zero(), to_ = Vector3::Zero();
  double run_ = 0.0, rise_ = 0.0, hx_ = 1.0, hy_ = 0.0;
  double lowest_ = 0.0, upright_from_ = 0.0;
  bool placing_ = false;
  // Of the rows that the step can meet, whatever the layer.
  int first_y_ = 0, last_y_ = -1;
  std::vector<double> rows_;    ///< seven arrays, see kernel::Rows
  std::vector<int> stretches_;  ///< six arrays, see kernel::Stretches
  kernel::Rows row_arrays_{};
  kernel::Stretches stretch_arrays_{};
  // Of the layer that is listed.
  bool listed_ = false, whole_ = false;  ///< whole: no row was left out
  double height_ = 0.0;                  ///< above the tip; of an upright section any large one
  std::vector<Run> runs_;                ///< in use: run_count_
  std::size_t run_count_ = 0;
  std::vector<Stock::Occupancy> fresh_;  ///< in use: fresh_size_
  std::size_t fresh_size_ = 0;
};

}  // namespace osteomill::workpiece
