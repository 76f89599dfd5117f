// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/csv_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "osteomill/base/error.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

std::string place(const std::string& name, int line) { return fmt::format("{}:{}", name, line); }

/// The separator that stands most often, outside quotes, in the first line that is not a remark.
char separator_of(std::string_view text) {
  size_t begin = 0;
  while (begin < text.size() &&
         (text[begin] == '#' || text[begin] == '\n' || text[begin] == '\r')) {
    const size_t end = text.find('\n', begin);
    begin = end == std::string_view::npos ? text.size() : end + 1;
  }
  bool quoted = false;
  size_t commas = 0, semicolons = 0, tabs = 0;
  for (; begin < text.size() && (quoted || text[begin] != '\n'); ++begin) {
    const char c = text[begin];
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    commas += c == ',';
    semicolons += c == ';';
    tabs += c == '\t';
  }
  if (semicolons > commas && semicolons >= tabs) return ';';
  return tabs > commas ? '\t' : ',';
}

std::string trimmed(const std::string& cell) {
  const size_t begin = cell.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return "";
  return cell.substr(begin, cell.find_last_not_of(" \t\r") - begin + 1);
}

class Reader {
 public:
  Reader(std::string_view text, char separator) : text_(text), separator_(separator) {}

  /// The next row that holds something; false at the end.
  bool next(CsvFile::Row& row, std::vector<Fault>& faults, const std::string& name) {
    while (at_ < text_.size()) {
      row = {line_, {}};
      if (text_[at_] == '#') {
        skip_line();
        continue;
      }
      read_row(row, faults, name);
      if (row.cells.size() > 1 || !row.cells.front().empty()) return true;
    }
    return false;
  }

 private:
  void skip_line() {
    const size_t end = text_.find('\n', at_);
    at_ = end == std::string_view::npos ? text_.size() : end + 1;
    ++line_;
  }

  void read_row(CsvFile::Row& row, std::vector<Fault>& faults, const std::string& name) {
    for (;;) {
      row.cells.push_back(read_cell(faults, name));
      if (at_ >= text_.size()) return;
      const char c = text_[at_++];
      if (c == separator_) continue;
      ++line_;
      return;
    }
  }

  /// Stops on the separator or the line break behind the cell.
  std::string read_cell(std::vector<Fault>& faults, const std::string& name) {
    size_t begin = at_;
    while (begin < text_.size() && text_[begin] == ' ') ++begin;
    std::string cell;
    if (begin < text_.size() && text_[begin] == '"') {
      const int opened = line_;
      at_ = begin + 1;
      for (;; ++at_) {
        if (at_ >= text_.size()) {
          faults.push_back(Fault{"quotes", "", "are opened and not closed",
                                 "close the cell with \"", place(name, opened)});
          return cell;
        }
        if (text_[at_] == '"') {
          if (at_ + 1 >= text_.size() || text_[at_ + 1] != '"') break;
          ++at_;
        }
        line_ += text_[at_] == '\n';
        cell += text_[at_];
      }
      ++at_;
      while (at_ < text_.size() && text_[at_] != separator_ && text_[at_] != '\n') ++at_;
      return cell;
    }
    while (at_ < text_.size() && text_[at_] != separator_ && text_[at_] != '\n') {
      cell += text_[at_++];
    }
    return trimmed(cell);
  }

  std::string_view text_;
  char separator_;
  size_t at_ = 0;
  int line_ = 1;
};

}  // namespace

CsvFile parse_csv(std::string_view text, const std::string& name) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<Fault> faults;
  CsvFile file{name, {}, {}};
  Reader reader(text, separator_of(text));
  CsvFile::Row row;
  if (!reader.next(row, faults, name)) {
    throw InvalidInput(Fault{name, "", "is empty", "needs a heading line with the columns' names"});
  }
  file.columns = row.cells;
  std::set<std::string> seen;
  for (const std::string& column : file.columns) {
    if (column.empty()) {
      faults.push_back(Fault{"heading", "", "a column has no name", "name it or leave it out",
                             place(name, row.line)});
    } else if (!seen.insert(column).second) {
      faults.push_back(Fault{"heading", column, "stands twice", "give each column its own name",
                             place(name, row.line)});
    }
  }
  while (reader.next(row, faults, name)) {
    if (row.cells.size() != file.columns.size()) {
      faults.push_back(Fault{"row", fmt::format("{} cells", row.cells.size()),
                             fmt::format("must have {} as the heading", file.columns.size()),
                             "leave missing cells empty, and quote cells that hold the separator",
                             place(name, row.line)});
      continue;
    }
    file.rows.push_back(row);
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return file;
}

CsvFile read_csv(const std::filesystem::path& file) {
  return parse_csv(read_text_file(file), file.filename().string());
}

}  // namespace osteomill::io
