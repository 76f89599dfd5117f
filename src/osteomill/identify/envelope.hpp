// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace osteomill::identify {

struct Envelope {
  Eigen::VectorXd upper;
  Eigen::VectorXd lower;
};

/// Mean ± magnitude of the analytic signal of the rest (Hilbert transform by FFT), what MATLAB's
/// `envelope` does by default and [tian2023] §4.2 used.
Envelope analytic_envelope(const Eigen::VectorXd& signal);

/// Largest and smallest value within a window about each sample; at the ends the window is cut.
/// A window of one tooth period follows the peaks of the teeth.
/// @param window  samples, ≥ 1
Envelope peak_envelope(const Eigen::VectorXd& signal, Eigen::Index window);

/// Root mean square of |F| over a window about each sample; at the ends the window is cut. Rows are
/// samples, columns components.
/// @param window  samples, ≥ 1
Eigen::VectorXd moving_rms(const Eigen::MatrixX3d& force, Eigen::Index window);

/// Mean of all samples up to each one: [tian2023] Figure 6(d).
Eigen::VectorXd cumulative_mean(const Eigen::VectorXd& signal);

}  // namespace osteomill::identify
