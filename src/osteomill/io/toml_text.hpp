// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace osteomill::io {

/// A tree of values as TOML: plain keys first, then tables below their headings, lists of tables
/// inline. Null values are left out. Numbers are written so that they read back the same.
std::string toml_text(const nlohmann::ordered_json& table);

}  // namespace osteomill::io
