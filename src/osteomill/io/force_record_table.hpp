// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "osteomill/io/force_record_file.hpp"

/// What the readers of the formats have in common: named channels, as the file has them.
namespace osteomill::io {

struct RecordChannel {
  std::string name;  ///< without its unit; "group/name" and "struct.name" where the file nests
  std::string unit;  ///< as the file says it; empty when it does not
  Eigen::VectorXd values;
  std::string origin = {};  ///< "columns of force" of one matrix share this; otherwise empty
};

struct RecordTable {
  std::string file;    ///< for messages
  std::string format;  ///< "text, separated by ;", "MATLAB 5"
  std::vector<RecordChannel> channels;
  std::optional<double> rate;  ///< as the file states it, Hz
  int first_line = 0;          ///< of text: where sample 0 stands
  bool dynoware = false;
  std::optional<double> measuring_time;  ///< as the file states it, s
};

/// Numbers in columns below any number of header lines. The separator is a tab, a semicolon, a
/// comma or spaces; with all but the comma, numbers may have a decimal comma. Names stand in the
/// last line with as many cells as the numbers, units in a line of their own below, or behind the
/// names: "Fx [N]", "Fx (N)", "Fx / N", "force_x_n". The sampling rate and the measuring time may
/// stand in the header. Throws InvalidInput with the lines that do not fit.
RecordTable parse_text_record(std::string_view text, const std::string& name,
                              const RecordFormat& format);

/// Every data set with one or two dimensions, with its attribute unit or units; the rate from an
/// attribute rate_hz, sampling_rate_hz, sampling_rate, sample_rate, fs of it, its group or the
/// file.
RecordTable read_hdf5_record(const std::filesystem::path& file);

/// Every numeric vector or matrix, also in structures; MATLAB 5 to 7.3. A number called rate,
/// rate_hz, sampling_rate, sample_rate, sampling_rate_hz or fs is the rate.
RecordTable read_matlab_record(const std::filesystem::path& file);

/// Splits "Fx [N]", "Fx (N)", "Fx / N", "force_x_n" into name and unit; the unit is empty where
/// none of the known ones stands there.
void split_unit(const std::string& heading, std::string& name, std::string& unit);

/// A factor to N, s, N m, rad or V of a unit of that kind; nothing when it is none.
enum class UnitKind { force, time, moment, angle, voltage };
std::optional<double> unit_factor(UnitKind kind, std::string_view unit);

/// Adds the columns of a matrix as channels name(1), name(2), …; a row counts as a column, and a
/// matrix with more columns than rows is turned.
void add_channels(RecordTable& table, const std::string& name, const std::string& unit,
                  const Eigen::MatrixXd& values);

/// Whether a channel of this name states the sampling rate.
bool names_a_rate(std::string_view name);

}  // namespace osteomill::io
