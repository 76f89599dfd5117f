// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "osteomill/identify/signal_chain.hpp"
#include "osteomill/io/plot.hpp"

namespace osteomill::io {

/// A figure of one step: its file stem, title and diagram.
struct SignalFigure {
  std::string name;  ///< "record", "plateau", "cumulative_mean", "revolution", "spectrum"
  std::string caption;
  LinePlot plot;
};

/// One figure a step that was done: record and filtered record with idle parts, cut and plateau;
/// a close look at a few revolutions with envelope; cumulative mean and regression;
/// mean revolution with its error; harmonics of the rotation. Long signals are thinned to their
/// extremes, so that no peak is lost.
std::vector<SignalFigure> figures_of(const identify::ForceRecord& raw,
                                     const identify::ProcessedRecord& processed,
                                     const std::string& name);

}  // namespace osteomill::io
