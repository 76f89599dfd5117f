// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "osteomill/vibration/modal.hpp"

namespace osteomill::vibration {

enum class Response { displacement, acceleration };

/// One hammer blow: force on the structure and its answer, sampled together.
struct ImpactRecord {
  double sample_rate = 0.0;      ///< Hz
  std::vector<double> force;     ///< N
  std::vector<double> response;  ///< m or m/s²
};

enum class FrfEstimator {
  h1,  ///< S_fx/S_ff: noise on the response averages out
  h2   ///< S_xx/S_xf: noise on the force averages out
};

struct FrfOptions {
  Response response = Response::displacement;
  FrfEstimator estimator = FrfEstimator::h1;
  /// Exponential window on both signals that ends at this share of its beginning, so that a slow
  /// decay does not leak; its damping is taken off again by the fit. 1: none.
  double window_end = 1.0;
  /// Samples of the force from the blow on that are kept, s; the rest is noise. 0: all.
  double force_window = 0.0;
};

/// Measured receptance, [plaskos2002] eq. A.10, averaged over blows.
struct MeasuredFrf {
  std::vector<double> frequency_hz;
  std::vector<std::complex<double>> receptance;  ///< m/N
  std::vector<double> coherence;                 ///< 0 … 1; 1 for a single blow
  int blows = 0;
  double window_damping = 0.0;  ///< decay rate that the window adds, 1/s
};

/// Throws InvalidInput when records are empty, differ, or hold no blow.
MeasuredFrf estimate_frf(const std::vector<ImpactRecord>& records, const FrfOptions& options = {});

/// A value with its standard error.
struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;
};

struct FittedMode {
  Estimate frequency_hz;
  Estimate stiffness;  ///< N/m, at the tip
  Estimate damping_ratio;
  Mode mode(double direction_x, double direction_y) const;
};

struct ModalFit {
  std::string status = "not run";  ///< "converged" or why not
  bool converged = false;
  std::vector<FittedMode> modes;
  double residual_flexibility = 0.0;  ///< of the modes beyond the band, m/N
  double residual_rms = 0.0;          ///< m/N, over the band
  int iterations = 0;
};

struct ModalFitOptions {
  double low_hz = 0.0;   ///< of the band; 0: the lowest line
  double high_hz = 0.0;  ///< 0: the highest line
  int modes = 1;
  int most_iterations = 100;
};

/// Least squares of Σ (1/k_r)/(1 − (f/f_r)² + 2iζ_r f/f_r) + c on the complex lines of the band, c
/// a real residual for the modes beyond it. Lines weigh by their coherence, (1 − γ²)/γ² being the
/// relative variance of a line over the number of blows; standard errors from the Jacobian and the
/// residuals. Starts from the peaks of the magnitude. [schmitz2009] ch. 2 has the peak-picking that
/// this refines.
ModalFit fit_modes(const MeasuredFrf& frf, const ModalFitOptions& options = {});

/// The measured receptance as a function of a frequency >= 0, m/N: its lines in the band of the
/// fit, the fitted modes with their residual flexibility beyond. Between lines what they have
/// beside the fit goes straight; straight from line to line itself would cut the peaks, which are a
/// few lines wide. What a window added to the damping is taken off by the ratio of the fit without
/// to the fit with it.
std::function<std::complex<double>(double frequency_hz)> receptance_of(
    const MeasuredFrf& frf, const ModalFit& fit, const ModalFitOptions& options = {});

}  // namespace osteomill::vibration
