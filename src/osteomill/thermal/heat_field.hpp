// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "osteomill/base/large_vector.hpp"
#include "osteomill/geometry/voxel_grid.hpp"
#include "osteomill/thermal/analytic_heat.hpp"

namespace osteomill::thermal {

struct HeatOptions {
  double initial_temperature = 310.15;  ///< of the bone, K
  /// Of air or irrigation at every face of bone that is open, W/(m² K): still air about 10, a drip
  /// 100 to 1000, a jet 1000 to 10 000 (orders of magnitude).
  double convection = 10.0;
  double coolant_temperature = 295.15;  ///< K
  /// Heat that blood carries off a volume of bone, W/(m³ K), towards `blood_temperature`.
  double perfusion = 0.0;
  double blood_temperature = 310.15;  ///< K
};

/// The temperature in a bone on voxels while it is being cut.
///
/// Conduction by locally one-dimensional backward Euler: implicit along x, then y, then z, the
/// other way round in the next step. Every sweep is a balance of voxels through faces, so energy is
/// conserved to rounding, and no step, however long, leaves the range of the temperatures
/// before it. First order in the step, second in the spacing. The conductance of a face is that of
/// the two halves in series; a face between bone and air has half a voxel and the convection in
/// series. The outer faces of the grid are insulated.
class HeatField {
 public:
  /// `material` of each voxel; heat_capacity 0 where there is none.
  HeatField(const geometry::GridShape& shape,
            const std::function<ThermalMaterial(int x, int y, int z)>& material,
            const HeatOptions& options);

  /// Puts heat (J) into a voxel at once. Nothing where there is no bone; returns whether there was.
  bool add_heat(int x, int y, int z, double heat);
  /// The voxel is cut away and takes its heat along.
  void remove(int x, int y, int z);
  /// Lets the heat flow for a time, s. The result does not depend on the number of threads.
  void advance(double time);

  bool is_bone(int x, int y, int z) const { return capacity_[shape_.index(x, y, z)] > 0.0f; }
  /// K; the coolant's where there is no bone.
  double temperature(int x, int y, int z) const;
  /// Of all bone above its initial temperature, J.
  double energy() const;
  double hottest() const;  ///< K, of the bone that is left

  // Since the start, J: put in; taken away with cut voxels; the rest, carried off by convection and
  // blood.
  double added_energy() const { return added_; }
  double cut_energy() const { return cut_; }
  double carried_energy() const { return added_ - cut_ - energy(); }

  const geometry::GridShape& shape() const { return shape_; }

  /// What time and cutting change; see base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(rise_, capacity_, conductivity_, added_, cut_, backwards_);
    for (int axis = 0; axis < 3; ++axis) a(conductance_[axis], open_[axis]);
  }

 private:
  void update_faces(int x, int y, int z);
  void sweep(int axis, double time);
  template <int lanes>
  void solve(std::size_t start, std::size_t lane_stride, std::size_t stride, int length, int axis,
             float time, std::vector<float>& work);

  geometry::GridShape shape_;
  HeatOptions options_;
  LargeVector<double> rise_;         ///< above the initial temperature, K
  LargeVector<float> capacity_;      ///< J/K of a voxel; 0: no bone
  LargeVector<float> conductivity_;  ///< W/(m K)
  /// By axis: conductance to the next voxel, W/K; 0 where there is none or no bone.
  LargeVector<float> conductance_[3];
  /// By axis: conductance of the voxel's open faces to the coolant, W/K.
  LargeVector<float> open_[3];
  double coolant_rise_ = 0.0, blood_rise_ = 0.0;
  double added_ = 0.0, cut_ = 0.0;
  bool backwards_ = false;
};

}  // namespace osteomill::thermal
