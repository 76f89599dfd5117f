// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include "documents.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/robot/implant.hpp"

/// What the `osteomill robot ...` commands share.
namespace osteomill::cli {

/// Adds `osteomill robot NAME`, which shows the runs of its case. What `solve` writes into its
/// second argument is why there is no solution: everything is shown, then the program ends so.
void add_robot_command(
    CLI::App& program, const char* name, const char* about,
    const std::function<Shown(const io::CaseRun&, std::string& no_solution)>& solve);

inline nlohmann::ordered_json millimetres(const robot::Vector2& p) {
  return {{"x", p.x() / units::mm}, {"y", p.y() / units::mm}};
}

inline nlohmann::ordered_json xyz(const Eigen::Vector3d& p, double unit) {
  return {{"x", p.x() / unit}, {"y", p.y() / unit}, {"z", p.z() / unit}};
}

inline std::string fixed(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

/// Says so when an implant's dimensions are assumed.
void warn_of_assumed(const std::string& name, const std::string& obtained, Shown& shown);

}  // namespace osteomill::cli
