// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <optional>

#include "osteomill/control/sugita_loop.hpp"
#include "osteomill/numerics/second_order_lag.hpp"

namespace osteomill::control {

/// The linear plant that the loop sees: servo, cutting gain, mean force over the period, delay.
struct LinearPlant {
  double force_gain = 0.0;                        ///< K_f of F = K_f v, [sugita2009] eq. 7, N/(m/s)
  std::optional<numerics::SecondOrderLag> servo;  ///< none: the feed is the command at once
  double period = 10e-3;                          ///< s
  int delay_updates = 1;  ///< control periods between the force and the feed that it sets
};

/// Stability of the loop with one gain (that of one direction; the published loop has two).
struct Margins {
  double gain_margin = 0.0;          ///< factor on the gain that makes the loop critical
  double phase_margin = 0.0;         ///< rad
  double critical_frequency = 0.0;   ///< where the gain margin is taken, rad/s
  double crossover_frequency = 0.0;  ///< where the phase margin is taken, rad/s
  /// gain x K_f (dimensionless, m/s per N of the taps' sum times N/(m/s)) at which the loop is
  /// critical: 2 sin²(pi/10) for five taps, no servo, one update of delay.
  double critical_loop_gain = 0.0;
};

/// Margins of L(z) = g K_f P(z) sum_{k=0..4} z^-k / (1 - z^-1), P the servo's mean feed over the
/// period under a held command, by its frequency response up to the Nyquist frequency.
/// @param gain  g, m/s per N of the taps' sum: gain_on_sum(loop, loop.gain_up) for example.
Margins margins(const LinearPlant& plant, double gain);

/// L(e^{i w T}) of the same loop at a frequency in (0, pi/T], rad/s.
std::complex<double> open_loop(const LinearPlant& plant, double gain, double frequency);

}  // namespace osteomill::control
