// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/ply_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "osteomill/base/error.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

struct Property {
  std::size_t size = 0;        ///< bytes of the value, or of one item of the list
  std::size_t count_size = 0;  ///< bytes of the list's length; 0: no list
};

struct Element {
  std::size_t rows = 0;
  std::vector<Property> properties;
};

std::size_t size_of(const std::string& type) {
  static const std::map<std::string, std::size_t> sizes = {
      {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto found = sizes.find(type);
  return found == sizes.end() ? 0 : found->second;
}

/// The length of a list, which stands in one to four bytes.
std::size_t length_at(const std::string& bytes, std::size_t at, std::size_t size, bool big_endian) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t k = big_endian ? size - 1 - i : i;
    value |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[at + k])) << (8 * i);
  }
  return value;
}

bool binary_is_whole(const std::string& bytes, std::size_t at, const std::vector<Element>& elements,
                     bool big_endian) {
  for (const Element& element : elements)
    for (std::size_t row = 0; row < element.rows; ++row)
      for (const Property& property : element.properties) {
        std::size_t items = 1;
        if (property.count_size > 0) {
          if (at + property.count_size > bytes.size()) return false;
          items = length_at(bytes, at, property.count_size, big_endian);
          at += property.count_size;
        }
        if (items > bytes.size() || at + items * property.size > bytes.size()) return false;
        at += items * property.size;
      }
  return true;
}

}  // namespace

void check_ply_is_whole(const std::filesystem::path& path) {
  const std::string bytes = read_text_file(path);
  const auto refuse = [&](const std::string& rule) {
    throw InvalidInput({path.string(), fmt::format("{} bytes", bytes.size()), rule,
                        "copy or export the file again"});
  };
  const std::size_t end = bytes.find("end_header");
  if (bytes.compare(0, 3, "ply") != 0 || end == std::string::npos)
    refuse("is no PLY file, or its header is cut short");
  const std::size_t newline = bytes.find('\n', end);
  const std::size_t body = newline == std::string::npos ? bytes.size() : newline + 1;

  std::vector<Element> elements;
  std::string format;
  std::istringstream header(bytes.substr(0, end));
  for (std::string line; std::getline(header, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "format") words >> format;
    if (word == "element") {
      Element element;
      words >> word >> element.rows;
      if (!words) refuse("has an element without a count: \"" + line + "\"");
      elements.push_back(element);
    }
    if (word != "property") continue;
    std::string type;
    std::string items;
    words >> type;
    Property property{size_of(type), 0};
    if (type == "list") {
      words >> type >> items;
      property = {size_of(items), size_of(type)};
      if (property.count_size == 0 || property.count_size > 4)
        refuse("has a list of unknown type: \"" + line + "\"");
    }
    if (property.size == 0 || elements.empty())
      refuse("has a property of unknown type: \"" + line + "\"");
    elements.back().properties.push_back(property);
  }

  bool whole = false;
  if (format == "ascii") {
    std::size_t rows = 0;
    for (const Element& element : elements) rows += element.rows;
    // The last row may have no end of line.
    const auto lines = static_cast<std::size_t>(
        std::count(bytes.begin() + static_cast<std::ptrdiff_t>(body), bytes.end(), '\n'));
    whole = lines + (bytes.back() == '\n' ? 0 : 1) >= rows;
  } else if (format == "binary_little_endian" || format == "binary_big_endian") {
    whole = binary_is_whole(bytes, body, elements, format == "binary_big_endian");
  } else {
    refuse("has no known format: \"" + format + "\"");
  }
  if (!whole) refuse("is cut short: its header promises more");
}

}  // namespace osteomill::io
