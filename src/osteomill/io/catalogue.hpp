// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "osteomill/io/toml_file.hpp"

namespace osteomill::io {

/// Where the catalogues are: $OSTEOMILL_DATA, else data/ beside or above the program, else the
/// source tree that it was built from.
std::filesystem::path data_directory();

/// Names of the entries of a kind ("bones", "cutters"), in alphabetical order.
std::vector<std::string> catalogue_names(const std::string& kind);

/// The entry as a tree. Throws InvalidInput that lists the known names.
ValueTree catalogue_entry(const std::string& kind, const std::string& name);

}  // namespace osteomill::io
