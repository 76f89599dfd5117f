// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "command.hpp"

namespace osteomill::cli {

/// One document a run, by name. A case of one run prints it alone, a case of several prints
/// { "runs": [ { "name": …, … } ] }.
void print_documents(const std::vector<std::pair<std::string, nlohmann::ordered_json>>& runs);

/// Creates the run directory with run.json: version, case and results. Returns where it is.
std::filesystem::path run_directory(const std::filesystem::path& directory,
                                    const std::string& command, const std::string& run_name,
                                    bool several, const nlohmann::ordered_json& expanded_case,
                                    const nlohmann::ordered_json& results);

}  // namespace osteomill::cli
