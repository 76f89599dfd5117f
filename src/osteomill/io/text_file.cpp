// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/text_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "osteomill/base/error.hpp"
#include "osteomill/io/pending_file.hpp"

namespace osteomill::io {

std::string read_text_file(const std::filesystem::path& file) {
  std::error_code none;
  if (std::filesystem::is_directory(file, none)) {
    throw InvalidInput(Fault{file.string(), "", "is a folder", "name a file"});
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw InvalidInput(
        Fault{file.string(), "", std::strerror(errno), "check the name and the rights"});
  }
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void write_text_file(const std::filesystem::path& file, std::string_view text) {
  PendingFile pending(file);
  std::ofstream stream(pending.path(), std::ios::binary);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) {
    throw WorldError(file.string() + ": cannot be written: " + std::strerror(errno) +
                     "; check the rights and the space on the disk");
  }
  pending.commit();
}

}  // namespace osteomill::io
