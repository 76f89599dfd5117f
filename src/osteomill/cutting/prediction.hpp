// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/cutting/engagement.hpp"
#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::cutting {

struct PredictionOptions {
  int steps = 360;     ///< of the revolution
  int harmonics = 16;  ///< of the spindle frequency, from 1
};

/// What one nominal cut does to the cutter.
struct Prediction {
  Load mean;
  Revolution revolution;
  geometry::Vector3 peak = geometry::Vector3::Zero();  ///< largest magnitude of each component, N
  double peak_resultant = 0.0;                         ///< N
  geometry::Vector3 rms = geometry::Vector3::Zero();   ///< N
  double mean_torque = 0.0;                            ///< N m
  double peak_torque = 0.0;                            ///< N m
  /// Bending moment over the revolution, N m, where the cutter is held: at the end of its free
  /// length, or without a shank at the top of its cutting length.
  std::vector<double> bending_moments;
  double peak_bending_moment = 0.0;  ///< of them
  double spindle_power = 0.0;        ///< mean, W
  /// Of the spindle power, what the edge forces take: all of it rubs. 0 for laws without edge
  /// force, which do not tell rubbing from cutting.
  double rubbing_power = 0.0;
  double feed_power = 0.0;       ///< mean, W; < 0 when the cut pulls the cutter along
  double removal_rate = 0.0;     ///< m³/s
  double specific_energy = 0.0;  ///< power of spindle and feed over removal rate, J/m³; 0 without
  double feed_per_tooth = 0.0;   ///< m
  double largest_chip = 0.0;     ///< m
  std::vector<geometry::Vector3> harmonics;  ///< amplitude at 1, 2, ... times spindle speed, N
  std::vector<geometry::Vector3>
      flute_means;  ///< mean force of each flute, N; none for unequal flutes in a map
  std::vector<std::string> warnings;
};

Prediction predict(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
                   const Immersion& immersion, const PredictionOptions& options = {});

/// From an engagement map, as the stock delivers it. Where its weights are shares of contact the
/// removal rate is that of the bone; where they carry strength it is that of reference bone.
Prediction predict(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
                   const Engagement& map, const PredictionOptions& options = {});

/// What a solved cut is made of, however it was solved.
struct SolvedCut {
  Load mean;
  Load rubbing;  ///< mean of the edge forces alone
  Revolution revolution;
  double removal_rate = 0.0;  ///< m³/s
  double largest_chip = 0.0;  ///< m
};

/// Peaks, powers and harmonics of a solved cut.
Prediction summarise(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
                     const SolvedCut& solved, const PredictionOptions& options);

/// What the law was not measured for: chips beyond its range. Empty when all is within.
std::vector<std::string> range_warnings(const CuttingLaw& law, double largest_chip);

}  // namespace osteomill::cutting
