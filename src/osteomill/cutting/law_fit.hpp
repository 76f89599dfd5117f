// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "osteomill/cutting/edge_force.hpp"

namespace osteomill::cutting {

/// One orthogonal cut: chip thickness, m, and force per width, N/m.
struct OrthogonalCut {
  double h = 0.0;
  double force = 0.0;
};

/// How well a law fits, in a way that laws of different form can be compared.
struct FitQuality {
  double rms = 0.0;        ///< of the residual force per width, N/m
  double r_squared = 0.0;  ///< 1 less the residual's over the force's sum of squares
  double aicc =
      0.0;  ///< Akaike's criterion for small samples on the same residuals; less is better
};

/// F = K h^n + F_e by least squares on the force, 0 < n <= 1.5, K >= 0, F_e >= 0.
struct PowerFit {
  PowerLaw law;
  std::array<double, 3> standard_errors{};  ///< of K (N/m), n, F_e (N/m); 0 for F_e at its bound
  bool edge_at_bound = false;               ///< F_e = 0 because it would be negative
  bool constant = false;  ///< K = 0 because it would be negative: no n, and errors of F_e alone
  FitQuality quality;
  std::string status = "not run";  ///< "fitted" when it ran
};

/// log10 F = K3 L² + K2 L + K1 by linear least squares on log10 F: [plaskos2006] 2.3. Needs forces
/// > 0.
struct LogFit {
  LogLaw law;
  std::array<double, 3> standard_errors{};  ///< of K1, K2, K3
  FitQuality quality;
  std::string status = "not run";
};

/// Cuts of one chip thickness as their mean: [plaskos2006] 2.2 fits points that are the average of
/// about four cuts.
std::vector<OrthogonalCut> averaged(const std::vector<OrthogonalCut>& cuts);

/// Whether two speeds differ in force at one chip thickness: the unpaired t-test of Student (two
/// samples, equal variance), [plaskos2006] 2.2.
struct SpeedEffect {
  double h = 0.0;  ///< m
  int slow_cuts = 0, fast_cuts = 0;
  double slow_mean = 0.0, fast_mean = 0.0;  ///< N/m
  double t = 0.0;                           ///< > 0 when the fast cuts take more force
  double degrees_of_freedom = 0.0;
  double p = 1.0;  ///< two-sided
};

/// At each chip thickness that both have with two cuts or more and some scatter; thinnest first.
std::vector<SpeedEffect> speed_effects(const std::vector<OrthogonalCut>& slow,
                                       const std::vector<OrthogonalCut>& fast);

/// For each n the best K and F_e are a linear problem, so the fit is a search over n alone and
/// finds the global least of its bracket. Throws InvalidInput for fewer than four cuts or none of
/// different thickness.
PowerFit fit_power_law(const std::vector<OrthogonalCut>& cuts);
LogFit fit_log_law(const std::vector<OrthogonalCut>& cuts);

}  // namespace osteomill::cutting
