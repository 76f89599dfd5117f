// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/force_record_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/baseline.hpp"
#include "osteomill/identify/record_check.hpp"
#include "osteomill/io/force_record_table.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using Names = std::vector<std::string>;

/// Letters and digits of a name, without groups or structures, in small letters.
std::string canonical(std::string_view name) {
  const auto last = name.find_last_of("./");
  if (last != std::string_view::npos) name.remove_prefix(last + 1);
  std::string out;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return out;
}

std::string what_is_there(const RecordTable& table) {
  Names names;
  for (const RecordChannel& channel : table.channels) names.push_back(channel.name);
  return names.empty() ? "the file holds no columns of numbers"
                       : fmt::format("the file has {}", fmt::join(names, ", "));
}

/// The channel of a name: as written, otherwise by its last part; nothing when none fits.
const RecordChannel* find(const RecordTable& table, const std::string& name) {
  const RecordChannel* found = nullptr;
  for (const RecordChannel& channel : table.channels) {
    if (channel.name == name) return &channel;
    if (canonical(channel.name) != canonical(name)) continue;
    if (found != nullptr) {
      throw InvalidInput({"record.columns", name,
                          fmt::format("fits both {} and {}", found->name, channel.name),
                          "give the whole name", table.file});
    }
    found = &channel;
  }
  return found;
}

const RecordChannel& needed(const RecordTable& table, const char* key, const std::string& name) {
  if (const RecordChannel* found = find(table, name)) return *found;
  throw InvalidInput({key, name, "is not there", what_is_there(table), table.file});
}

/// The first of some usual names that is there.
const RecordChannel* first_of(const RecordTable& table, const Names& names) {
  for (const std::string& name : names) {
    if (const RecordChannel* found = find(table, name)) return found;
  }
  return nullptr;
}

/// A column that may be named, found by itself, or be wanted not to be used ("none").
const RecordChannel* optional_column(const RecordTable& table, const char* key,
                                     const std::string& name, const Names& usual) {
  if (name == "none") return nullptr;
  return name.empty() ? first_of(table, usual) : &needed(table, key, name);
}

std::array<const RecordChannel*, 3> force_columns(const RecordTable& table,
                                                  const RecordFormat& format) {
  std::array<const RecordChannel*, 3> out{};
  if (format.columns.size() == 3) {
    FaultList faults;
    for (std::size_t k = 0; k < 3; ++k)
      faults.gather([&] { out[k] = &needed(table, "record.columns", format.columns[k]); });
    faults.raise();
    return out;
  }
  if (format.columns.size() == 1) {
    std::size_t k = 0;
    for (const RecordChannel& channel : table.channels) {
      if (channel.origin == format.columns[0] && k < 3) out[k++] = &channel;
    }
    if (k == 3) return out;
    throw InvalidInput({"record.columns", format.columns[0],
                        "is no matrix with three columns or rows", what_is_there(table),
                        table.file});
  }
  for (const auto& [x, y, z] :
       {std::array{"fx", "fy", "fz"}, std::array{"forcex", "forcey", "forcez"},
        std::array{"xforce", "yforce", "zforce"}, std::array{"force1", "force2", "force3"},
        std::array{"f1", "f2", "f3"}}) {
    out = {first_of(table, {x}), first_of(table, {y}), first_of(table, {z})};
    if (out[0] != nullptr && out[1] != nullptr && out[2] != nullptr) return out;
  }
  throw InvalidInput({"record.columns", "", "the columns of the three forces are not to be told",
                      fmt::format("name them in record.columns; {}", what_is_there(table)),
                      table.file});
}

std::string place_of(const RecordTable& table, Eigen::Index sample) {
  return table.first_line > 0 ? fmt::format("{}, sample {} (line {} or behind)", table.file, sample,
                                            table.first_line + sample)
                              : fmt::format("{}, sample {}", table.file, sample);
}

/// A channel in N.
Eigen::VectorXd newtons(const RecordTable& table, const RecordChannel& channel, std::size_t axis,
                        const RecordFormat& format) {
  const std::string unit = format.unit.empty() ? channel.unit : format.unit;
  if (const auto factor = unit_factor(UnitKind::force, unit)) return channel.values * *factor;
  if (const auto volts = unit_factor(UnitKind::voltage, unit)) {
    const auto& given = format.sensitivity_mv_per_n;
    if (given.empty()) {
      throw InvalidInput({"record.sensitivity_mv_per_n", "",
                          fmt::format("is missing for {}, which is in {}", channel.name, unit),
                          "give the millivolts of a newton, one number or one an axis",
                          table.file});
    }
    const double sensitivity = given.size() == 1 ? given[0] : given[axis];
    return channel.values * (*volts / (sensitivity * 1e-3));
  }
  throw InvalidInput(
      {"record.unit", unit,
       unit.empty() ? fmt::format("the file does not say what {} is measured in", channel.name)
                    : fmt::format("is no unit of force ({})", channel.name),
       "set record.unit to N, kN, lbf or mV", table.file});
}

