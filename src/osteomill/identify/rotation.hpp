// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

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

/// Mean force over one revolution.
struct RevolutionAverage {
  Eigen::VectorXd angle;            ///< m, mean angle of the samples of each bin, 0 … 2π
  Eigen::MatrixX3d force;           ///< m × 3, N
  Eigen::MatrixX3d standard_error;  ///< m × 3, N; of bins with one sample that of their peers
  Eigen::VectorXi count;            ///< samples in each bin
  int revolutions = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< over the angle, N
};

/// Samples are gathered in bins of the rotation angle and averaged over the revolutions, as
/// [plaskos2006] §3.3.2 did at every degree. Only whole revolutions count. Bins that no sample
/// falls into are left out; the angle of a bin is the mean of its samples', so that nothing is
/// shifted when the sampling is locked to the rotation.
/// @param bins  0: as many as there are samples in a revolution, at most 360
/// Throws InvalidInput for less than one revolution.
RevolutionAverage average_revolution(const Eigen::MatrixX3d& force, const Rotation& rotation,
                                     int bins = 0);

/// The same with run-out taken away: mean of the N copies of the revolution shifted by the pitch.
/// For two flutes this averages the first half with the second, [plaskos2006] §3.3.2. It takes away
/// every harmonic of the rotation that is no multiple of N; what run-out adds to the others,
/// because the force is no linear function of the chip, stays. Flutes of equal pitch only.
/// @param bins  of a revolution; brought to a multiple of N
RevolutionAverage average_pitch(const Eigen::MatrixX3d& force, const Rotation& rotation, int flutes,
                                int bins = 0);

/// One line of the spectrum over the revolution.
struct RotationHarmonic {
  int order = 0;  ///< a revolution; multiples of the number of flutes are tooth passing
  Eigen::Vector3d amplitude = Eigen::Vector3d::Zero();  ///< N
  Eigen::Vector3d phase =
      Eigen::Vector3d::Zero();  ///< of the cosine: a cos(order·angle + phase), rad
};

/// Orders 1 … highest over whole revolutions. Those that are no multiple of the number of flutes
/// come from run-out or from unequal flutes.
std::vector<RotationHarmonic> rotation_harmonics(const Eigen::MatrixX3d& force,
                                                 const Rotation& rotation, int highest);

}  // namespace osteomill::identify
