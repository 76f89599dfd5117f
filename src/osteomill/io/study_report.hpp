// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/io/report.hpp"
#include "osteomill/study/analysis.hpp"

namespace osteomill::io {

/// The page of a study, without its figures and its case: what was found in sentences, what does
/// not hold, tables of tests, variability, forecasts, components and regressions.
ReportData study_page(const study::StudyReport& report, const std::string& name);

/// The sentences: for each response what each factor does to its mean and its variability.
std::vector<std::string> study_sentences(const study::StudyReport& report);

/// "varus/valgus" of varus_valgus_deg, and its unit: "°", "s", "mm³/s".
std::string in_words(const std::string& column);
std::string unit_in_words(const std::string& unit);

/// "p = 0.013", "p < 0.0001".
std::string p_words(double p);

/// "92–98 %": how often an interval held the truth in simulations; "not measured" where none were
/// made.
std::string coverage_words(const std::optional<study::CoverageRange>& coverage);

}  // namespace osteomill::io
