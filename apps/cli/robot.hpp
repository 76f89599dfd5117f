// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include "command.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/robot/implant.hpp"

/// What the `osteomill robot …` commands share.
namespace osteomill::cli {

/// Adds `osteomill robot NAME`.
CLI::App* add_robot_command(CLI::App& program, const char* name, const char* about);

inline nlohmann::ordered_json millimetres(const robot::Vector2& p) {
  return {{"x", p.x() / units::mm}, {"y", p.y() / units::mm}};
}

inline std::string fixed(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

/// Prints a result in the chosen format, and writes it as result.json when there is a directory.
void print_result(const CaseArguments& arguments, const nlohmann::ordered_json& document,
                  const std::vector<std::vector<std::string>>& rows);

/// "generic, size 4" is assumed, not measured: says so when it is.
void warn_of_assumed(const std::string& name, const std::string& obtained);

}  // namespace osteomill::cli
