// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::io {

struct GcodeWriterOptions {
  std::string comment;             ///< in the first line; without brackets
  bool arcs = true;                ///< runs of points on a circle become G2 and G3
  double longest_sagitta = 20e-6;  ///< chords that stay nearer to their circle count as an arc, m
};

/// The program of a path, in mm and absolute, with arcs (and helices) in G17, G18 and G19:
/// read_gcode() gives the same path back, its coordinates to 1 nm. InvalidInput when the tool's
/// axis is not +z all along: such a path is written as CL data (cl_file.hpp).
std::string write_gcode(const workpiece::ToolPath& path, const GcodeWriterOptions& options = {});

}  // namespace osteomill::io
