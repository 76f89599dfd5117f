// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "command.hpp"
#include "osteomill/io/simulated_run.hpp"

namespace osteomill::cli {

/// Shows milled runs as the arguments ask: their warnings, the document as JSON or their table;
/// below a plain one how they compare with constant feed, and `more`. For simulate and control.
void print_runs(Format format, const std::vector<io::SimulatedRun>& runs,
                const nlohmann::ordered_json& document, const std::vector<std::string>& more = {});

}  // namespace osteomill::cli
