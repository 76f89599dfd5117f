// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace osteomill::io {

/// The folder of `-o DIR`. Files are written aside and take their places together in commit(),
/// run.json last; a run that fails leaves the folder as it was. A folder may be a new one, an empty
/// one, or that of a former run, whose files go when the new ones come; what somebody else put
/// there stays.
class RunDirectory {
 public:
  /// InvalidInput when the path is a file or a folder that holds something else than a run;
  /// WorldError when it cannot be made.
  explicit RunDirectory(std::filesystem::path folder);
  ~RunDirectory();
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

  /// Where to write the file of that name until commit().
  std::filesystem::path file(const std::string& name) const { return aside_ / name; }
  /// Where the files will be.
  const std::filesystem::path& folder() const { return folder_; }

  /// WorldError when a file cannot take its place, or when there is no run.json.
  void commit();

 private:
  std::filesystem::path folder_;
  std::filesystem::path aside_;
  bool made_ = false;  ///< the folder was not there before
};

}  // namespace osteomill::io
