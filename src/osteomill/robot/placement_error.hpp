// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "osteomill/robot/placement.hpp"

namespace osteomill::robot {

/// How far the robot stands from where it should, standard deviations.
struct PlacementErrors {
  double position = 0.002;                 ///< of A1 in the plane of the cuts, each direction, m
  double varus_valgus = 0.3 * units::deg;  ///< of the axis; [plaskos2006] Table 5.4: < 0.3° SD
  double internal_external = 0.3 * units::deg;  ///< of the axis
  double half_width = 0.035;  ///< of the bone, medial and lateral of the middle, m
  int samples = 2000;
  std::uint64_t seed = 1;
};

/// One sample: A1 is off by `shift`, and a tilted axis by `side` more on one side of the bone and
/// by −`side` on the other, m.
struct PlacementError {
  Vector2 shift;
  Vector2 side;
};
/// The samples; the i-th depends on the seed and i alone. Throws InvalidInput naming the field.
std::vector<PlacementError> draw_placement_errors(const PlacementErrors& errors);

/// What the errors do, over samples. A tilted axis pierces the medial and the lateral side of the
/// bone at other places: the gaps are taken there, on the worse side.
struct PlacementRisk {
  double share_forbidden = 0.0;   ///< of samples where a cut is out of reach or the guide hits bone
  double mean_gap = 0.0;          ///< largest gap, mean over the allowed samples, m
  double gap_95 = 0.0;            ///< and its 95th percentile, m
  int allowed = 0;                ///< samples behind the last two; 0: they were not computed
  PerCut<double> forbidden_by{};  ///< share of samples that each cut forbids
};
PlacementRisk placement_risk(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                             const Vector2& axis_position, const PlacementErrors& errors,
                             BranchRule rule = BranchRule::outermost);

}  // namespace osteomill::robot
