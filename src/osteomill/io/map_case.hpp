// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/io/cutting_section.hpp"
#include "osteomill/io/stock_section.hpp"
#include "osteomill/simulate/force_map.hpp"

namespace osteomill::io {

struct CaseRun;
class Section;

/// A case of `osteomill map`: a bone, a cutter, and the guide over a cutting plane.
struct MapCase {
  StockCase stock;
  CutterCase cutter;
  BoneCase bone;
  simulate::ForceMapOptions map;  ///< cutter, law and poses; its fibres come with the stock
  double feed = 0.0;              ///< of the tip, m/s
  simulate::LimitedForce limited = simulate::LimitedForce::resultant;
  double force_limit = 30.0;  ///< N
  std::vector<std::string> caveats;
  nlohmann::ordered_json expanded;
};

/// The keys, for the schema.
void bind_map(Section& section);

/// Throws InvalidInput with all faults.
MapCase read_map_case(const CaseRun& run);

}  // namespace osteomill::io
