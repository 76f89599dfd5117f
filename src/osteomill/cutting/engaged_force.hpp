// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/engagement.hpp"
#include "osteomill/cutting/flutes.hpp"
#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::cutting {

/// Forces where the stock says what is cut (Engagement) rather than a nominal immersion.
///
/// What depends on the cutter and on the grid of the map only is worked out once; a mean is then
/// one pass over the patches in bone, and slices of equal profile (a cylinder) are passed as one.
/// The force is proportional to a patch's weight. Each patch stands for its middle: the error is of
/// second order in the patch. Circular tooth paths only.
class EngagedForce {
 public:
  EngagedForce(const Cutter& cutter, const CuttingLaw& law, int angles, int slices,
               double slice_height);

  /// Mean load over a revolution. The map must have the grid of the constructor.
  Load mean(const Engagement& engagement, const Condition& condition) const;

  /// Length of the edges of all flutes in bone, mean over a revolution, m, each patch counted by
  /// its weight: in bone that is not the reference divide by its force scale.
  double edge_in_bone(const Engagement& engagement) const;

  /// What the edges do on one patch of the map.
  struct PatchWork {
    double torque = 0.0;  ///< its part of the mean torque, N m
    double chip = 0.0;    ///< mean uncut chip thickness, m
  };
  /// One a patch, in the order of the map; the torques sum up to that of mean().
  std::vector<PatchWork> work(const Engagement& engagement, const Condition& condition) const;

  /// Instantaneous loads over a revolution.
  Revolution revolution(const Engagement& engagement, const Condition& condition,
                        int steps = 360) const;

 private:
  struct Strip {
    ProfilePoint point;  ///< at the middle of the strip's meridian
    double width = 0.0;  ///< of cut: length of meridian, m
    int slice = 0;       ///< of the map
    int row = 0;         ///< neighbours of one row have the same radius and kappa
    double sin_kappa = 0.0, cos_kappa = 1.0;
  };
  /// How far an edge lies behind the angle of the spindle.
  struct Behind {
    double angle = 0.0, sine = 0.0, cosine = 1.0;
  };
  void require_grid(const Engagement& engagement) const;

  Cutter cutter_;
  Flutes flutes_;
  CuttingLaw law_;
  int angles_;
  int slices_;
  double slice_height_;
  std::vector<Strip> strips_;
  std::vector<Behind> behind_;  ///< of each strip's flutes
  int rows_ = 0;
  std::vector<geometry::Vector3> motions_;  ///< one an angle
};

}  // namespace osteomill::cutting
