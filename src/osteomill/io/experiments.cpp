// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/experiments.hpp"

#include <fmt/format.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/catalogue.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/test_table.hpp"

namespace osteomill::io {
namespace {

cutting::Cutter cutter_of(const TestRow& row, const cutting::Cutter& otherwise) {
  cutting::Cutter cutter = otherwise;
  if (!row.cutter.empty()) {
    CutterCase entry;
    CaseRun run;
    run.tree.values["cutter"] = catalogue_entry("cutters", row.cutter).values;
    Section::read(run, [&](Section& section) { bind_cutter(section, entry); });
    cutter = entry.cutter;
  }
  if (row.diameter) cutter.radius = 0.5 * *row.diameter;
  if (row.flutes) cutter.flutes = *row.flutes;
  cutting::check(cutter);
  return cutter;
}

/// What of the table or the case; a fault where neither has it.
double either(const std::optional<double>& of_row, double of_case, const char* key) {
  if (of_row) return *of_row;
  if (of_case > 0.0) return of_case;
  throw InvalidInput({key, "", "is missing", "add the column to the table, or the key to [cut]"});
}

identify::Experiment experiment_of(const TestRow& row, const ExperimentDefaults& defaults) {
  identify::Experiment out;
  out.name = row.name;
  out.group = row.group;
  out.cutter = cutter_of(row, defaults.cutter);
  out.condition.fibre_T = cutting::fibre_at_angle(row.fibre_angle.value_or(defaults.fibre_angle));
  out.immersion = defaults.immersion;
  if (row.immersion) out.immersion.kind = *row.immersion;
  if (row.radial_depth) out.immersion.radial_depth = *row.radial_depth;
  FaultList faults;
  faults.gather([&] {
    out.immersion.axial_depth =
        either(row.axial_depth, defaults.immersion.axial_depth, "axial_depth_mm");
  });
  faults.gather([&] {
    out.condition.spindle_speed =
        either(row.spindle_speed, defaults.spindle_speed, "spindle_speed_rpm");
    const double speed = out.condition.spindle_speed;
    const double by_rate =
        row.feed_rate ? cutting::feed_per_tooth(*row.feed_rate, speed, out.cutter.flutes) : 0.0;
    out.condition.feed_per_tooth =
        row.feed_rate && !row.feed_per_tooth
            ? by_rate
            : either(row.feed_per_tooth, defaults.feed_per_tooth, "feed_per_tooth_mm");
    // Printed tables round the feed a tooth to two digits or more.
    if (row.feed_rate && std::abs(by_rate / out.condition.feed_per_tooth - 1.0) > 0.05) {
      throw InvalidInput(
          {"feed_rate", fmt::format("{:g} mm/min", *row.feed_rate / units::mm_per_min),
           fmt::format("does not go with the rest: with {} flutes at {:.0f} rpm, {:g} mm/min make "
                       "{:.4g} um a tooth, but feed_per_tooth is {:.4g} um",
                       out.cutter.flutes, speed / units::rpm, *row.feed_rate / units::mm_per_min,
                       by_rate / units::um, out.condition.feed_per_tooth / units::um),
           "correct one of them, the speed or the number of flutes"});
    }
  });
  faults.raise();
  faults.gather([&] { cutting::check(out.condition, out.cutter); });
  faults.gather([&] { cutting::check(out.immersion, out.cutter); });
  faults.raise();
  return out;
}

void take_means(const TestRow& row, const Eigen::Matrix3d& R_TS, identify::Experiment& out) {
  out.mean_force = R_TS * *row.mean_force;
  if (row.standard_error) out.standard_error = R_TS.cwiseAbs() * *row.standard_error;
}

void take_record(const TestRow& row, const ExperimentsCase& from,
                 const identify::SignalChain& chain, const RecordSeen& seen,
                 LoadedExperiment& out) {
  LoadedRecord loaded = read_force_record(row.record, from.format);
  out.record_file = row.record;
  out.notes = std::move(loaded.notes);
  out.warnings = std::move(loaded.warnings);
  out.processed = identify::process(loaded.record,
                                    {.spindle_speed = out.experiment.condition.spindle_speed,
                                     .flutes = out.experiment.cutter.flutes},
                                    chain);
  const identify::ProcessedRecord& done = *out.processed;
  out.notes.insert(out.notes.end(), done.steps.begin(), done.steps.end());
  for (const std::string& warning : done.warnings)
    out.warnings.push_back(fmt::format("{}: {}", row.name, warning));
  identify::take_means(done, chain.baseline, out.experiment);
  if (seen) seen(loaded.record, out);
}

}  // namespace

std::vector<LoadedExperiment> load_experiments(const ExperimentsCase& experiments,
                                               const ExperimentDefaults& defaults,
                                               const RecordSeen& seen) {
  const std::vector<TestRow> rows = read_test_table(experiments.table);
  identify::SignalChain chain = experiments.signals.chain;
  if (!experiments.signals.dynamometer_frf.empty())
    chain.dynamometer = read_dynamometer(experiments.signals.dynamometer_frf);
  const Eigen::Matrix3d R_TS = to_tool_frame(experiments.format);
  std::vector<LoadedExperiment> out;
  std::vector<Fault> faults;
  for (const TestRow& row : rows) {
    try {
      LoadedExperiment one;
      one.experiment = experiment_of(row, defaults);
      if (row.mean_force) {
        take_means(row, R_TS, one.experiment);
      } else {
        take_record(row, experiments, chain, seen, one);
      }
      out.push_back(std::move(one));
    } catch (const InvalidInput& error) {
      // Each fault says which row it comes from.
      const std::string line =
          fmt::format("{}:{}", experiments.table.filename().string(), row.line);
      for (Fault fault : error.faults()) {
        fault.location =
            fault.location.empty() ? line : fmt::format("{} ({})", line, fault.location);
        faults.push_back(std::move(fault));
      }
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return out;
}

}  // namespace osteomill::io
