// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/io/simulate_case.hpp"
#include "osteomill/io/simulated_run.hpp"

namespace osteomill::io {

/// The tables of `osteomill control`: those of simulate with [variants] and [supervisor], for
/// `osteomill schema`.
void bind_control_keys(Section& section);

/// Every run of a case under a supervisor. With [variants] each run stands for `count` of them,
/// "name-00", "name-01" ...; only line profiles have variants. Throws InvalidInput with the faults
/// of all runs.
std::vector<SimulateCase> read_control_cases(const std::vector<CaseRun>& runs);

/// The JSON document of `osteomill control`; its keys are a contract with scripts. `jitter`:
/// largest lateness of a wake-up, s; negative when the loop was not paced.
nlohmann::ordered_json control_document_of(const std::vector<SimulatedRun>& runs, double wall_time,
                                           double jitter);

/// What the supervisor of the cases stops at, in a sentence.
std::string supervisor_sentence(const std::vector<SimulateCase>& cases);

/// Mean time, time above the limit and largest peak of the variants of each run, a sentence each.
std::vector<std::string> variants_of(const std::vector<SimulatedRun>& runs);

}  // namespace osteomill::io
