// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/io/simulated_run.hpp"

namespace osteomill::io {

/// The JSON document of `osteomill simulate`; its keys are a contract with scripts.
nlohmann::ordered_json document_of(const std::vector<SimulatedRun>& runs, double wall_time);

/// What a table shows of a run.
struct RunRow {
  std::string name, status;
  simulate::Summary summary;
};
/// One a run; with `grouped` one for all variants of a run: mean time, force and volume, largest
/// peak and feed, and the time above the limit of all of them.
std::vector<RunRow> rows_of(const std::vector<SimulatedRun>& runs, bool grouped);

/// A heading row and those of rows_of().
std::vector<std::vector<std::string>> table_of(const std::vector<SimulatedRun>& runs, bool grouped);

/// The run with constant feed on the same bone and path as this one with adapted feed, or null.
const SimulatedRun* constant_feed_beside(const std::vector<SimulatedRun>& runs,
                                         const SimulatedRun& run);

/// One sentence for each run whose feed is adapted and that has a run with constant feed on the
/// same bone: how the two compare.
std::vector<std::string> comparisons_of(const std::vector<SimulatedRun>& runs);

/// The case with all its runs, which runs again to the same result.
nlohmann::ordered_json case_of(const std::vector<SimulatedRun>& runs);

}  // namespace osteomill::io
