// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <functional>
#include <vector>

#include "osteomill/vibration/beam.hpp"

namespace osteomill::vibration {

/// One mode of vibration as the cutter's tip feels it: q̈ + 2ζω q̇ + ω² q = u·F/m, tip moves by u q.
/// Axes of the tool frame: x along the feed, y normal to it.
struct Mode {
  double frequency_hz = 0.0;   ///< undamped natural frequency
  double damping_ratio = 0.0;  ///< ζ
  double modal_mass = 0.0;     ///< of a shape that is 1 at the tip, kg
  double direction_x = 1.0;    ///< unit vector in which the tip moves
  double direction_y = 0.0;
};

/// Stiffness of a mode at the tip, m ω², N/m.
double modal_stiffness(const Mode& mode);

/// Throws InvalidInput that lists every fault.
void check(const std::vector<Mode>& modes);

/// Receptance of the tip in the direction x or y under a force in x or y, m/N.
struct TipReceptance {
  std::complex<double> xx, xy, yy;
};
TipReceptance tip_receptance(const std::vector<Mode>& modes, double frequency_hz);

/// Receptance of the tip, m/N, at a frequency >= 0: modal, or measured.
using Receptance = std::function<TipReceptance(double frequency_hz)>;

}  // namespace osteomill::vibration
