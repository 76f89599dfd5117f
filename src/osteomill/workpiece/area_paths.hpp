// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/workpiece/outline.hpp"
#include "osteomill/workpiece/passes.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::workpiece {

/// Levels of the tip from one height down to another, each at most `step` below the last, equally
/// apart; the first is one step below `top`. Throws InvalidInput.
std::vector<double> levels(double top, double bottom, double step);

/// An area that is taken off level by level.
struct AreaCut {
  Outline outline;             ///< where the tool's axis may be
  std::vector<double> levels;  ///< of the tip, downwards, m
  /// The same for each level, where they differ: what lies below the tip is in nobody's way.
  std::vector<Outline> outline_at = {};
  double step_over = 1e-3;   ///< between neighbouring passes, m
  double clearance_z = 0.0;  ///< height of the ways between passes, m
  Milling milling = Milling::down;
};

/// Straight passes side by side that end at the outline's border. The tool is lifted between them,
/// but for to-and-fro passes where the way to the next stays within the outline. Line n is pass n.
struct Raster {
  double direction = 0.0;  ///< of the passes from x, rad
  bool to_and_fro = true;  ///< or all in the direction that `milling` asks for
};
ToolPath raster(const AreaCut& area, const Raster& how, const CutSettings& cut);

/// Passes along the outline and along its parallels within it, `step_over` apart, from the border
/// to the middle or from the middle to the border; each runs so that the bone which is left is on
/// the side of `milling`. Line n is ring n.
ToolPath contour_parallel(const AreaCut& area, bool from_outside, const CutSettings& cut);

/// A slot wider than the cutter: circles of `slot_width / 2 - radius` around a centre that goes
/// along the line by `advance` a turn, so that the bone that is met is `advance` thick at most:
///
///   p(t) = start + (t advance / 2 pi) u + r (cos t u + sin t v),  v = z × u,  r = W/2 - R
///
/// Counter-clockwise circles meet the bone in front down-milling, with the clockwise spindle.
struct Trochoid {
  Vector3 start_W = Vector3::Zero();
  Vector3 along_W = Vector3::UnitX() * 10e-3;  ///< direction and length, level, m
  double slot_width = 0.0;                     ///< m
  double cutter_radius = 0.0;                  ///< m
  double advance = 0.5e-3;                     ///< a turn, m
  std::vector<double> levels;                  ///< of the tip, m
  double clearance_z = 0.0;                    ///< m
  Milling milling = Milling::down;
  double chord_error = 5e-6;  ///< m
};
ToolPath trochoidal_slot(const Trochoid& slot, const CutSettings& cut);

}  // namespace osteomill::workpiece
