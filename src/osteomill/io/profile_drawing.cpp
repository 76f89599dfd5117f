// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/profile_drawing.hpp"

#include <fmt/format.h>

#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

#include "osteomill/base/error.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;
using Points = std::vector<Eigen::Vector2d>;

[[noreturn]] void refuse(const fs::path& file, const std::string& rule) {
  throw InvalidInput(Fault{"implant.drawing", file.filename().string(), rule,
                           "export the profile as one polyline of straight pieces"});
}

std::optional<double> number(std::string text) {
  text.erase(0, text.find_first_not_of(" \t\r"));
  text.erase(text.find_last_not_of(" \t\r") + 1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

/// DXF: pairs of lines, a group code and its value. Group 0 begins an entity; 10 and 20 are x and
/// y; 42 is the bulge of an arc.
std::vector<Points> dxf_polylines(const fs::path& file, const std::string& text) {
  std::vector<Points> lines;
  std::istringstream in(text);
  std::string code;
  std::string value;
  bool inside = false;  // a LWPOLYLINE, or the VERTEX entities of a POLYLINE
  bool vertex = false;
  bool any = false;
  while (std::getline(in, code) && std::getline(in, value)) {
    const auto group = number(code);
    if (!group) refuse(file, fmt::format("is no DXF text file: group code \"{}\"", code));
    any = true;
    value.erase(value.find_last_not_of(" \t\r") + 1);
    value.erase(0, value.find_first_not_of(" \t"));
    if (*group == 0.0) {
      vertex = value == "VERTEX" && inside;
      if (value == "LWPOLYLINE" || value == "POLYLINE") {
        lines.emplace_back();
        inside = true;
        vertex = value == "LWPOLYLINE";
      } else if (!vertex && value != "SEQEND") {
        inside = false;
      }
    } else if (vertex && (*group == 10.0 || *group == 20.0 || *group == 42.0)) {
      const auto coordinate = number(value);
      if (!coordinate) refuse(file, fmt::format("holds \"{}\" where a number must stand", value));
      if (*group == 42.0 && *coordinate != 0.0) refuse(file, "must have straight pieces, not arcs");
      if (*group == 10.0) lines.back().emplace_back(*coordinate, 0.0);
      if (*group == 20.0 && !lines.back().empty()) lines.back().back().y() = *coordinate;
    }
  }
  if (!any) refuse(file, "is empty");
  return lines;
}

/// Numbers and single letters of an SVG path or point list.
struct Token {
  char letter = 0;
  double value = 0.0;
};

std::vector<Token> tokens(const fs::path& file, const std::string& text) {
  std::vector<Token> list;
  const char* at = text.data();
  const char* end = at + text.size();
  while (at < end) {
    if (*at == ' ' || *at == ',' || *at == '\n' || *at == '\t' || *at == '\r') {
      ++at;
    } else if (std::isalpha(static_cast<unsigned char>(*at)) != 0) {
      list.push_back({*at++, 0.0});
    } else {
      if (*at == '+') ++at;
      double value = 0.0;
      const auto [next, error] = std::from_chars(at, end, value);
      if (error != std::errc()) refuse(file, "holds a path that is not made of numbers");
      list.push_back({0, value});
      at = next;
    }
  }
  return list;
}

Points svg_points(const fs::path& file, const std::string& text) {
  Points points;
  const auto list = tokens(file, text);
  if (list.size() % 2 != 0) refuse(file, "holds an odd number of coordinates");
  for (std::size_t i = 0; i + 1 < list.size(); i += 2) {
    if (list[i].letter != 0 || list[i + 1].letter != 0) refuse(file, "holds a letter among points");
    points.emplace_back(list[i].value, list[i + 1].value);
  }
  return points;
}

Points svg_path(const fs::path& file, const std::string& text) {
  Points points;
  char command = 0;
  Eigen::Vector2d at(0.0, 0.0);
  const auto list = tokens(file, text);
  for (std::size_t i = 0; i < list.size();) {
    if (list[i].letter != 0) {
      command = list[i++].letter;
      if (std::string("MmLlHhVvZz").find(command) == std::string::npos) {
        refuse(file, fmt::format("must have straight pieces: path command \"{}\"", command));
      }
      continue;
    }
    const bool relative = std::islower(static_cast<unsigned char>(command)) != 0;
    const auto next = [&] {
      if (i >= list.size() || list[i].letter != 0) refuse(file, "holds an incomplete path");
      return list[i++].value;
    };
    switch (std::toupper(static_cast<unsigned char>(command))) {
      case 'H':
        at.x() = next() + (relative ? at.x() : 0.0);
        break;
      case 'V':
        at.y() = next() + (relative ? at.y() : 0.0);
        break;
      case 'M':
      case 'L': {
        const double x = next();
        const double y = next();
        at = relative ? Eigen::Vector2d(at.x() + x, at.y() + y) : Eigen::Vector2d(x, y);
        break;
      }
      default:
        refuse(file, "holds numbers before any path command");
    }
    points.push_back(at);
  }
  return points;
}

void svg_walk(const fs::path& file, const boost::property_tree::ptree& tree,
              std::vector<Points>& lines) {
  for (const auto& [name, child] : tree) {
    if (name == "polyline" || name == "polygon") {
      lines.push_back(svg_points(file, child.get<std::string>("<xmlattr>.points", "")));
    } else if (name == "path") {
      lines.push_back(svg_path(file, child.get<std::string>("<xmlattr>.d", "")));
    }
    if (child.get_optional<std::string>("<xmlattr>.transform")) {
      refuse(file, fmt::format("must not transform <{}>", name));
    }
    svg_walk(file, child, lines);
  }
}

std::vector<Points> svg_polylines(const fs::path& file, const std::string& text) {
  std::istringstream in(text);
  boost::property_tree::ptree tree;
  try {
    boost::property_tree::read_xml(in, tree);
  } catch (const boost::property_tree::xml_parser_error& error) {
    refuse(file, fmt::format("is no SVG: line {}: {}", error.line(), error.message()));
  }
  std::vector<Points> lines;
  svg_walk(file, tree, lines);
  for (Points& line : lines) {
    for (Eigen::Vector2d& point : line) point.y() = -point.y();
  }
  return lines;
}

}  // namespace

std::vector<Eigen::Vector2d> read_polyline(const fs::path& file, double unit) {
  const std::string text = read_text_file(file);
  std::vector<Points> lines;
  if (file.extension() == ".dxf" || file.extension() == ".DXF") {
    lines = dxf_polylines(file, text);
  } else if (file.extension() == ".svg" || file.extension() == ".SVG") {
    lines = svg_polylines(file, text);
  } else {
    refuse(file, "must end in .dxf or .svg");
  }
  if (lines.size() != 1) {
    refuse(file, fmt::format("must hold one polyline, it holds {}", lines.size()));
  }
  for (Eigen::Vector2d& point : lines.front()) point *= unit;
  return lines.front();
}

}  // namespace osteomill::io
