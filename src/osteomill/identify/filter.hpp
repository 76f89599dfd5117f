// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace osteomill::identify {

/// One second-order section with a₀ = 1:
/// y_i = b₀ x_i + b₁ x_{i−1} + b₂ x_{i−2} − a₁ y_{i−1} − a₂ y_{i−2}.
struct Biquad {
  double b0 = 1.0;
  double b1 = 0.0;
  double b2 = 0.0;
  double a1 = 0.0;
  double a2 = 0.0;
};

enum class Pass { low, high };

struct Butterworth {
  int order = 9;           ///< of one pass; forward and backward double the slope
  double cutoff_hz = 0.0;  ///< where one pass lets 1/√2 through, and both passes 1/2
  Pass pass = Pass::low;
};

/// Butterworth filter by the bilinear transform, with the cut-off prewarped, [oppenheim2010] §7.2;
/// the real pole of an odd order comes first, then the pairs from the least to the most resonant.
/// Throws InvalidInput unless 1 ≤ order ≤ 50 and 0 < cut-off < rate/2.
/// @param rate  samples a second, Hz
std::vector<Biquad> design(const Butterworth& filter, double rate);

/// Forward, then backward through the sections: no phase, gain |H|². Both ends are extended by
/// 3 (order + 1) samples turned about the end point, and both passes start in the steady state of
/// their first sample, as SciPy's `filtfilt` does it by default. This is the "forward and reverse
/// digital filter" of [plaskos2006] §3.3.2. Columns are signals.
/// Throws InvalidInput when there are no more samples than the extension takes.
Eigen::MatrixXd zero_phase(const std::vector<Biquad>& sections,
                           const Eigen::Ref<const Eigen::MatrixXd>& signals);

/// Gain of both passes at a frequency: |H|².
double zero_phase_gain(const std::vector<Biquad>& sections, double frequency_hz, double rate);

}  // namespace osteomill::identify
