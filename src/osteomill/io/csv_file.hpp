// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace osteomill::io {

/// A table of comma-separated values with a heading line, cells as text.
struct CsvFile {
  std::string name;  ///< file name, for messages
  std::vector<std::string> columns;
  struct Row {
    int line = 0;  ///< of the file, where the row begins
    std::vector<std::string> cells;
  };
  std::vector<Row> rows;
};

/// RFC 4180: quoted cells may hold separators, doubled quotes and line breaks. The heading line
/// tells the separator: comma, semicolon or tab. Spaces around unquoted cells, a byte order mark,
/// empty lines and lines that begin with # are skipped. Throws InvalidInput with every fault:
/// rows of another length than the heading, quotes left open, columns without a name or of one name
/// twice, no heading.
CsvFile parse_csv(std::string_view text, const std::string& name);
CsvFile read_csv(const std::filesystem::path& file);

}  // namespace osteomill::io
