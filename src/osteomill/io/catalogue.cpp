// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/catalogue.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>

#include "osteomill/base/error.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {

namespace fs = std::filesystem;

fs::path data_directory() {
  if (const char* set = std::getenv("OSTEOMILL_DATA"); set != nullptr && *set != '\0') return set;
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  for (const char* place : {"data", "../share/osteomill/data"}) {
    const fs::path candidate = program.parent_path() / place;
    if (!program.empty() && fs::is_directory(candidate, none)) return candidate;
  }
  return OSTEOMILL_SOURCE_DATA;
}

std::vector<std::string> catalogue_names(const std::string& kind) {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(data_directory() / kind, none)) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

ValueTree catalogue_entry(const std::string& kind, const std::string& name) {
  const std::vector<std::string> names = catalogue_names(kind);
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw InvalidInput(Fault{"use", '"' + name + '"', "is not in the catalogue of " + kind,
                             fmt::format("known: {}", fmt::join(names, ", "))});
  }
  const fs::path file = data_directory() / kind / (name + ".toml");
  return parse_toml(read_text_file(file), kind + "/" + name + ".toml");
}

}  // namespace osteomill::io
