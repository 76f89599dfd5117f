// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/pending_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include "osteomill/base/error.hpp"

namespace osteomill::io {
namespace {

/// Not taken by another process, nor by another thread of this one.
std::filesystem::path temporary_name(const std::filesystem::path& target) {
  static std::atomic<unsigned> count = 0;
  return target.parent_path() / fmt::format(".{}-{}-{}{}", target.stem().string(), getpid(),
                                            count++, target.extension().string());
}

}  // namespace

PendingFile::PendingFile(std::filesystem::path target)
    : target_(std::move(target)), path_(temporary_name(target_)) {
  const int file = open(path_.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0666);
  if (file < 0)
    throw WorldError(
        fmt::format("{}: cannot be written: {}; choose a folder that exists and that "
                    "you may write to",
                    target_.string(), std::strerror(errno)));
  close(file);
}

PendingFile::~PendingFile() {
  if (!committed_) unlink(path_.c_str());
}

void PendingFile::commit() {
  const int file = open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  const bool on_disk = file >= 0 && fsync(file) == 0;
  const int why = errno;
  if (file >= 0) close(file);
  if (!on_disk || std::rename(path_.c_str(), target_.c_str()) != 0)
    throw WorldError(fmt::format("{}: cannot be written: {}", target_.string(),
                                 std::strerror(on_disk ? errno : why)));
  committed_ = true;
}

}  // namespace osteomill::io
