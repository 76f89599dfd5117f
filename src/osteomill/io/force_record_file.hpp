// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/identify/force_record.hpp"

/// Force records of a laboratory: text tables, HDF5, MATLAB, Kistler DynoWare.
namespace osteomill::io {

class Section;

enum class RecordKind { automatic, csv, hdf5, matlab, dynoware };

enum class GapPolicy {
  refuse,       ///< a record with missing samples is an error
  interpolate,  ///< short gaps are bridged by straight lines, and said
};

/// [record]: how the records of a case are laid out. What is left empty is taken from the file.
struct RecordFormat {
  RecordKind kind = RecordKind::automatic;  ///< by the file's suffix and first line
  std::vector<std::string>
      columns;                 ///< of the sensor's x, y, z; or one, of a matrix; empty: by name
  std::string time;            ///< empty: "time", "t" and the like, if there
  std::string tacho;           ///< empty: "tacho" and the like, if there
  std::string torque;          ///< empty: "torque", "Mz" and the like, if there
  std::string separator;       ///< empty: the one that fits
  int header_lines = 0;        ///< of text, that are no numbers whatever they look like
  std::optional<double> rate;  ///< Hz
  std::string unit;            ///< N, kN, lbf, mV; empty: as the file says, otherwise a fault
  std::vector<double> sensitivity_mv_per_n;  ///< one, or one an axis; with mV
  std::string time_unit;                     ///< s, ms; empty: as the file says, otherwise s
  /// Which sensor axis with which sign is x, y, z of the tool frame: {"x", "-y", "z"}.
  std::vector<std::string> axes = {"x", "y", "z"};
  bool on_workpiece = false;  ///< the sensor shows the force on the bone: all signs are turned
  std::vector<double> range;  ///< N, of the sensor's axes; empty: not known
  bool allow_saturation = false;
  GapPolicy gaps = GapPolicy::refuse;
  int longest_gap_samples = 10;  ///< that interpolate bridges
  std::vector<double> tare;      ///< N, of the sensor's axes, taken away; empty: none
  double mass = 0.0;             ///< kg, of what hangs on the sensor
  std::array<double, 3> down = {0.0, 0.0, -1.0};  ///< direction of gravity in the sensor's axes
  std::string turning;  ///< column with the sensor's angle, deg; empty: it stands
  std::array<double, 3> turning_axis = {0.0, 0.0, 1.0};  ///< of the sensor
};
void bind_record_format(Section& section, RecordFormat& format);

/// F_T = result × F_sensor: `axes`, and the sign of `on_workpiece`.
Eigen::Matrix3d to_tool_frame(const RecordFormat& format);

struct LoadedRecord {
  identify::ForceRecord record;       ///< in T, N; gravity and a given tare away
  std::vector<std::string> notes;     ///< what was read and done
  std::vector<std::string> warnings;  ///< what a result that uses it has to say
};

/// Throws InvalidInput, with the file's name, for what cannot be read or is no steady record.
LoadedRecord read_force_record(const std::filesystem::path& file, const RecordFormat& format = {});

}  // namespace osteomill::io
