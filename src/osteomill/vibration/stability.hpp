// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <vector>

#include "osteomill/base/progress.hpp"
#include "osteomill/vibration/regeneration.hpp"

namespace osteomill::vibration {

enum class StabilityMethod {
  zero_order,
  multi_frequency,
  semi_discretisation,
  full_discretisation,
  collocation
};

enum class Bifurcation {
  none,  ///< no limit below the largest depth
  hopf,  ///< chatter beside the tooth harmonics: a complex pair leaves the unit circle
  flip,  ///< period doubling: −1
  fold   ///< +1
};

struct StabilityOptions {
  StabilityMethod method = StabilityMethod::semi_discretisation;
  int steps = 0;             ///< of a tooth period; 0: see default_steps
  int harmonics = 5;         ///< multi-frequency: on either side
  double max_depth = 0.0;    ///< m
  double scan_ratio = 1.06;  ///< of each depth tried to the one before, upwards
  Progress progress = {};
};

struct LobePoint {
  double spindle_speed = 0.0;                                    ///< rad/s
  double limit_depth = std::numeric_limits<double>::infinity();  ///< m; infinity: none below max
  double chatter_frequency_hz = 0.0;
  Bifurcation bifurcation = Bifurcation::none;
};

/// Modulus of the dominant Floquet multiplier; below 1 the cut is stable. Time-domain methods only.
double spectral_radius(const RegenerativeSystem& system, double spindle_speed, double depth,
                       const StabilityOptions& options);

/// The smallest depth at which the cut loses stability at each speed, by a scan from below that
/// finds unstable islands wider than `scan_ratio`, and thinner ones whose summit it can see
/// coming. Speeds run on threads; each is independent.
std::vector<LobePoint> lobes(const RegenerativeSystem& system, const std::vector<double>& speeds,
                             const StabilityOptions& options);

/// The same boundary by continuation: each speed starts from its neighbour's depth and only
/// brackets the limit around it. Several times faster on a fine list of speeds; an unstable island
/// that begins below the followed branch between two of every sixteen speeds is not seen.
std::vector<LobePoint> lobes_by_continuation(const RegenerativeSystem& system,
                                             const std::vector<double>& speeds,
                                             const StabilityOptions& options);

/// Spectral radius over speeds × depths, depth runs fastest: the margin map.
std::vector<double> stability_map(const RegenerativeSystem& system,
                                  const std::vector<double>& speeds,
                                  const std::vector<double>& depths,
                                  const StabilityOptions& options);

}  // namespace osteomill::vibration
