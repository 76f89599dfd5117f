// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/bone/provenance.hpp"
#include "osteomill/identify/mean_force_identification.hpp"
#include "osteomill/io/experiments.hpp"
#include "osteomill/io/signal_figures.hpp"

/// The case of `osteomill identify`.
namespace osteomill::io {

struct CaseRun;
class Section;

enum class IdentifyMethod { automatic, mean_forces, instantaneous };

struct IdentifyCase {
  std::vector<identify::Experiment> experiments;
  std::vector<identify::ForceModel> models;  ///< to compare; one: it alone
  identify::SelectionOptions options;
  std::vector<LoadedExperiment> loaded;      ///< the experiments with their records, if any
  identify::SignalChain chain;               ///< that the records went through
  std::vector<SignalFigure> signal_figures;  ///< of the first record
  IdentifyMethod method = IdentifyMethod::automatic;
  std::string table;            ///< name of the file
  bone::Provenance provenance;  ///< of the entry that comes out
  nlohmann::ordered_json expanded;
};

/// The keys, for the schema.
void bind_identify(Section& section);

/// Throws InvalidInput with all faults of the case and of the table.
IdentifyCase read_identify_case(const CaseRun& run);

}  // namespace osteomill::io
