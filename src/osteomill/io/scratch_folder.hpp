// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>

/// For tests only.
namespace osteomill::io {

/// A path in a folder of this process, which goes when the process ends.
inline std::filesystem::path scratch(const std::string& name = "") {
  struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("osteomill_test_" + std::to_string(getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static const Folder folder;
  return folder.path / name;
}

}  // namespace osteomill::io
