// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "osteomill/io/toml_file.hpp"

namespace osteomill::io {

/// One run of a case: every key that it sets, overrides and catalogue entries merged in.
struct CaseRun {
  std::string name;  ///< "run" when the case has no [[run]]
  ValueTree tree;
  std::filesystem::path directory;  ///< file names in the case are relative to it
};

/// Reads CASE.toml, or a run.json written by an earlier run, and expands it:
///  1. `overrides`, each "section.key=value", replace keys;
///  2. each [[run]] (its `name`, its other tables) is merged over the rest, one CaseRun a [[run]];
///     overrides win over it;
///  3. where a table cutter, bone, implant or robot has `use = "name"`, the catalogue entry is
///  merged under it; `use = "file.toml"` takes an entry from a file, relative to the case.
/// Throws InvalidInput with all that is wrong so far: syntax, overrides, run names, unknown
/// entries.
std::vector<CaseRun> read_case(const std::filesystem::path& file,
                               const std::vector<std::string>& overrides);

}  // namespace osteomill::io
