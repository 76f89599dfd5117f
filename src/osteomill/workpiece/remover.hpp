// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/workpiece/pose_swath.hpp"
#include "osteomill/workpiece/shadow_map.hpp"
#include "osteomill/workpiece/stock.hpp"
#include "osteomill/workpiece/swath.hpp"

namespace osteomill::workpiece {

/// What one step took.
struct Removal {
  double volume = 0.0;         ///< m³
  double mass = 0.0;           ///< kg
  double scaled_volume = 0.0;  ///< volume × force scale, m³: what the engagement is made of
  /// Volume that was inside the cutter before the step, because the path starts there or jumped
  /// there, or that a turn in place met, m³. It is gone from the stock but in none of the values
  /// above.
  double buried_volume = 0.0;
  bool contact() const { return volume > 0.0; }
};

struct RemoverOptions {
  PatchGrid patches;    ///< default: patches_for(cutter, spacing)
  double memory = 1.0;  ///< travel over which engagement is averaged, voxels; see ShadowMap
};

/// Takes bone out of a stock with one cutter, step by step; the tool's axis may have any direction
/// and turn in a step. Steps with the axis along +z of W go a shorter way (Swath), the others
/// (PoseSwath) are done in pieces where they turn much, so that surfaces stay right within a
/// thousandth of a voxel.
///
/// New occupancy = min(old, clamp(1/2 - d/spacing)), d the distance to the swept volume (see
/// SweptTool). A step that starts where the last one ended looks only at voxels in front of the
/// cutter and not yet inside it; the cost follows what is newly touched. No allocation in a step.
/// The whole stock along the axis is cut, the shank at full radius included.
class Remover {
 public:
  /// Throws InvalidInput when the cutter is not one. The stock must outlive the remover.
  Remover(Stock& stock, const cutting::Cutter& cutter, const RemoverOptions& options = {});
  Remover(const Remover&) = delete;  // its swaths look at its meridian
  Remover& operator=(const Remover&) = delete;

  /// Moves the tip straight from one pose to the other while the axis turns evenly (between()).
  /// When `from` isn't where the last step ended, the engagement starts anew and bone around `from`
  /// counts as buried. The axes must not be opposite.
  Removal step(const ToolPose& from, const ToolPose& to);
  /// The same with the axis along +z of W.
  Removal step(const Vector3& from_W, const Vector3& to_W) {
    return step(ToolPose{from_W, Vector3::UnitZ()}, ToolPose{to_W, Vector3::UnitZ()});
  }

  /// Contact of the cutter's envelope with bone after the last step, in the tool frame T: share of
  /// each patch × force scale. Valid until the next call.
  const cutting::Engagement& engagement() { return map_.engagement(); }
  /// Axes of T in W at the last step, columns x (the feed across the axis), y, z (the axis).
  Eigen::Matrix3d R_WT() const;
  /// How the tool moved in the last step: the feed is that of the tool's middle (see ShadowMap),
  /// `share` of the tip's way (0 where that stood still), and the tool turned about it.
  struct Motion {
    double share = 1.0;
    double elevation = 0.0;            ///< of the feed over the plane across the axis, rad
    Vector3 turn_T = Vector3::Zero();  ///< for a unit of the middle's way, rad/m
    double height = 0.0;               ///< of the middle above the tip, m
  };
  Motion motion() const;

  /// What steps change but for the stock; see base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(map_, placed_, pose_, middle_share_);
  }

 private:
  struct Totals {
    std::int64_t units = 0;
    double unit_density = 0.0;  ///< units × kg/m³
    double unit_scale = 0.0;    ///< units × force scale
  };

  template <class Source, class Map>
  void carve(Source& source, Map&& map, Totals& totals);
  template <class Source>
  bool take_layer(const Source& source, int z, bool is_new, Totals& totals);
  kernel::Amounts amounts() {
    return {voxel_amounts_.data(), run_amounts_.data(), run_units_.data()};
  }
  Totals place(const ToolPose& pose);
  void move(const ToolPose& from, const ToolPose& to, Totals& cut, Totals& buried);

  Stock& stock_;
  Meridian meridian_;  // in voxels
  Swath swath_;
  PoseSwath pose_swath_;
  ShadowMap map_;
  std::vector<double> densities_, force_scales_;  // of the stock's palette
  bool placed_ = false;
  ToolPose pose_;  // where the last step ended, voxels
  double middle_share_ = 1.0;
  // Of the layer that is carved, see kernel::Amounts.
  std::vector<float> voxel_amounts_, run_amounts_;
  std::vector<std::uint32_t> run_units_;
  FourShadows four_shadows_, four_eta_shadows_;
  std::vector<float> line_;  // see LevelMap
};

}  // namespace osteomill::workpiece
