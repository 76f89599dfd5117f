// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace osteomill::io {

/// A tree of values and the place that each came from: "cut.axial_depth_mm" → "case.toml:12".
/// Elements of arrays are "beam.segments.0".
struct ValueTree {
  nlohmann::ordered_json values = nlohmann::ordered_json::object();
  std::map<std::string, std::string, std::less<>> places;
};

/// Text of a TOML document → tree. `name` stands in the places and in faults.
/// Throws InvalidInput with the line of a syntax error, or of a date (no case has dates).
ValueTree parse_toml(std::string_view text, const std::string& name);

/// One TOML value, as it stands behind a "=": "3.5", "[1, 2]", "\"slot\"". Plain words are strings.
nlohmann::ordered_json parse_toml_value(const std::string& text);

}  // namespace osteomill::io
