// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/vibration/beam.hpp"

namespace osteomill::vibration {

/// Natural frequencies of the distributed-parameter Euler–Bernoulli beam, Hz, lowest first.
///
/// X'''' = κ⁴ X, κ⁴ = ω² ρA/EI on each uniform piece, [plaskos2002] eqs A.3–A.9, here for any
/// number of steps and supports: the exact dynamic stiffness of the pieces is assembled and the
/// roots are counted by its negative pivots ([wittrick1971]), so none is missed however close
/// two of them lie. Shear deformation and rotary inertia are neglected: slender shafts.
std::vector<double> exact_natural_frequencies(const Beam& beam, int count);

/// Deflection of the beam at the given positions in the mode of that natural frequency, scaled so
/// that the largest of them is 1.
std::vector<double> exact_mode_shape(const Beam& beam, double natural_frequency_hz,
                                     const std::vector<double>& positions);

/// Deflection at the tip under a unit force at the tip that oscillates with the frequency, m/N;
/// undamped, so it has poles at the natural frequencies.
double exact_tip_receptance(const Beam& beam, double frequency_hz);

/// Determinant of the 5 × 5 system of a uniform shaft that is clamped at its end and pinned at
/// L_s, with L_f free beyond it; zero at the natural frequencies ω = κ² √(EI/ρA).
///
/// [plaskos2002] A.1.1.6. The boundary table printed there also asks for a continuous shear force
/// at the pin, which cannot hold, as the pin carries a reaction; the printed matrix rightly leaves
/// it out, and so do we.
double clamp_pin_determinant(double kappa, double supported_length, double free_length);

}  // namespace osteomill::vibration
