// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "osteomill/base/progress.hpp"
#include "osteomill/robot/placement.hpp"

namespace osteomill::robot {

/// Link lengths to compare. [plaskos2006] 4.4.1.5 and 4.4.2.3: 40 ≤ L1 ≤ 75, 5 ≤ L2 ≤ 40, by 1 mm.
struct SizeStudyOptions {
  double l1_low = 0.040;   ///< m
  double l1_high = 0.075;  ///< m
  double l2_low = 0.005;   ///< m
  double l2_high = 0.040;  ///< m
  double step = 0.001;     ///< m
  CutOptions cuts;
  BranchRule branch = BranchRule::outermost;
  double margin = 0.0;        ///< every placement stays allowed within this radius, m
  double slide_stroke = 0.0;  ///< of a sliding guide, m; 0: none
  bool refine = true;         ///< improve each best cell of the grid continuously
};

/// A choice of link lengths and what it gives.
struct LinkChoice {
  bool exists = false;    ///< false: no pair of lengths serves every implant
  double l1 = 0.0;        ///< m
  double l2 = 0.0;        ///< m
  double value = 0.0;     ///< what was minimised, m
  double slope_l1 = 0.0;  ///< its derivative, m/m; one-sided at a bound
  double slope_l2 = 0.0;
};

struct SizeStudy {
  std::vector<double> l1;  ///< m
  std::vector<double> l2;  ///< m
  /// Largest of the optimal largest gaps over the sizes of each family: [family][i1 * n2 + i2], m;
  /// empty where some size cannot be served.
  std::vector<std::vector<std::optional<double>>> per_family;
  std::vector<std::optional<double>> largest;  ///< over all families
  std::vector<std::optional<double>> mean;     ///< over the families
  std::vector<LinkChoice> best_per_family;
  LinkChoice best_largest;
  LinkChoice best_mean;
  /// With a slide: the shortest L1 (then L2) with every gap within the stroke; value: the stroke it
  /// needs.
  LinkChoice most_compact;
  bool stopped = false;  ///< asked to stop before the end; nothing is chosen then
  long placements = 0;
};

/// The largest of the optimal largest gaps over the sizes of a family; empty when one has no place.
std::optional<double> largest_over_sizes(const GuidePositioner& robot,
                                         const std::vector<PerCut<CutLine>>& sizes,
                                         const PlacementOptions& options);

/// Places the robot on every size of every family for every pair of lengths. Threads; the result
/// does not depend on their number.
SizeStudy study_sizes(const std::vector<ImplantFamily>& families, const SizeStudyOptions& options,
                      const Progress& progress = {});

}  // namespace osteomill::robot
