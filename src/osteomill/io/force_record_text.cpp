// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include "osteomill/base/error.hpp"
#include "osteomill/io/force_record_table.hpp"

namespace osteomill::io {
namespace {

constexpr std::size_t kFewest = 3;   // numbers in a line of a record
constexpr std::size_t kFaults = 20;  // lines that are named before the reader gives up

std::string_view trim(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

/// Calls for each cell; a separator at the end of the line opens none. Spaces count in runs.
template <class Cell>
void cells(std::string_view line, char separator, Cell cell) {
  line = separator == '\t' ? line : trim(line);
  while (!line.empty() && (line.back() == separator || line.back() == '\r')) line.remove_suffix(1);
  while (!line.empty()) {
    const std::size_t end = separator == ' ' ? line.find_first_of(" \t") : line.find(separator);
    cell(trim(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
    if (separator == ' ') line = trim(line);
  }
}

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> out;
  cells(line, separator, [&](std::string_view cell) {
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
      cell = cell.substr(1, cell.size() - 2);
    out.push_back(cell);
  });
  return out;
}

/// A number; an empty cell is none there. Decimal commas where they do not separate.
bool number(std::string_view cell, char separator, double& value) {
  if (cell.empty()) {
    value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  if (cell.front() == '+') cell.remove_prefix(1);
  auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error == std::errc{} && end == cell.data() + cell.size()) return true;
  if (separator == ',' || cell.find(',') == std::string_view::npos || cell.size() > 64)
    return false;
  char buffer[64];
  std::replace_copy(cell.begin(), cell.end(), buffer, ',', '.');
  const auto again = std::from_chars(buffer, buffer + cell.size(), value);
  return again.ec == std::errc{} && again.ptr == buffer + cell.size();
}

/// How many numbers the line holds when it holds nothing else; 0 otherwise.
std::size_t numbers_in(std::string_view line, char separator) {
  std::size_t count = 0, filled = 0;
  bool all = true;
  double value = 0.0;
  cells(line, separator, [&](std::string_view cell) {
    ++count;
    filled += !cell.empty();
    all = all && number(cell, separator, value);
  });
  return all && filled >= 2 ? count : 0;
}

/// One line after the other, without their ends.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    const std::size_t end = text_.find('\n', at_);
    line = text_.substr(at_, end == std::string_view::npos ? end : end - at_);
    at_ = end == std::string_view::npos ? text_.size() : end + 1;
    ++number_;
    return true;
  }
  int number() const { return number_; }
  std::size_t position() const { return at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  int number_ = 0;
};

struct Layout {
  std::vector<std::string_view> header;
  std::size_t begin = 0;  // of the first line of numbers in the text
  int line = 1;           // its number
  char separator = ',';
  std::size_t columns = 0;
};

/// The separator by which two lines that follow each other, or the only one, are equally many
/// numbers; 0 when none does.
char fitting(std::string_view line, std::string_view following, const std::string& given) {
  for (const char separator : given.empty() ? std::string("\t;, ") : given.substr(0, 1)) {
    const std::size_t count = numbers_in(line, separator);
    if (count >= kFewest && (trim(following).empty() || numbers_in(following, separator) == count))
      return separator;
  }
  return 0;
}

Layout layout_of(std::string_view text, const std::string& name, const RecordFormat& format) {
  Layout out;
  Lines lines(text);
  std::string_view line;
  std::size_t begin = 0;
  while (lines.next(line)) {
    const bool forced = format.header_lines > 0 && lines.number() <= format.header_lines;
    if (!forced && !trim(line).empty()) {
      std::string_view following;
      Lines ahead(text.substr(lines.position()));
      while (trim(following).empty() && ahead.next(following)) {
      }
      if (const char separator = fitting(line, following, format.separator)) {
        out.separator = separator;
        out.columns = numbers_in(line, separator);
        out.begin = begin;
        out.line = lines.number();
        return out;
      }
    }
    out.header.push_back(line);
    begin = lines.position();
  }
  throw InvalidInput({name, fmt::format("{} lines", out.header.size()),
                      "holds no two lines of three or more numbers that follow each other",
                      "check the file, record.separator and record.header_lines"});
}

/// The first number behind a key in a header line.
std::optional<double> header_number(std::string_view line, std::string_view key) {
  const std::string low = lower(line);
  const std::size_t at = low.find(key);
  if (at == std::string::npos) return {};
  const std::size_t digit = low.find_first_of("0123456789.", at + key.size());
  if (digit == std::string::npos) return {};
  std::string cell = low.substr(digit, low.find_first_not_of("0123456789.,e+-", digit) - digit);
  std::replace(cell.begin(), cell.end(), ',', '.');
  double value = 0.0;
  if (std::from_chars(cell.data(), cell.data() + cell.size(), value).ec != std::errc{}) return {};
  return low.find("khz") != std::string::npos ? 1000.0 * value : value;
}

void read_header(const Layout& layout, RecordTable& table) {
  for (const std::string_view line : layout.header) {
    const std::string low = lower(line);
    if (low.find("dynoware") != std::string::npos || low.find("kistler") != std::string::npos)
      table.dynoware = true;
    for (const char* key : {"sampling rate", "sample rate", "samplerate", "sampling_rate",
                            "sample_rate", "sampling frequency", "rate_hz"}) {
      if (!table.rate) table.rate = header_number(line, key);
    }
    if (!table.measuring_time) table.measuring_time = header_number(line, "measuring time");
  }
}

/// A unit without brackets about it.
std::string_view bare(std::string_view cell) {
  while (!cell.empty() && (cell.front() == '[' || cell.front() == '(')) cell.remove_prefix(1);
  while (!cell.empty() && (cell.back() == ']' || cell.back() == ')')) cell.remove_suffix(1);
  return cell;
}

bool is_unit(std::string_view cell) {
  const std::string_view unit = bare(cell);
  if (unit.empty() || unit == "-" || unit == "1") return true;
  // Of other sensors on the same amplifier.
  for (const std::string_view other : {"g", "m/s2", "m/s^2", "%", "um", "mm", "C", "Pa", "bar"}) {
    if (unit == other) return true;
  }
  for (const UnitKind kind :
       {UnitKind::force, UnitKind::time, UnitKind::moment, UnitKind::angle, UnitKind::voltage}) {
    if (unit_factor(kind, unit)) return true;
  }
  return false;
}

/// Names and units of the columns from the header; numbers where it has no fitting line.
void name_columns(const Layout& layout, RecordTable& table) {
  std::vector<std::string_view> names, units;
  for (auto line = layout.header.rbegin(); line != layout.header.rend() && names.empty(); ++line) {
    std::string_view text = trim(*line);
    if (!text.empty() && text.front() == '#') text = trim(text.substr(1));
    // Tabs before spaces: names may have spaces where the numbers are separated by them.
    std::vector<std::string_view> found;
    for (const char separator : {layout.separator, '\t', ';', ','}) {
      found = split(text, separator);
      if (found.size() == layout.columns) break;
    }
    if (found.size() != layout.columns) continue;
    if (units.empty() && std::all_of(found.begin(), found.end(), is_unit)) {
      units = found;
    } else {
      names = found;
    }
  }
  for (std::size_t k = 0; k < layout.columns; ++k) {
    RecordChannel channel{.name = std::to_string(k + 1), .unit = {}, .values = {}};
    if (!names.empty()) split_unit(std::string(names[k]), channel.name, channel.unit);
    if (!units.empty()) channel.unit = bare(units[k]);
    table.channels.push_back(std::move(channel));
  }
}

/// Commas that separate and decimal commas in one line cannot be told apart: there are more numbers
/// than names, at most twice as many.
void refuse_two_kinds_of_commas(const Layout& layout, const std::string& name) {
  if (layout.separator != ',') return;
  for (auto line = layout.header.rbegin(); line != layout.header.rend(); ++line) {
    if (trim(*line).empty()) continue;
    const std::size_t names = split(*line, ',').size();
    if (names == layout.columns) return;
    if (names >= kFewest && names < layout.columns && layout.columns <= 2 * names) {
      throw InvalidInput({name, fmt::format("{} numbers below {} names", layout.columns, names),
                          "commas seem to be both decimal and between the columns",
                          "export again with tabs or semicolons, or with decimal points"});
    }
    return;
  }
}

}  // namespace

RecordTable parse_text_record(std::string_view text, const std::string& name,
                              const RecordFormat& format) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const Layout layout = layout_of(text, name, format);
  RecordTable table;
  table.file = name;
  table.format = fmt::format("text, separated by {}", layout.separator == '\t'  ? "tabs"
                                                      : layout.separator == ' ' ? "spaces"
                                                      : layout.separator == ';' ? "semicolons"
                                                                                : "commas");
  table.first_line = layout.line;
  read_header(layout, table);
  name_columns(layout, table);
  table.dynoware = table.dynoware || format.kind == RecordKind::dynoware;

