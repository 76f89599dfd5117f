// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/geometry/pose.hpp"

namespace osteomill::io {

/// One experiment as the table has it, in SI; what the table leaves out comes from the case.
struct TestRow {
  int line = 0;      ///< of the table
  std::string name;  ///< column name or experiment; otherwise its number
  std::string group;
  std::string cutter;              ///< name of a catalogue entry; empty: the case's
  std::optional<double> diameter;  ///< m
  std::optional<int> flutes;
  std::optional<double> axial_depth;     ///< m
  std::optional<double> radial_depth;    ///< m
  std::optional<double> feed_per_tooth;  ///< m
  std::optional<double> feed_rate;       ///< m/s
  std::optional<double> spindle_speed;   ///< rad/s
  std::optional<double> fibre_angle;     ///< rad
  std::optional<cutting::ImmersionKind> immersion;
  std::filesystem::path record;  ///< relative to the table; empty: mean forces are given
  std::optional<geometry::Vector3> mean_force;      ///< as written, in the sensor's axes, N
  std::optional<geometry::Vector3> standard_error;  ///< N
};

/// A table of experiments, one a row. Columns, each with its unit as suffix: axial_depth_mm or _um,
/// radial_depth_mm, feed_per_tooth_mm or _um, feed_rate_mm_per_min or _mm_per_s,
/// spindle_speed_rpm, diameter_mm, fibre_angle_deg, flutes, cutter, immersion, name, group, record,
/// mean_force_{x,y,z}_n or _kn or _lbf, standard_error_{x,y,z}_n. Other columns are kept out.
/// Throws InvalidInput with all faults and their lines.
std::vector<TestRow> read_test_table(const std::filesystem::path& file);

}  // namespace osteomill::io
