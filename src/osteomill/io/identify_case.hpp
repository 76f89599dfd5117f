// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/bone/provenance.hpp"
#include "osteomill/identify/law_units.hpp"
#include "osteomill/identify/mean_force_identification.hpp"
#include "osteomill/io/experiments.hpp"
#include "osteomill/io/signal_figures.hpp"
#include "osteomill/io/signals_file.hpp"

/// The case of `osteomill identify`.
namespace osteomill::io {

struct CaseRun;
class Section;

enum class IdentifyMethod { automatic, mean_forces, instantaneous };

/// Where the run-out of mean forces comes from: the records where they tell it and the cutter
/// states none; the cutter as stated; the records or not at all.
enum class RunOutFrom { automatic, cutter, records };

struct RunOutCase {
  RunOutFrom from = RunOutFrom::automatic;
  double standard_error = 0.0;  ///< of what the cutter states, m
  double bound = 0.0;           ///< of what nobody knows, m
};

struct IdentifyCase {
  std::vector<identify::Experiment> experiments;
  std::vector<identify::ForceModel> models;  ///< to compare; one: it alone
  identify::SelectionOptions options;
  ExperimentsCase source;
  ExperimentDefaults defaults;
  std::vector<LoadedExperiment> loaded;      ///< the experiments with their records, if any
  identify::SignalChain chain;               ///< that the records went through
  std::vector<SignalFigure> signal_figures;  ///< of the first record
  IdentifyMethod method = IdentifyMethod::automatic;
  std::vector<identify::UnitForce> units;  ///< of the law that revolutions are fitted with
  RunOutCase run_out;
  std::string table;            ///< name of the file
  bone::Provenance provenance;  ///< of the entry that comes out
  nlohmann::ordered_json expanded;
};

/// The keys, for the schema.
void bind_identify(Section& section);

/// Throws InvalidInput with all faults of the case and of the table.
IdentifyCase read_identify_case(const CaseRun& run);

/// Reads the records again, for their signals before and after the steps.
SignalsFile record_signals(const IdentifyCase& input);

}  // namespace osteomill::io
