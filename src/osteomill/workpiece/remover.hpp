// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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
  /// there, m³. It is gone from the stock but in none of the values above.
  double buried_volume = 0.0;
  bool contact() const { return volume > 0.0; }
};

struct RemoverOptions {
  PatchGrid patches;    ///< default: patches_for(cutter, spacing)
  double memory = 1.0;  ///< travel over which engagement is averaged, voxels; see ShadowMap
};

/// Takes bone out of a stock with one cutter, step by step, tool axis = +z of W.
///
/// New occupancy = min(old, clamp(1/2 - d/spacing)), d the distance to the swept volume (see
/// SweptTool). A step that starts where the last one ended looks only at voxels in front of the
/// cutter and not yet inside it; the cost follows what is newly touched. No allocation in a step.
/// The whole stock above the tip is cut, the shank at full radius included.
class Remover {
 public:
  /// Throws InvalidInput when the cutter is not one. The stock must outlive the remover.
  Remover(Stock& stock, const cutting::Cutter& cutter, const RemoverOptions& options = {});
  Remover(const Remover&) = delete;  // its swath looks at its meridian
  Remover& operator=(const Remover&) = delete;

  /// Moves the tip straight from one point to the other. When `from` isn't where the last step
  /// ended, the engagement starts anew and bone around `from` counts as buried.
  Removal step(const Vector3& from_W, const Vector3& to_W);

  /// Contact of the cutter's envelope with bone after the last step, in the tool frame whose x-axis
  /// is x_T_W(): share of each patch × force scale. Valid until the next call.
  const cutting::Engagement& engagement() { return map_.engagement(); }
  const Vector3& x_T_W() const { return map_.x_T(); }

  /// What steps change but for the stock; see base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(map_, placed_, tip_);
  }

 private:
  struct Totals {
    std::int64_t units = 0;
    double unit_density = 0.0;  ///< units × kg/m³
    double unit_scale = 0.0;    ///< units × force scale
  };

  template <class Map>
  void carve(Map&& map, Totals& totals);
  template <bool one_material, class Map>
  void carve_layer(int z, Map& map, Totals& totals);

  Stock& stock_;
  Meridian meridian_;  // in voxels
  Swath swath_;
  ShadowMap map_;
  bool placed_ = false;
  Vector3 tip_ = Vector3::Zero();  // where the last step ended, voxels
};

}  // namespace osteomill::workpiece
