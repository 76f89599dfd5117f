// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace osteomill::io {

/// A file that appears under its name only when it is whole: it is written beside its target under
/// another name, and renamed by commit(). Without commit() nothing is left of it.
class PendingFile {
 public:
  /// WorldError when the folder of the target is not there or cannot be written.
  explicit PendingFile(std::filesystem::path target);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /// Where to write. Same folder and suffix as the target.
  const std::filesystem::path& path() const { return path_; }
  /// Flushes to the disk and gives the file its name, in place of an older one.
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path path_;
  bool committed_ = false;
};

}  // namespace osteomill::io
