// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "osteomill/base/progress.hpp"
#include "osteomill/simulate/milling.hpp"

namespace osteomill::simulate {

struct ForesightOptions {
  double spacing = 0.1e-3;   ///< of the places, m
  double slow_feed = 2e-3;   ///< m/s
  double fast_feed = 12e-3;  ///< m/s
  /// Of the workpiece before it is cut, K; 0: temperatures are not asked for.
  double body_temperature = 0.0;
  double other_speed = 0.0;  ///< of the spindle, for a third copy, rad/s; 0: none
};

/// What a stock answers along the path, found by milling copies of it: force = edge + gain v, the
/// line through the forces at two feeds, at the machine's spindle speed.
struct Foresight {
  double spacing = 0.0;                        ///< m
  std::vector<double> gains;                   ///< N/(m/s), from the start of the path
  std::vector<double> edges;                   ///< N, >= 0
  std::vector<double> peak_gains, peak_edges;  ///< the same of the largest force of a revolution
  /// Of the hottest bone while the tool is there, K: at the slow feed, the fast one, and the fast
  /// one with the other speed. Empty where not asked for.
  std::vector<double> slow_rises, fast_rises, other_rises;
};

/// When `progress` asks to stop, what is not found is zero. `fresh` makes the workpiece anew, as it
/// is before anything is cut. A force law that bends with the feed is met at the two feeds; between
/// them a concave one lies above the line.
Foresight foresee(const std::function<std::unique_ptr<Workpiece>()>& fresh, const Machine& machine,
                  const ForesightOptions& options, const Progress& progress = {});

}  // namespace osteomill::simulate
