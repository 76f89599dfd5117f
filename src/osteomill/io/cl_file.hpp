// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::io {

/// Cutter location data (CL, as APT writes it), one statement a line, of this subset:
///
///   UNITS/MM or UNITS/INCHES · SPINDL/rpm[,RPM][,CLW] · SPINDL/OFF · RAPID (for the next GOTO)
///   FEDRAT/f[,MMPM | MMPS | IPM] · GOTO/x,y,z[,i,j,k] · FROM/x,y,z[,i,j,k] · FINI
///   PARTNO, PPRINT, $$ and MULTAX are read over
///
/// i, j, k point from the tip to the spindle; absent they stay as they were, +z at first. The
/// `line` of a move is its line of the file. Everything else is a fault; InvalidInput carries all
/// of them.
workpiece::ToolPath read_cl(std::string_view text, const std::string& file_name = "path.cl");

/// The same path as CL data, axes with six numbers a GOTO where the path has some: 1 nm, 1e-9.
std::string write_cl(const workpiece::ToolPath& path);

}  // namespace osteomill::io