/// Values that are not finite: a fault, or straight lines over short stretches.
Eigen::Index mend(const RecordTable& table, const std::string& name, Eigen::VectorXd& values,
                  const RecordFormat& format, std::vector<Fault>& faults) {
  Eigen::Index count = 0, first = -1, longest = 0;
  const Eigen::Index n = values.size();
  for (Eigen::Index i = 0; i < n;) {
    if (std::isfinite(values[i])) {
      ++i;
      continue;
    }
    Eigen::Index end = i;
    while (end < n && !std::isfinite(values[end])) ++end;
    if (first < 0) first = i;
    count += end - i;
    longest = std::max(longest, end - i);
    if (i > 0 && end < n) {
      const double from = values[i - 1],
                   step = (values[end] - from) / static_cast<double>(end - i + 1);
      for (Eigen::Index k = i; k < end; ++k)
        values[k] = from + step * static_cast<double>(k - i + 1);
    } else {
      longest = n;  // nothing on one side to go to
    }
    i = end;
  }
  const bool bridged =
      format.gaps == GapPolicy::interpolate && longest <= format.longest_gap_samples;
  if (count > 0 && !bridged) {
    faults.push_back({name, fmt::format("{} of {} values", count, n), "are empty or not finite",
                      format.gaps == GapPolicy::interpolate
                          ? fmt::format("a stretch is longer than {} samples or lies at an end",
                                        format.longest_gap_samples)
                          : "cut them out, or set record.gaps = \"interpolate\" for short ones",
                      place_of(table, first)});
  }
  return count;
}

/// Channels on their way to a record, all of one length.
struct Work {
  Eigen::MatrixX3d force;  // sensor axes, N
  Eigen::VectorXd tacho = {}, torque = {}, turning = {}, time = {};
};

/// Puts straight lines where samples are missing in all channels.
void bridge(Work& work, const identify::TimeCheck& check) {
  std::vector<Eigen::Index> missing(static_cast<std::size_t>(work.time.size()), 0);
  Eigen::Index total = work.time.size();
  for (const identify::Segment& gap : check.gaps) {
    const double step = work.time[gap.begin + 1] - work.time[gap.begin];
    const auto count = static_cast<Eigen::Index>(std::lround(step * check.rate)) - 1;
    missing[static_cast<std::size_t>(gap.begin)] = count;
    total += count;
  }
  const auto fill = [&](const auto& from) {
    Eigen::VectorXd out(total);
    Eigen::Index at = 0;
    for (Eigen::Index i = 0; i < from.size(); ++i) {
      out[at++] = from[i];
      const Eigen::Index count = missing[static_cast<std::size_t>(i)];
      for (Eigen::Index k = 1; k <= count; ++k)
        out[at++] = from[i] + (from[i + 1] - from[i]) * static_cast<double>(k) /
                                  static_cast<double>(count + 1);
    }
    return out;
  };
  Eigen::MatrixX3d force(total, 3);
  for (int axis = 0; axis < 3; ++axis) force.col(axis) = fill(work.force.col(axis));
  work.force = force;
  if (work.tacho.size() > 0) work.tacho = fill(work.tacho);
  if (work.torque.size() > 0) work.torque = fill(work.torque);
  if (work.turning.size() > 0) work.turning = fill(work.turning);
}

