// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::io {

struct GcodeOptions {
  double chord_error = 5e-6;           ///< of arcs, m
  std::string file_name = "path.ngc";  ///< for the place of a fault: "path.ngc:12"
};

/// The tool path of a G-code program of this subset:
///
///   G0 G1 G2 G3 motion (arcs by I J K from the start point, or by R; helical in the third axis)
///   G17 G18 G19 plane · G20 G21 inch, mm · G90 G91 absolute, incremental
///   F feed (length unit per minute) · S spindle speed (rpm) · M3 M5 spindle on clockwise, off
///   M2 M30 end · N line numbers · ( ) and ; comments · % · X Y Z words without G: modal motion
///   G40 G49 G54 G61 G64 G80 G91.1 G94 are read where they state what holds anyway
///
/// Coordinates are those of the work frame W. The path starts where all three axes have been
/// named first: moves before that only set them, and a cut before that is a fault. The `line` of a
/// move is its line of the program. Everything else is a fault; InvalidInput carries all of them.
workpiece::ToolPath read_gcode(std::string_view text, const GcodeOptions& options = {});

}  // namespace osteomill::io
