// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/engaged_force.hpp"
#include "osteomill/cutting/engagement.hpp"
#include "osteomill/thermal/heat_field.hpp"
#include "osteomill/thermal/heat_partition.hpp"
#include "osteomill/workpiece/stock.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::simulate {

struct BoneHeatOptions {
  double spacing = 0.4e-3;  ///< of the temperature field, m; rounded to whole voxels of the stock
  double margin = 3e-3;     ///< of bone around what the cutter reaches, m
  thermal::HeatOptions field;
  thermal::PartitionOptions partition;
};

/// Bone that is left and beyond a limit.
struct Damage {
  double volume = 0.0;  ///< m³
  double depth = 0.0;   ///< its largest distance from what was cut, m
};

/// What heat did to the bone; temperatures in K.
struct BoneHeatSummary {
  double hottest = 0.0;       ///< of any bone at any time, what was cut later included
  double hottest_left = 0.0;  ///< of the bone that is left, at any time
  double largest_dose = 0.0;  ///< of the bone that is left, equivalent minutes at 43 °C
  Damage by_dose;             ///< kBoneDamageCem43
  Damage by_47c_60s;          ///< the same by 47 °C for 60 s
  Damage by_50c_30s;          ///< and by 50 °C for 30 s
  double heat_in_bone = 0.0;  ///< put into bone, J
  double unplaced_heat =
      0.0;  ///< of patches with no bone left beside them, J: it goes with the chips
};

/// The temperature of a stock while it is milled, on cells of several voxels around the path.
///
/// Of the work on each patch of the cutter the bone's share, by the chip there
/// (thermal::shares_of_patch), goes into the bone just outside the patch: at the thin end of the
/// chip into the wall that remains, at its thick end into what the next teeth take along. A cell is
/// bone while half of it is.
class BoneHeat {
 public:
  BoneHeat(const workpiece::Stock& stock, const cutting::Cutter& cutter,
           const workpiece::ToolPath& path, const BoneHeatOptions& options);

  /// From now on hottest() is of bone that is in `left` too, the stock as the path will leave it:
  /// what is cut takes its heat along.
  void watch(const workpiece::Stock& left);

  /// One stretch of time in which the tip came to `tip_W`, with the tool frame's axes in W and what
  /// was done on each patch of the engagement's map, in its order.
  void advance(const workpiece::Stock& stock, const geometry::Vector3& tip_W,
               const Eigen::Matrix3d& R_WT, const cutting::Engagement& grid,
               std::span<const thermal::PatchCut> patches, double time);
  /// The same where nothing is cut.
  void rest(double time);

  const thermal::HeatField& field() const { return field_; }
  double hottest() const { return hottest_now_; }  ///< of the bone now, see watch(), K
  BoneHeatSummary summary() const;

  /// See base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(field_, peak_, dose_, above_47_, above_50_, cut_cells_, hottest_, hottest_now_,
      unplaced_heat_);
  }

 private:
  struct Patch {
    geometry::Vector3 p_T, n_T;
  };
  void take_away(const workpiece::Stock& stock, const geometry::Vector3& tip_W,
                 const geometry::Vector3& axis_W);
  using Cell = std::array<int, 3>;
  struct Heated {
    Cell cell{};
    double part = 0.0;  ///< of a patch's heat
  };
  Heated beside(const workpiece::Stock& stock, const geometry::Vector3& patch_W,
                const geometry::Vector3& n_W) const;
  void put_in(const workpiece::Stock& stock, const geometry::Vector3& tip_W,
              const Eigen::Matrix3d& R_WT, std::span<const thermal::PatchCut> patches);
  void make_patches(const cutting::Engagement& engagement);
  double share_of_bone(const workpiece::Stock& stock, int x, int y, int z) const;
  Damage beyond(const std::vector<float>& values, double limit) const;

  cutting::Cutter cutter_;
  BoneHeatOptions options_;
  int factor_ = 1;                    ///< voxels along a cell
  std::array<int, 3> first_voxel_{};  ///< of the stock, in cell (0, 0, 0)
  thermal::HeatField field_;
  std::vector<Patch> patches_;
  std::vector<float> peak_;                 ///< K
  std::vector<float> dose_;                 ///< minutes
  std::vector<char> stays_;                 ///< of each cell: it will not be cut; empty: not known
  std::vector<float> above_47_, above_50_;  ///< °C, s
  std::vector<std::array<int, 3>> cut_cells_;
  double hottest_ = 0.0;      ///< so far, of any bone, K
  double hottest_now_ = 0.0;  ///< see hottest()
  double unplaced_heat_ = 0.0;
};

/// What the edges do on each patch of an engagement's map in a time. `edge` is the same cutter with
/// the edge part of the law only, null where it has none.
std::vector<thermal::PatchCut> patch_cuts(const cutting::EngagedForce& whole,
                                          const cutting::EngagedForce* edge,
                                          const cutting::Cutter& cutter,
                                          const cutting::Engagement& engagement,
                                          const cutting::Condition& condition, double time);

/// Conduction in bone of an apparent density: k from 0.29 W/mK (cancellous, 400 kg/m³) to 0.55
/// (cortical, 1900 kg/m³) in a straight line; solid at 1300 J/kgK, the rest marrow with 2.2 MJ/m³K.
/// The two ends are from the literature, the line between them is assumed.
thermal::ThermalMaterial thermal_material(double density);

}  // namespace osteomill::simulate
