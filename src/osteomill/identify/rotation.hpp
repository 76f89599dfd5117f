// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "osteomill/identify/force_record.hpp"

namespace osteomill::identify {

/// Rotation angle of the spindle at each sample.
struct Rotation {
  Eigen::VectorXd angle;         ///< rad, growing; a multiple of 2π where the tachometer pulses
  double spindle_speed = 0.0;    ///< mean, rad/s
  double speed_deviation = 0.0;  ///< standard deviation of the speed over the record, rad/s
  /// Whether angle 0 is the same place on the spindle in every record. The tooth-passing line only
  /// says where teeth pass, not which one: there angle 0 is where the line has its maximum.
  bool absolute = false;
};

/// From a once-per-revolution pulse: angle 2π k where the signal rises through the middle of its
/// range for the k-th time, by a straight line between samples and between pulses. A tooth of
/// hysteresis of a tenth of the range keeps noise out. Before the first and after the last pulse
/// the speed of the neighbouring revolution holds.
/// Throws InvalidInput when there are fewer than two pulses, or revolutions whose length differs
/// by more than a half from their median (missed or doubled pulses).
Rotation rotation_from_tacho(const Eigen::VectorXd& tacho, double rate);

struct LineOptions {
  double search = 0.1;  ///< the speed is sought within this share about the nominal one
  double block = 40.0;  ///< tooth periods over which one phase is measured
};

/// From the tooth-passing line of the forces themselves: the strongest of the sums of the first
/// harmonics near the nominal speed in the spectrum (Hann window, refined by a parabola through
/// the logarithms), then the phase of that line block by block, so that a speed that wanders is
/// followed. Harmonics beyond half the sampling rate are left out.
/// Throws InvalidInput when the line does not stand out or lies above half the sampling rate.
/// @param spindle_speed  nominal, rad/s
Rotation rotation_from_line(const ForceRecord& record, double spindle_speed, int flutes,
                            const LineOptions& options = {});

/// From a speed that is known and constant; angle 0 at the first sample.
Rotation rotation_of_speed(Eigen::Index samples, double rate, double spindle_speed);

}  // namespace osteomill::identify