double rate_of(const RecordTable& table, const RecordFormat& format, Work& work,
               LoadedRecord& out) {
  std::optional<double> rate = format.rate ? format.rate : table.rate;
  const char* source = format.rate ? "record.rate_hz" : "the file's header";
  // Rates that are rounded differ by less.
  const auto differ = [](double a, double b) { return std::abs(a / b - 1.0) > 5e-3; };
  if (format.rate && table.rate && differ(*format.rate, *table.rate)) {
    throw InvalidInput({"record.rate_hz", fmt::format("{:g} Hz", *format.rate),
                        fmt::format("is not what the file says, {:g} Hz", *table.rate),
                        "take the one that is right", table.file});
  }
  if (work.time.size() > 0) {
    identify::TimeCheck check;
    try {
      check = identify::check_time(work.time);
    } catch (const InvalidInput& error) {
      Fault fault = error.faults().front();
      fault.location = table.file;
      throw InvalidInput(fault);
    }
    if (rate && differ(*rate, check.rate)) {
      throw InvalidInput(
          {"record.rate_hz", fmt::format("{:g} Hz ({})", *rate, source),
           fmt::format("does not agree with the time column, which has {:.6g} samples a second",
                       check.rate),
           "correct the rate, the unit of time (record.time_unit), or set record.time = \"none\"",
           table.file});
    }
    if (!rate) {
      rate = check.rate;
      source = "the time column";
    }
    if (!check.gaps.empty()) {
      const identify::Segment& first = check.gaps.front();
      double longest = 0.0;
      for (const identify::Segment& gap : check.gaps)
        longest = std::max(
            longest, std::round((work.time[gap.begin + 1] - work.time[gap.begin]) * *rate) - 1);
      if (format.gaps == GapPolicy::refuse || longest > format.longest_gap_samples) {
        throw InvalidInput(
            {"time",
             fmt::format("{} gaps, {:.0f} samples missing, {:.0f} in a row at most",
                         check.gaps.size(), check.missing, longest),
             fmt::format("must be without gaps; the first lies between {:.6g} and {:.6g} s",
                         work.time[first.begin], work.time[first.begin + 1]),
             "cut the record there, or set record.gaps = \"interpolate\" for short ones",
             place_of(table, first.begin)});
      }
      check.rate = *rate;
      bridge(work, check);
      out.warnings.push_back(
          fmt::format("{}: {:.0f} missing samples in {} gaps bridged by straight "
                      "lines",
                      table.file, check.missing, check.gaps.size()));
    }
  }
  if (!rate || !(*rate > 0.0)) {
    throw InvalidInput({"record.rate_hz", "",
                        "is missing: the file has neither a time column nor a rate",
                        "give the samples a second", table.file});
  }
  out.notes.push_back(fmt::format("{:g} samples a second, from {}", *rate, source));
  return *rate;
}

Eigen::Vector3d one_or_three(const std::vector<double>& values) {
  if (values.empty()) return Eigen::Vector3d::Zero();
  if (values.size() == 1) return Eigen::Vector3d::Constant(values[0]);
  return {values[0], values[1], values[2]};
}

void check_saturation(const RecordTable& table, const RecordFormat& format, const Work& work,
                      double rate, LoadedRecord& out) {
  const auto found =
      identify::find_saturation({.rate = rate, .force = work.force}, one_or_three(format.range));
  for (const identify::Saturation& one : found) {
    const std::string what = fmt::format(
        "sensor axis {}: {} samples in {} runs at {:.6g} N, the first at {:.4f} s", "xyz"[one.axis],
        one.samples, one.runs.size(), one.level, static_cast<double>(one.runs[0].begin) / rate);
    if (!format.range.empty() && !format.allow_saturation) {
      throw InvalidInput({"record.range_n", what, "is the end of the sensor's range",
                          "take a wider range and cut again, or set record.allow_saturation = true "
                          "to use it nevertheless",
                          table.file});
    }
    out.warnings.push_back(fmt::format(
        "{}: {}: the sensor seems to have reached the end of its range", table.file, what));
  }
}

RecordTable read_table(const std::filesystem::path& file, const RecordFormat& format) {
  RecordKind kind = format.kind;
  if (kind == RecordKind::automatic) {
    std::string suffix = file.extension().string();
    for (char& c : suffix) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    kind = suffix == ".mat"                                          ? RecordKind::matlab
           : suffix.starts_with(".h5") || suffix.starts_with(".hdf") ? RecordKind::hdf5
                                                                     : RecordKind::csv;
  }
  if (kind == RecordKind::csv || kind == RecordKind::dynoware)
    return parse_text_record(read_text_file(file), file.filename().string(), format);
  if (!std::filesystem::is_regular_file(file))
    throw InvalidInput({file.string(), "", "there is no such file", "check the name"});
  return kind == RecordKind::matlab ? read_matlab_record(file) : read_hdf5_record(file);
}

/// A DynoWare export says how long it was measured.
void check_complete(const RecordTable& table, double rate, Eigen::Index samples) {
  if (!table.dynoware || !table.measuring_time) return;
  const double there = static_cast<double>(samples) / rate;
  // The last sample may or may not be counted in.
  if (there > *table.measuring_time - 2.5 / rate) return;
  throw InvalidInput({"measuring time", fmt::format("{:g} s", *table.measuring_time),
                      fmt::format("but the samples end after {:.4f} s: the file is cut off", there),
                      "export it again", table.file});
}

}  // namespace

