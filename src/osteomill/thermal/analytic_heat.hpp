// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace osteomill::thermal {

/// What conduction needs of a material.
struct ThermalMaterial {
  double conductivity = 0.0;   ///< W/(m K)
  double heat_capacity = 0.0;  ///< per volume, J/(m³ K)
  double diffusivity() const { return conductivity / heat_capacity; }
};

/// Cortical bone: k 0.55 W/mK (published 0.16 to 4.9, above 0.6 doubtful), 1900 kg/m³ × 1300 J/kgK.
inline constexpr ThermalMaterial kCorticalBone{0.55, 1900.0 * 1300.0};

/// Temperature rise in a half space under a constant flux at its surface, K:
///   2 q/k sqrt(a t/pi) exp(-z²/4at) - q z/k erfc(z/(2 sqrt(at))); [carslaw1959] 2.9 (8).
double half_space_rise(const ThermalMaterial& material, double flux, double depth, double time);

/// Jaeger's strip source of half length l that moves along itself with v over a half space, quasi
/// steady: dimensionless surface temperature
///   theta(X) = integral from X - L to X + L of exp(u) K0(|u|) du,  L = v l/(2 a), X = v x/(2 a),
/// x ahead of the middle counted against the motion as printed; rise = 2 q a/(pi k v) theta.
/// [jaeger1942]. The largest value over X.
double jaeger_strip_maximum(double half_length_number);

}  // namespace osteomill::thermal
