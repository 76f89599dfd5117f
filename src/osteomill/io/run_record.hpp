// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace osteomill::io {

/// What run.json says of a run. `osteomill COMMAND run.json` runs the case again.
struct RunRecord {
  std::string program;           ///< name and version
  std::string command;           ///< "simulate"
  nlohmann::ordered_json input;  ///< the expanded case
  nlohmann::ordered_json summary;
  double wall_time = 0.0;  ///< s
};

/// Date and time of now, UTC, as "2024-05-17 09:30:00 UTC".
std::string now_text();

/// Writes run.json, whole or not at all, with date and host beside the record.
void write_run_json(const std::filesystem::path& file, const RunRecord& record);

}  // namespace osteomill::io
