// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/cutting/engagement.hpp"
#include "osteomill/io/cutting_section.hpp"
#include "osteomill/thermal/heat_partition.hpp"

namespace osteomill::io {

struct CaseRun;
class Section;

/// A case of `osteomill force`: one cutter in one bone under one condition.
struct ForceCase {
  cutting::Cutter cutter;
  BoneCase bone;
  cutting::Condition condition;
  cutting::Immersion immersion;
  std::optional<cutting::TiltedCut> tilted;       ///< in place of the immersion
  std::optional<cutting::Engagement> engagement;  ///< in place of both
  thermal::PartitionOptions heat;
  std::vector<std::string> caveats;  ///< what of it is not measured
  nlohmann::ordered_json expanded;   ///< the case with its defaults filled in
};

/// The keys, for the schema.
void bind_force(Section& section);

/// Throws InvalidInput with all faults.
ForceCase read_force_case(const CaseRun& run);

}  // namespace osteomill::io
