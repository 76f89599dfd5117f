// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "osteomill/base/progress.hpp"
#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/vibration/frequency_domain.hpp"
#include "osteomill/vibration/modal.hpp"

namespace osteomill::vibration {

/// Steady motion of the tip over one tooth period (a revolution when the flutes are unequal) under
/// the forces of a rigid cut, m.
struct ForcedMotion {
  std::vector<double> x, y;                ///< equal steps; index 0 where flute 1 is at θ = 0
  std::vector<double> static_x, static_y;  ///< the same without dynamics
};

/// Each harmonic of the tooth passing through the receptance of the tip: D_k = H(k f_t) F_k.
/// [plaskos2002] A.3 without its finite elements; the chips of a vibrating edge are not fed back.
ForcedMotion forced_motion(const Receptance& receptance, const cutting::Cutter& cutter,
                           const cutting::CuttingLaw& law, const cutting::Condition& condition,
                           const cutting::Immersion& immersion, int steps = 96);

/// One point of a sweep over the spindle speed at constant feed rate.
struct ForcedPoint {
  double spindle_speed = 0.0;  ///< rad/s
  double feed_rate = 0.0;      ///< m/s
  double peak = 0.0;           ///< largest distance of the tip from its rest, m
  double static_peak = 0.0;    ///< the same without dynamics, m
  double peak_normal = 0.0;    ///< largest |y|, m
  double amplification() const { return static_peak > 0.0 ? peak / static_peak : 0.0; }
};

/// Speeds × feed rates, speed runs fastest. The chips get thinner with the speed, as in
/// [plaskos2002] Figures A.11 and A.12.
std::vector<ForcedPoint> forced_sweep(const Receptance& receptance, const cutting::Cutter& cutter,
                                      const cutting::CuttingLaw& law,
                                      const cutting::Condition& condition,
                                      const cutting::Immersion& immersion,
                                      const std::vector<double>& speeds,
                                      const std::vector<double>& feed_rates,
                                      const Progress& progress = {});

/// A spindle speed at which a harmonic of the tooth passing meets a mode: n = f/(r N) turns a
/// second.
struct ResonanceSpeed {
  double spindle_speed = 0.0;  ///< rad/s
  int mode = 0;                ///< from 1
  int harmonic = 0;            ///< of the tooth passing, from 1
};
std::vector<ResonanceSpeed> resonance_speeds(const std::vector<double>& natural_frequencies_hz,
                                             int flutes, int harmonics, double low, double high);

/// Ranges of a sweep (one feed rate), of two speeds or more, in which the amplification stays below
/// a limit.
struct CalmRange {
  double low = 0.0, high = 0.0;  ///< rad/s
  double calmest = 0.0;          ///< speed of the smallest peak within, rad/s
};
std::vector<CalmRange> calm_ranges(const std::vector<ForcedPoint>& sweep,
                                   double largest_amplification);

}  // namespace osteomill::vibration
