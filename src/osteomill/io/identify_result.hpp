// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "osteomill/io/identify_case.hpp"

namespace osteomill::io {

/// The keys of --format json: docs/guide/identify.md.
nlohmann::ordered_json identify_document(const IdentifyCase& input,
                                         const identify::MeanForceIdentification& result);

/// A catalogue entry (TOML) of the chosen law: coefficients, range, provenance, and under
/// [identification] their standard errors, covariance and what was compared.
std::string catalogue_entry_of(const IdentifyCase& input,
                               const identify::MeanForceIdentification& result);

}  // namespace osteomill::io