  refuse_two_kinds_of_commas(layout, name);
  text.remove_prefix(layout.begin);
  const auto most = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
  Eigen::MatrixXd values(static_cast<Eigen::Index>(most),
                         static_cast<Eigen::Index>(layout.columns));
  std::vector<Fault> faults;
  Lines lines(text);
  std::string_view line;
  Eigen::Index row = 0;
  while (lines.next(line) && faults.size() < kFaults) {
    if (trim(line).empty()) continue;
    const int place = layout.line + lines.number() - 1;
    Eigen::Index column = 0;
    const auto wide = static_cast<Eigen::Index>(layout.columns);
    bool clean = true;
    cells(line, layout.separator, [&](std::string_view cell) {
      double value = 0.0;
      if (column < wide && !number(cell, layout.separator, value)) {
        if (clean)
          faults.push_back({table.channels[static_cast<std::size_t>(column)].name,
                            std::string(cell.substr(0, 40)), "must be a number", "",
                            fmt::format("{}:{}", name, place)});
        clean = false;
      }
      if (column < wide) values(row, column) = value;
      ++column;
    });
    // Empty cells at the end of a line count as separators at its end.
    const bool short_of_nothing = column < wide && layout.separator != ' ' && line.size() > 1 &&
                                  trim(line).back() == layout.separator;
    for (; short_of_nothing && column < wide; ++column)
      values(row, column) = std::numeric_limits<double>::quiet_NaN();
    if (clean && column != wide) {
      faults.push_back(
          {"line", fmt::format("{} numbers", column),
           fmt::format("must have {} as the first one", wide),
           lines.position() >= text.size() ? "the file may be cut off; take the last line out" : "",
           fmt::format("{}:{}", name, place)});
    }
    ++row;
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  for (std::size_t k = 0; k < layout.columns; ++k)
    table.channels[k].values = values.col(static_cast<Eigen::Index>(k)).head(row);
  return table;
}

}  // namespace osteomill::io
