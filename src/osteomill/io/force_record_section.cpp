// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/io/force_record_file.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

/// T from the sensor's axes: row k is the signed sensor axis that is axis k of T.
Eigen::Matrix3d mapping(const std::vector<std::string>& axes) {
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  for (Eigen::Index row = 0; row < 3 && axes.size() == 3; ++row) {
    std::string_view axis = axes[static_cast<std::size_t>(row)];
    const double sign = axis.starts_with('-') ? -1.0 : 1.0;
    if (axis.starts_with('-') || axis.starts_with('+')) axis.remove_prefix(1);
    if (axis.size() == 1 && axis[0] >= 'x' && axis[0] <= 'z') out(row, axis[0] - 'x') = sign;
  }
  if (std::abs(std::abs(out.determinant()) - 1.0) > 1e-9) {
    throw InvalidInput({"record.axes", fmt::format("[{}]", fmt::join(axes, ", ")),
                        "must name x, y and z of the sensor once each, with a sign or without",
                        "for example [\"x\", \"-y\", \"-z\"]"});
  }
  return out;
}

}  // namespace

Eigen::Matrix3d to_tool_frame(const RecordFormat& format) {
  return (format.on_workpiece ? -1.0 : 1.0) * mapping(format.axes);
}

void bind_record_format(Section& section, RecordFormat& format) {
  section.table(
      "record", "how the records are laid out; what is left out is taken from the file",
      Need::optional, [&](Section& s) {
        s.choice<RecordKind>("kind", format.kind,
                             {{"automatic", RecordKind::automatic},
                              {"csv", RecordKind::csv},
                              {"hdf5", RecordKind::hdf5},
                              {"matlab", RecordKind::matlab},
                              {"dynoware", RecordKind::dynoware}},
                             "file format; automatic: by the suffix and the header",
                             Need::optional);
        s.texts("columns", format.columns,
                "columns of the sensor's x, y, z, or the one matrix that holds them",
                Need::optional);
        if (!format.columns.empty() && format.columns.size() != 3 && format.columns.size() != 1)
          s.fault("columns", "must be three names, or one of a matrix");
        s.text("time", format.time, "time column; \"none\": not to be used", Need::optional);
        s.text("time_unit", format.time_unit, "s, ms or us", Need::optional);
        s.text("tacho", format.tacho, "column of the once-per-revolution pulse", Need::optional);
        s.text("torque", format.torque, "column of the torque about the axis", Need::optional);
        s.text("separator", format.separator, "of text: a tab, ; , or a space", Need::optional);
        s.integer("header_lines", format.header_lines, non_negative(),
                  "of text: lines that are no numbers whatever they look like", Need::optional);
        s.number("rate_hz", format.rate, {1.0, "Hz"}, positive(), "samples a second");
        s.text("unit", format.unit, "of the forces: N, kN, lbf, mV", Need::optional);
        s.numbers("sensitivity_mv_per_n", format.sensitivity_mv_per_n, {1.0, "mV/N"}, positive(),
                  "of mV, one number or one an axis", Need::optional);
        s.texts("axes", format.axes, "sensor axes that are x, y, z of the tool, as \"-y\"",
                Need::optional);
        try {
          to_tool_frame(format);
        } catch (const InvalidInput& error) {
          s.fault("axes", error.faults()[0].rule, error.faults()[0].remedy);
        }
        s.flag("on_workpiece", format.on_workpiece,
               "the sensor shows the force on the bone: signs are turned");
        s.numbers("range_n", format.range, {1.0, "N"}, positive(),
                  "of the sensor, one number or one an axis: samples there are refused",
                  Need::optional);
        s.flag("allow_saturation", format.allow_saturation, "only warn of samples at the range");
        s.choice<GapPolicy>(
            "gaps", format.gaps,
            {{"refuse", GapPolicy::refuse}, {"interpolate", GapPolicy::interpolate}},
            "missing samples", Need::optional);
        s.integer("longest_gap_samples", format.longest_gap_samples, between(1, 1000),
                  "that interpolate bridges", Need::optional);
        s.numbers("tare_n", format.tare, {1.0, "N"}, any(), "of the sensor's axes, taken away",
                  Need::optional);
        s.number("mass_kg", format.mass, {1.0, "kg"}, non_negative(), "of what hangs on the sensor",
                 Need::optional);
        s.triple("down", format.down, {}, any(), "direction of gravity in the sensor's axes",
                 Need::optional);
        s.text("turning", format.turning, "column of the sensor's angle, for one that turns",
               Need::optional);
        s.triple("turning_axis", format.turning_axis, {}, any(), "in the sensor's axes",
                 Need::optional);
        for (const auto& [key, count] :
             {std::pair{"sensitivity_mv_per_n", format.sensitivity_mv_per_n.size()},
              std::pair{"range_n", format.range.size()}, std::pair{"tare_n", format.tare.size()}}) {
          if (count != 0 && count != 1 && count != 3) s.fault(key, "must be one number or three");
        }
      });
}

}  // namespace osteomill::io
