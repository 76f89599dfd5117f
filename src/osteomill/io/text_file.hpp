// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace osteomill::io {

/// The whole file. Throws InvalidInput when it is missing, a folder or unreadable.
std::string read_text_file(const std::filesystem::path& file);

/// Writes the whole file or nothing: a temporary neighbour, renamed when complete.
/// Throws WorldError when the disk refuses.
void write_text_file(const std::filesystem::path& file, std::string_view text);

}  // namespace osteomill::io
