// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "osteomill/identify/combined_records.hpp"
#include "osteomill/io/identify_case.hpp"

namespace osteomill::io {

/// The keys of --format json: docs/guide/identify.md.
nlohmann::ordered_json identify_document(const IdentifyCase& input,
                                         const identify::MeanForceIdentification& result);

/// What became of each record: file, rate, plateau, speed, lines of run-out, means, steps,
/// warnings.
nlohmann::ordered_json records_json(const std::vector<LoadedExperiment>& loaded);

/// A catalogue entry (TOML) of the chosen law: coefficients, range, provenance, and under
/// [identification] their standard errors, covariance and what was compared.
std::string catalogue_entry_of(const IdentifyCase& input,
                               const identify::MeanForceIdentification& result);

/// The same of the instantaneous fits of all records together.
std::string catalogue_entry_of(const IdentifyCase& input, const identify::CombinedRecords& records);

}  // namespace osteomill::io
