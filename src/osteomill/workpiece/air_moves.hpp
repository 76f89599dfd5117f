// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/workpiece/contact.hpp"
#include "osteomill/workpiece/tool_path.hpp"

namespace osteomill::workpiece {

struct AirOptions {
  double clearance =
      2e-3;  ///< from here before bone to here behind it the feed is that of the cut, m
  double rapid_feed = 12e-3;  ///< of the moves that are not cuts, m/s
};

/// A path without cuts through air.
struct AirMoves {
  ToolPath path;
  double length = 0.0;      ///< of cuts that became rapids, m
  double time_saved = 0.0;  ///< at the programmed feeds, s
};

/// The same way, with the parts of cuts on which the stock has no bone in front of the cutter
/// turned into rapids. Parts that a rapid would not shorten in time stay as they are.
AirMoves rapid_through_air(const ToolPath& path, const ContactMap& contact,
                           const AirOptions& options);

/// Time at the programmed feeds, s.
double duration(const ToolPath& path, double rapid_feed);

}  // namespace osteomill::workpiece
