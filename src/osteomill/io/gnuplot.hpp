// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace osteomill::io::gnuplot {

/// The text in gnuplot's quotes, whatever it holds.
std::string quoted(std::string_view text);

/// A named data block, one row a point, columns of equal length.
std::string data_block(std::string_view name,
                       const std::vector<const std::vector<double>*>& columns);

/// Lines that set the terminal for the suffix of the path, fonts, border, grid and tics of the
/// house. Sizes are points; InvalidInput for a suffix other than .png, .svg and .pdf.
std::string prologue(const std::filesystem::path& path, int width, int height);

/// Sizes of fonts in the terminal of this path: ", 20" where the script says font_of(path, 10).
std::string font(const std::filesystem::path& path, double points);

/// Runs the script; what it draws appears under the path when it went well. WorldError otherwise.
void run(std::string_view script, const std::filesystem::path& path);

}  // namespace osteomill::io::gnuplot
