// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/io/region_section.hpp"
#include "osteomill/io/stock_section.hpp"
#include "osteomill/workpiece/no_go.hpp"
#include "osteomill/workpiece/region.hpp"

namespace osteomill::io {

/// The regions of a case, in the work frame.
struct MadeRegions {
  workpiece::Region plan;  ///< none: nothing is planned
  std::vector<workpiece::NoGo> no_go;
  std::optional<workpiece::AccessWindow> access;
  std::vector<std::string> remarks;  ///< what the reader of the result has to know
};

/// Surfaces are read and brought from the frame of the stock's CT, mesh or phantom into W. Throws
/// InvalidInput with the faults of all regions.
MadeRegions make_regions(const RegionCase& regions, const StockCase& stock);

/// What was planned and what was done: `plan` of a run.
nlohmann::ordered_json plan_report(const workpiece::Stock& before, const workpiece::Stock& after,
                                   const workpiece::Region& plan);

}  // namespace osteomill::io
