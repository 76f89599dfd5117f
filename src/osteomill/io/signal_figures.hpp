// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "osteomill/identify/signal_chain.hpp"
#include "osteomill/io/plot.hpp"

namespace osteomill::io {

/// A figure of one step of the signal chain.
struct SignalFigure {
  std::string
      name;  ///< stem of its file: "record", "close", "spectrum", "mean", "revolution", "harmonics"
  std::string caption;
  LinePlot plot;
};

/// Record as read and after the steps, with the plateau; a close look at four revolutions with the
/// envelope where it was asked for; the spectrum of the plateau before and after; cumulative mean
/// and regression; and, where a rotation was found, the mean revolution with its interval and the
/// harmonics of the rotation. Long signals are thinned to their extremes, so that no peak is lost.
/// @param name  of the experiment, for the titles
std::vector<SignalFigure> figures_of(const identify::ForceRecord& raw,
                                     const identify::ProcessedRecord& processed, int flutes,
                                     const std::string& name);

}  // namespace osteomill::io
