// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/text_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "osteomill/base/error.hpp"

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
  const std::filesystem::path temporary = file.string() + ".part" + std::to_string(::getpid());
  std::ofstream stream(temporary, std::ios::binary);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  std::error_code failed;
  if (stream) std::filesystem::rename(temporary, file, failed);
  if (!stream || failed) {
    const std::string reason = failed ? failed.message() : std::strerror(errno);
    std::filesystem::remove(temporary, failed);
    throw WorldError(file.string() + ": cannot be written: " + reason +
                     "; check the rights and the space on the disk");
  }
}

}  // namespace osteomill::io
