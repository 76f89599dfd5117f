// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::workpiece {

/// The technique of the milling guide of [plaskos2006] 5.5.1: the tool turns about and slides
/// through a fixed entry point in the cutting plane. It is swung from side to side at one depth of
/// insertion, advanced by one groove of the guide (the length of the cutter there), swung again.
struct Swing {
  Vector3 pivot_W = Vector3::Zero();     ///< the fixed entry point
  Vector3 normal_W = Vector3::UnitZ();   ///< of the cutting plane
  Vector3 forward_W = Vector3::UnitX();  ///< direction of insertion at angle 0, in the plane
  double first_angle = -0.5;             ///< about the normal, rad
  double last_angle = 0.5;               ///< rad
  double first_insertion = 20e-3;        ///< of the tip beyond the pivot, m
  double last_insertion = 60e-3;         ///< m
  double advance = 10e-3;                ///< from swing to swing, m
  /// Each swing there and back before the tool is advanced: rough down, finish up, as 3.5.5 of the
  /// source advises. Otherwise the tool advances at the end of each swing.
  bool there_and_back = true;
  double chord_error = 5e-6;  ///< of the arcs, m
};

/// Line n is swing n. Feed is that of the tip; the axis goes with every point, and lies in the
/// plane. The first swing is reached by sliding in at the first angle.
ToolPath swing_and_advance(const Swing& swing, const CutSettings& cut);

}  // namespace osteomill::workpiece
