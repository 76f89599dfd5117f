// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/io/path_section.hpp"
#include "osteomill/io/region_maker.hpp"
#include "osteomill/workpiece/stock.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::io {

/// A path as a case asks for it, checked against the regions.
struct MadePath {
  workpiece::ToolPath path;
  nlohmann::ordered_json report;  ///< length, time, air, margins: `path` of a run
};

/// Throws InvalidInput: a path that can't be, one that starts inside bone, one that enters the
/// margin of a no-go region (each region, where, by how much), one that does not fit through the
/// window.
MadePath make_path(const PathCase& path, const cutting::Cutter& cutter,
                   const workpiece::Stock& stock, const MadeRegions& regions);

}  // namespace osteomill::io