LoadedRecord read_force_record(const std::filesystem::path& file, const RecordFormat& format) {
  const RecordTable table = read_table(file, format);
  const auto columns = force_columns(table, format);
  const RecordChannel* time =
      optional_column(table, "record.time", format.time, {"time", "t", "times", "zeit"});
  const RecordChannel* tacho = optional_column(
      table, "record.tacho", format.tacho, {"tacho", "tach", "tachometer", "pulse", "keyphasor"});
  const RecordChannel* torque = optional_column(table, "record.torque", format.torque,
                                                {"torque", "mz", "momentz", "torquez", "tz"});
  LoadedRecord out;
  Work work;
  std::vector<Fault> faults;
  const Eigen::Index n = columns[0]->values.size();
  const auto take = [&](const RecordChannel& channel, Eigen::VectorXd values) {
    if (values.size() != n) {
      throw InvalidInput({channel.name, fmt::format("{} values", values.size()),
                          fmt::format("must be as many as {}, {}", columns[0]->name, n), "",
                          table.file});
    }
    const Eigen::Index mended = mend(table, channel.name, values, format, faults);
    if (mended > 0)
      out.warnings.push_back(fmt::format("{}: {} values of {} bridged by straight lines",
                                         table.file, mended, channel.name));
    return values;
  };
  const auto in_unit = [&](const RecordChannel& channel, UnitKind kind, const std::string& given,
                           const char* key, const char* usual) {
    const std::string unit = !given.empty() ? given : channel.unit.empty() ? usual : channel.unit;
    const auto factor = unit_factor(kind, unit);
    if (!factor)
      throw InvalidInput({key, unit, fmt::format("is no unit that {} can have", channel.name),
                          fmt::format("for example {}", usual), table.file});
    return take(channel, channel.values * *factor);
  };
  work.force.resize(n, 3);
  for (std::size_t axis = 0; axis < 3; ++axis)
    work.force.col(static_cast<Eigen::Index>(axis)) =
        take(*columns[axis], newtons(table, *columns[axis], axis, format));
  if (time != nullptr)
    work.time = in_unit(*time, UnitKind::time, format.time_unit, "record.time_unit", "s");
  if (tacho != nullptr) work.tacho = take(*tacho, tacho->values);
  if (torque != nullptr)
    work.torque = in_unit(*torque, UnitKind::moment, "", "record.torque", "N m");
  if (!format.turning.empty())
    work.turning = in_unit(needed(table, "record.turning", format.turning), UnitKind::angle, "",
                           "record.turning", "deg");
  if (!faults.empty()) throw InvalidInput(std::move(faults));

  out.notes.push_back(fmt::format("{}: {}, {} samples, forces from {}, {}, {}", table.file,
                                  table.dynoware ? "DynoWare " + table.format : table.format, n,
                                  columns[0]->name, columns[1]->name, columns[2]->name));
  const double rate = rate_of(table, format, work, out);
  check_complete(table, rate, n);
  check_saturation(table, format, work, rate, out);
  if (!format.tare.empty()) {
    const Eigen::RowVector3d tare = one_or_three(format.tare).transpose();
    work.force.rowwise() -= tare;
    out.notes.push_back(
        fmt::format("tare ({:g}, {:g}, {:g}) N taken away", tare[0], tare[1], tare[2]));
  }
  if (format.mass > 0.0) {
    const Eigen::Vector3d down =
        Eigen::Vector3d(format.down[0], format.down[1], format.down[2]).normalized();
    const Eigen::Vector3d axis(format.turning_axis[0], format.turning_axis[1],
                               format.turning_axis[2]);
    identify::remove_gravity(work.force, format.mass,
                             work.turning.size() > 0
                                 ? identify::turned_down(down, axis, work.turning)
                                 : Eigen::MatrixX3d(down.transpose()));
    out.notes.push_back(fmt::format("weight of {:g} kg taken away{}", format.mass,
                                    work.turning.size() > 0 ? ", turning with the sensor" : ""));
  }
  out.record = {.rate = rate,
                .force = work.force * to_tool_frame(format).transpose(),
                .tacho = work.tacho,
                .torque = work.torque};
  out.notes.push_back(fmt::format("axes of the tool: {}{}", fmt::join(format.axes, ", "),
                                  format.on_workpiece ? ", force on the bone turned round" : ""));
  return out;
}

}  // namespace osteomill::io
