// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/identify/experiment.hpp"
#include "osteomill/identify/signal_chain.hpp"
#include "osteomill/io/cutting_section.hpp"
#include "osteomill/io/force_record_file.hpp"

/// From a test table with its records to experiments.
namespace osteomill::io {

class Section;

/// [signals]: the steps between a record and its mean force and mean revolution.
struct SignalsCase {
  identify::SignalChain chain;
  std::filesystem::path dynamometer_frf;  ///< empty: no compensation
};
void bind_signals(Section& section, SignalsCase& signals);

/// What a dynamometer shows over what is applied: columns frequency_hz and real_x, imaginary_x, and
/// so for y and z, or real and imaginary for all three.
identify::DynamometerResponse read_dynamometer(const std::filesystem::path& file);

/// [experiments], [record] and [signals] of a case.
struct ExperimentsCase {
  std::filesystem::path table;
  RecordFormat format;
  SignalsCase signals;
};
void bind_experiments(Section& section, ExperimentsCase& experiments);

/// What the case says where the table does not.
struct ExperimentDefaults {
  cutting::Cutter cutter;
  cutting::Immersion immersion = {};  ///< an axial depth of 0 must come from the table
  double spindle_speed = 0.0;         ///< rad/s; 0 must come from the table
  double feed_per_tooth = 0.0;        ///< m; 0 must come from the table
  double fibre_angle = 0.0;           ///< rad
};

/// An experiment and, where it came from a record, the record with its steps.
struct LoadedExperiment {
  identify::Experiment experiment;
  std::filesystem::path record_file;
  std::optional<identify::ProcessedRecord> processed;
  std::vector<std::string> notes;     ///< reading and processing, in order
  std::vector<std::string> warnings;  ///< of this experiment
};

/// Called with each record as it was read, before the chain, and what came out of it: for figures.
using RecordSeen = std::function<void(const identify::ForceRecord&, const LoadedExperiment&)>;

/// Reads the table and its records and runs the chain on each. Mean forces given in the table
/// are brought to the tool frame by `axes` and `on_workpiece` of the format, as records are.
/// Throws InvalidInput with the faults of all rows.
std::vector<LoadedExperiment> load_experiments(const ExperimentsCase& experiments,
                                               const ExperimentDefaults& defaults,
                                               const RecordSeen& seen = {});

}  // namespace osteomill::io
