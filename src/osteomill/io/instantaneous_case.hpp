// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "osteomill/bone/provenance.hpp"
#include "osteomill/identify/instantaneous.hpp"
#include "osteomill/io/cutting_section.hpp"
#include "osteomill/io/experiments.hpp"

/// The case of `osteomill identify instantaneous`: one record and the cut that it was taken on.
namespace osteomill::io {

struct CaseRun;
class Section;

struct InstantaneousCase {
  std::filesystem::path record;
  RecordFormat format;
  SignalsCase signals;
  CutterCase cutter;
  cutting::Condition condition;
  cutting::Immersion immersion;
  identify::InstantaneousOptions options;
  bone::Provenance provenance;  ///< of the entry that comes out
  nlohmann::ordered_json expanded;
};

/// The keys, for the schema.
void bind_instantaneous(Section& section);

/// Throws InvalidInput with all faults.
InstantaneousCase read_instantaneous_case(const CaseRun& run);

/// What came of it.
struct InstantaneousResult {
  identify::ForceRecord raw;  ///< as read
  identify::ProcessedRecord processed;
  identify::RevolutionForces forces;
  identify::InstantaneousFit fit;
  std::vector<std::string> warnings;
};
InstantaneousResult solve(const InstantaneousCase& input);

/// The JSON document: docs/guide/identify-instantaneous.md.
nlohmann::ordered_json instantaneous_document(const InstantaneousCase& input,
                                              const InstantaneousResult& result);

/// The law as a catalogue entry (TOML), with standard errors and covariance.
std::string instantaneous_entry(const InstantaneousCase& input, const InstantaneousResult& result);

/// Value in the unit that tables and documents have, with its name: "N/mm2", "N/mm", "1", "um",
/// "um/mm", "deg", "N".
struct ShownEstimate {
  double factor = 1.0;
  const char* unit = "";
};
ShownEstimate unit_of(const identify::Estimate& estimate);

}  // namespace osteomill::io
