// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "osteomill/control/loop.hpp"
#include "osteomill/control/plant.hpp"

namespace osteomill::cli {

/// One run as the view shows it.
struct LiveRun {
  std::string name;
  double length = 0.0;        ///< of the path, m
  double force_limit = 0.0;   ///< N
  double highest_feed = 0.0;  ///< m/s
};

/// Shows a run while it goes, on standard error: force, feed, state, progress and events; four
/// lines that are drawn anew ten times a second on a terminal, a line every two seconds elsewhere.
/// It draws in a thread of its own from what the loop leaves in rings: the loop takes no lock, no
/// heap and waits for nobody. The terminal is left in the mode in which it is: there is nothing to
/// restore when the program is killed.
class LiveView {
 public:
  LiveView();
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  /// The plant of a run, watched; it lives until the next run begins.
  control::Plant& watch(control::Plant& plant, const LiveRun& run);
  /// From the thread in which it happens.
  void event(const control::LoopEvent& event) noexcept;
  /// Draws no more and leaves the last state standing.
  void end();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace osteomill::cli
