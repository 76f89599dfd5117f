// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/robot/placement.hpp"

/// The searches behind placement.hpp; include that.
///
/// A2 may stand anywhere on a cut line from s − L2 c outward: a ray. A1 is allowed when it is
/// within L1 of all five rays; that is [plaskos2006] eq. 2.4 and 2.5 together. Each ray widened by
/// L1 is convex, so the allowed positions are, and an error circle of radius r around A1 fits where
/// A1 is within L1 − r of every ray.
namespace osteomill::robot {

/// L1 minus the distance of a position from the ray of a cut, m; negative where it is forbidden.
double cut_depth(const GuidePositioner& robot, const Vector2& position, const CutLine& line);

/// The position whose smallest depth over the cuts is largest.
struct DeepestPoint {
  Vector2 position = Vector2::Zero();
  double depth = 0.0;  ///< within the precision, m
};
DeepestPoint deepest_point(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                           double precision);

struct SearchResult {
  bool found = false;
  bool converged = false;
  Vector2 position = Vector2::Zero();
  double value = 0.0;
  double lower_bound = 0.0;
  int boxes = 0;
};
SearchResult search_placement(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                              const PlacementOptions& options);

}  // namespace osteomill::robot
