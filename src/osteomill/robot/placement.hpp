// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/robot/guide_positioner.hpp"
#include "osteomill/robot/implant.hpp"

namespace osteomill::robot {

/// Which of the two positions of A2 on a cut line is taken. [plaskos2006] 4.4.1.3 names both rules.
enum class BranchRule {
  outermost,  ///< always the one before the foot of the perpendicular: the published study
  nearest     ///< the one with the smaller gap that does not put the guide into the bone
};

/// Distance g = (s − X2)·c from the guide's tip to the entry of a cut, m; negative: in the bone.
///   g = ± √(L1² − n²) − u − L2,  u, n: along and off the line, of A1 from the entry
/// [plaskos2006] eq. 2.2, 2.3, 2.5 with |d| taken with its sign. Empty outside the workspace (2.4).
std::optional<double> gap(const GuidePositioner& robot, const Vector2& axis_position,
                          const CutLine& line, Branch branch = Branch::outermost);

/// Derivative of the gap with respect to the position of A1, m/m; only inside the workspace.
Vector2 gap_gradient(const GuidePositioner& robot, const Vector2& axis_position,
                     const CutLine& line, Branch branch = Branch::outermost);

/// All five gaps at one position.
struct GapReport {
  bool allowed = false;            ///< every cut within the workspace, no guide in the bone
  double largest_gap = 0.0;        ///< m; only when allowed
  Cut limiting_cut = Cut::distal;  ///< the cut of the largest gap, or the one that forbids
  PerCut<std::optional<double>> gaps;
  PerCut<Branch> branches = {};
};
GapReport gaps_at(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                  const Vector2& axis_position, BranchRule rule = BranchRule::outermost);

struct PlacementOptions {
  BranchRule branch = BranchRule::outermost;
  double margin = 0.0;  ///< the position stays allowed when A1 is off by this in any direction, m
  double precision = 1e-7;    ///< the certificate: no allowed position is better by more, m
  int max_boxes = 2'000'000;  ///< gives up (converged = false) after so many
};

/// The position of A1 with the smallest largest gap, and the proof that it is the global one.
struct Placement {
  bool feasible = false;
  bool converged = false;  ///< the search closed the gap between bound and solution
  std::string reason;      ///< when infeasible or not converged: why, and what would help

  Vector2 axis_position = Vector2::Zero();  ///< X0 in the frame of the profile, m
  double largest_gap = 0.0;                 ///< m
  double lower_bound = 0.0;                 ///< no allowed position has a largest gap below this, m
  PerCut<double> gaps = {};                 ///< m
  PerCut<Branch> branches = {};
  Vector2 gradient = Vector2::Zero();  ///< of the limiting cut's gap, m/m
  Cut limiting_cut = Cut::distal;      ///< largest gap; when infeasible: the cut that fails
  std::vector<Cut> touching;           ///< cuts whose guide touches the bone (gap about zero)
  double required_stroke = 0.0;        ///< slide travel that closes every gap, m: the largest gap
  double residual_gap = 0.0;           ///< largest gap left with the slide fully out, m
  int boxes = 0;                       ///< visited by the search
};

/// Minimises the largest gap over the five cuts over X0. [plaskos2006] 4.4.1.4.
///
/// Branch and bound on boxes of X0. The outermost gap is a concave function of X0, so that its
/// tangent plane bounds it from above and its corners bound it from below on a box; boxes where a
/// cut surely fails, or whose bound is no better than the best position found, are dropped. What is
/// left when the boxes' bounds meet the best position is the global optimum to `precision`.
Placement place(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                const PlacementOptions& options = {});

/// Largest gap on a grid of positions, for contour maps. [plaskos2006] fig. 4.10.
struct GapMap {
  std::vector<double> x;                       ///< m
  std::vector<double> y;                       ///< m
  std::vector<std::optional<double>> largest;  ///< m, row by row of y; empty where not allowed
};
GapMap gap_map(const GuidePositioner& robot, const PerCut<CutLine>& lines, const Vector2& low,
               const Vector2& high, double step, BranchRule rule = BranchRule::outermost);

/// How far A1 may be off its place in any direction.
struct PlacementTolerance {
  double to_forbidden = 0.0;  ///< before a cut leaves the workspace or the guide hits bone, m
  double worst_gap = 0.0;     ///< largest gap within that error circle of the given radius, m
};

/// Radius of the largest circle around the position in which every position is allowed (outermost
/// branch), and the largest gap within `radius` (at most to_forbidden is used).
PlacementTolerance placement_tolerance(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                                       const Vector2& axis_position, double radius);

/// The position that may be off the farthest in any direction: centre and radius of the largest
/// circle of allowed positions, the middle of the safe zone of [plaskos2006] 4.4.3.
struct SafeZone {
  bool exists = false;
  Vector2 centre = Vector2::Zero();
  double radius = 0.0;       ///< m
  double largest_gap = 0.0;  ///< at the centre, m
};
SafeZone safe_zone(const GuidePositioner& robot, const PerCut<CutLine>& lines,
                   double precision = 1e-6);

}  // namespace osteomill::robot
