// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/io/plot.hpp"
#include "osteomill/io/report.hpp"
#include "osteomill/io/signals_file.hpp"
#include "osteomill/io/simulated_run.hpp"

namespace osteomill::io {

/// One group a run: every control period. Times count from the first contact.
SignalsFile signals_of(const std::vector<SimulatedRun>& runs);

/// Force, feed and material of one run over time, one below the other.
LinePlot plot_of(const SimulatedRun& run);

/// The page of report.html; pictures and surfaces are for the caller to add (simulate_picture.hpp).
ReportData report_of(const std::vector<SimulatedRun>& runs, const std::string& title,
                     const std::string& program);

}  // namespace osteomill::io
