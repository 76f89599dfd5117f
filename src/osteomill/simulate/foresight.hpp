// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "osteomill/simulate/milling.hpp"

namespace osteomill::simulate {

struct ForesightOptions {
  double spacing = 0.1e-3;   ///< of the places, m
  double slow_feed = 2e-3;   ///< m/s
  double fast_feed = 12e-3;  ///< m/s
};

/// What a stock answers along the path, found by milling copies of it: mean force = edge + gain v,
/// the line through the forces at two feeds, at the machine's spindle speed.
struct Foresight {
  double spacing = 0.0;       ///< m
  std::vector<double> gains;  ///< N/(m/s), from the start of the path
  std::vector<double> edges;  ///< N, >= 0
};

/// `fresh` makes the workpiece anew, as it is before anything is cut. A force law that bends with
/// the feed is met at the two feeds; between them a concave one lies above the line.
Foresight foresee(const std::function<std::unique_ptr<Workpiece>()>& fresh, const Machine& machine,
                  const ForesightOptions& options);

}  // namespace osteomill::simulate
