// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "osteomill/identify/signal_chain.hpp"
#include "osteomill/io/signals_file.hpp"

namespace osteomill::io {

/// A processed record as signals for other programs: time; force_{x,y,z} as read and
/// processed_force_{x,y,z} after the steps, in the tool frame; the envelopes over plateau_time and
/// tacho where there are any; the mean revolution over revolution_angle. Attributes:
/// plateau_begin_s, plateau_end_s, rate_hz, spindle_speed_rpm, cutoff_hz and filter_order of the
/// filter (0: none), and the steps as text.
SignalRun signals_of(const identify::ForceRecord& raw, const identify::ProcessedRecord& processed,
                     const identify::SignalChain& chain, const identify::CutOfRecord& cut,
                     const std::string& name);

}  // namespace osteomill::io
