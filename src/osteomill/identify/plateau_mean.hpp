// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace osteomill::identify {

/// Straight line through a steady piece of a signal.
struct PlateauMean {
  double mean = 0.0;                  ///< value of the line in the middle
  double standard_error = 0.0;        ///< of the mean
  double slope = 0.0;                 ///< per s
  double slope_standard_error = 0.0;  ///< per s
  double autocorrelation = 0.0;       ///< of neighbouring batch means
  int batches = 0;                    ///< means that the line goes through
};

/// Univariate linear regression on time, [tian2023] §4.2. The samples of milling are anything but
/// independent: they repeat with the revolution and vary slowly besides. So means of whole
/// revolutions are regressed, which takes the periodic part away, and their standard errors allow
/// for correlation of neighbours: prewhitened by a first-order autoregression [andrews1992], then
/// Bartlett's weights of [newey1987] over as many lags as [andrews1991] asks for; with the
/// factor n/(n − 2) for the two parameters.
/// @param rate    samples a second, Hz
/// @param period  of a revolution, s; 0: not known, then batches of n^(1/2) samples
/// Throws InvalidInput for fewer than three batches.
PlateauMean plateau_mean(const Eigen::Ref<const Eigen::VectorXd>& signal, double rate,
                         double period);

}  // namespace osteomill::identify
