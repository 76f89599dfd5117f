// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <vector>

#include "osteomill/vibration/regeneration.hpp"

namespace osteomill::vibration {

/// A depth at which the cut is on its limit at a given speed.
struct FrequencyDomainLimit {
  double depth = 0.0;                 ///< m
  double chatter_frequency_hz = 0.0;  ///< of the strongest line, within the scanned range
  bool flip = false;                  ///< at half the tooth-passing frequency
};

/// Zero-order solution of [altintas1995]: the directional coefficients at their mean W₀, so that
///   det[1 − a (1 − e^{−iωT}) Φ(iω) W₀] = 0
/// gives depth and speed in closed form for each chatter frequency. The helix drops out of the
/// mean. Wrong at low immersion, where the cut is interrupted: it knows neither flip lobes nor the
/// added stable pockets.
class ZeroOrder {
 public:
  /// Scans chatter frequencies between the two limits in `points` equal ratios.
  ZeroOrder(Receptance receptance, const Regeneration& cut, double lowest_hz, double highest_hz,
            int points = 4000);
  /// Same with the system's receptance over the modes' own range: from 0.2 of the lowest to 3 times
  /// the highest frequency.
  explicit ZeroOrder(const RegenerativeSystem& system, int points = 4000);

  /// The smallest limit depth over all speeds; infinity when there is none.
  FrequencyDomainLimit absolute_minimum() const;
  /// The smallest limit depth at that speed; infinity when there is none.
  FrequencyDomainLimit limit(double spindle_speed) const;

 private:
  struct Branch {
    double depth;  ///< infinity where this eigenvalue cannot chatter
    double phase;  ///< ω T modulo 2π, in (0, 2π)
  };
  std::vector<Branch> branches(double frequency_hz) const;

  Receptance receptance_;
  Eigen::Matrix2d mean_;
  double pitch_;
  std::vector<double> frequencies_;
};

/// Multi-frequency solution of [merdol2004]: Hill's determinant with `harmonics` of the tooth
/// passing on either side, which covers flip lobes and low immersion. Infinity when there is no
/// limit below `max_depth`.
///
/// With a helix the directional harmonics depend on the depth a: W_r(a) = W_r (1 − e^{−irNΛa})/
/// (irNΛa) with the lag Λ a metre. With them frozen at a depth a' the limit L(a') is explicit as
/// for straight flutes; the cut is stable as long as a < L(a), so the limit is the smallest a =
/// L(a).
FrequencyDomainLimit multi_frequency_limit(const RegenerativeSystem& system, double spindle_speed,
                                           int harmonics, double max_depth);

}  // namespace osteomill::vibration
