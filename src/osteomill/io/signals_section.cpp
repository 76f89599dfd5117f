// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/io/csv_file.hpp"
#include "osteomill/io/experiments.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {

using identify::BaselineKind;
using identify::RotationSource;

void bind_signals(Section& section, SignalsCase& signals) {
  identify::SignalChain& c = signals.chain;
  section.table(
      "signals", "steps from a record to its mean force and mean revolution", Need::optional,
      [&](Section& s) {
        s.file("dynamometer_frf", signals.dynamometer_frf,
               "measured response of the dynamometer, taken out: frequency_hz, real_x, "
               "imaginary_x, …",
               Need::optional);
        s.number("noise_floor", c.compensation.noise_floor, {}, up_to(1.0),
                 "response below which the dynamometer shows noise", Need::optional);
        s.number("highest_hz", c.compensation.highest_hz, {1.0, "Hz"}, non_negative(),
                 "of the compensation; 0: the end of the response", Need::optional);
        s.choice<BaselineKind>("baseline", c.baseline,
                               {{"none", BaselineKind::none},
                                {"tare", BaselineKind::tare},
                                {"drift", BaselineKind::drift}},
                               "tare: mean of the idle parts away; drift: a line between them",
                               Need::optional);
        s.number("window_s", c.segments.window, {1.0, "s"}, non_negative(),
                 "of the level that tells cut from idle; 0: three revolutions", Need::optional);
        s.number("shortest_cut_s", c.segments.shortest_cut, {1.0, "s"}, positive(), "",
                 Need::optional);
        s.number("settle_band", c.segments.settle_band, {}, up_to(1.0),
                 "share of its median by which the level of a plateau may differ", Need::optional);
        s.number("contrast", c.segments.contrast, {}, Range{1.0},
                 "of cut over idle level, below which the whole record is the cut", Need::optional);
        s.number("guard_s", c.segments.guard, {1.0, "s"}, non_negative(),
                 "left out at both ends of the plateau", Need::optional);
        std::vector<double> plateau;
        s.numbers("plateau_s", plateau, {1.0, "s"}, non_negative(),
                  "beginning and end of the plateau, in place of finding it", Need::optional);
        if (plateau.size() == 2) {
          c.segments.plateau = {{plateau[0], plateau[1]}};
        } else if (!plateau.empty()) {
          s.fault("plateau_s", "must be two times");
        }
        s.integer("filter_order", c.filter_order, between(0, 50),
                  "of the zero-phase Butterworth filter, one pass; 0: none", Need::optional);
        s.number("cutoff_hz", c.cutoff_hz, {1.0, "Hz"}, non_negative(),
                 "of the filter; 0: by the tooth passing", Need::optional);
        s.number("cutoff_over_tooth_passing", c.cutoff_over_tooth_passing, {}, positive(),
                 "cut-off over the tooth-passing frequency", Need::optional);
        s.flag("envelope", c.envelope, "envelope of the plateau, for the figures");
        s.choice<RotationSource>("rotation", c.rotation,
                                 {{"automatic", RotationSource::automatic},
                                  {"tacho", RotationSource::tacho},
                                  {"line", RotationSource::line},
                                  {"speed", RotationSource::speed},
                                  {"none", RotationSource::none}},
                                 "angle from the pulse, the tooth-passing line or the stated "
                                 "speed; automatic: pulse, else line",
                                 Need::optional);
        s.number("line_search", c.line.search, {}, between(1e-3, 0.5),
                 "share about the stated speed within which the line is sought", Need::optional);
        s.number("line_block", c.line.block, {}, Range{4.0},
                 "tooth periods over which a phase of the line is measured", Need::optional);
        s.integer("bins", c.bins, between(0, 7200), "of the mean revolution; 0: by the rate",
                  Need::optional);
        s.flag("average_flutes", c.average_flutes,
               "run-out treatment: mean over the copies shifted by the pitch");
      });
}

void bind_experiments(Section& section, ExperimentsCase& experiments) {
  section.table("experiments", "what was measured", Need::required, [&](Section& s) {
    s.file("table", experiments.table,
           "CSV, one cut a row: condition with units, and a record or mean forces");
  });
  bind_record_format(section, experiments.format);
  bind_signals(section, experiments.signals);
}

identify::DynamometerResponse read_dynamometer(const std::filesystem::path& file) {
  const CsvFile table = read_csv(file);
  FaultList faults;
  const auto column = [&](const std::string& name, const std::string& otherwise) {
    std::vector<double> out;
    auto at = std::find(table.columns.begin(), table.columns.end(), name);
    if (at == table.columns.end())
      at = std::find(table.columns.begin(), table.columns.end(), otherwise);
    faults.gather([&] {
      if (at == table.columns.end()) {
        throw InvalidInput({name, "", "is missing",
                            "needs frequency_hz, real_x, imaginary_x and so on, or real and "
                            "imaginary",
                            table.name});
      }
      for (const CsvFile::Row& row : table.rows) {
        const std::string& cell = row.cells[static_cast<std::size_t>(at - table.columns.begin())];
        double value = 0.0;
        const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
        if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value)) {
          throw InvalidInput(
              {*at, cell, "must be a number", "", fmt::format("{}:{}", table.name, row.line)});
        }
        out.push_back(value);
      }
    });
    return out;
  };
  identify::DynamometerResponse out;
  out.frequency_hz = column("frequency_hz", "frequency_hz");
  std::array<std::vector<double>, 6> parts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    parts[2 * axis] = column(fmt::format("real_{}", "xyz"[axis]), "real");
    parts[2 * axis + 1] = column(fmt::format("imaginary_{}", "xyz"[axis]), "imaginary");
  }
  faults.raise();
  out.response.resize(static_cast<Eigen::Index>(out.frequency_hz.size()), 3);
  for (std::size_t k = 0; k < out.frequency_hz.size(); ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      out.response(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(axis)) = {
          parts[2 * axis][k], parts[2 * axis + 1][k]};
  }
  return out;
}

}  // namespace osteomill::io
