// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/workpiece/region.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::workpiece {

/// Height of the ridge that a ball leaves between passes on a flat surface:
///
///   h = R − sqrt(R² − (s/2)²)
///
/// plane geometry, 0 <= s <= 2R.
double scallop_height(double ball_radius, double step_over);
/// The step that leaves ridges of this height: s = 2 sqrt(2 R h − h²), 0 < h <= R.
double step_over_for(double ball_radius, double scallop);

/// A surface finished with a ball end in passes along x or y.
struct SurfacePasses {
  Region keep;               ///< what has to remain: the ball rolls on it, from above
  Vector2 lower, upper;      ///< of the area that is passed over, m
  double top = 0.0;          ///< from here the ball is let down, m
  double bottom = 0.0;       ///< the tip does not go below, m
  double ball_radius = 0.0;  ///< m
  double scallop = 20e-6;    ///< largest height of the ridges, m
  double allowance = 0.0;    ///< that stays on the surface, m
  bool along_y = false;
  double sample = 0.25e-3;   ///< spacing of points along a pass, m
  double clearance_z = 0.0;  ///< m
};

/// To-and-fro passes. Neighbouring ones are so near that both the centres of the ball and the
/// points where it touches are nowhere farther apart than step_over_for(): on curved surfaces one
/// of the two is the safe one (h = s²/8 (1/R ± 1/rho), rho the radius of the surface). Line n is
/// pass n.
ToolPath surface_passes(const SurfacePasses& surface, const CutSettings& cut);

}  // namespace osteomill::workpiece
