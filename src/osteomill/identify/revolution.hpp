// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "osteomill/identify/rotation.hpp"

namespace osteomill::identify {

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
