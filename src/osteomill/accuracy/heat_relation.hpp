// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace osteomill::accuracy {

/// Temperature at the cut surface, quick form: T = K (l ω N/f) + T₀, [plaskos2006] §3.5.4.
///
/// l is the length of edge in contact, ω the spindle speed, N the number of flutes, f the feed
/// rate; l ω N/f is 2π l/c, the edge that rubs over each radian and length of feed. K holds all of
/// bone and edge and has to be calibrated on measured temperatures of the same kind of cut; the
/// relation ranks conditions, it does not replace the field solution.
struct HeatRelation {
  double coefficient = 0.0;  ///< K, kelvin (for l ω N/f in radians)
  double start = 0.0;        ///< T₀, °C
};

/// One measured temperature. SI, temperatures in °C.
struct HeatObservation {
  double edge_length = 0.0;    ///< m
  double spindle_speed = 0.0;  ///< rad/s
  int flutes = 1;
  double feed_rate = 0.0;    ///< m/s
  double temperature = 0.0;  ///< °C
};

double rubbing(double edge_length, double spindle_speed, int flutes, double feed_rate);
double temperature(const HeatRelation& relation, double edge_length, double spindle_speed,
                   int flutes, double feed_rate);

struct HeatCalibration {
  HeatRelation relation;
  double coefficient_error = 0.0;  ///< standard error of K, K; 0 with one observation
  double residual_rms = 0.0;       ///< K
};

/// Least squares for K with a known start temperature.
HeatCalibration calibrate(const std::vector<HeatObservation>& observations, double start);

}  // namespace osteomill::accuracy
