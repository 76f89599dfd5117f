// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace osteomill::thermal {

inline constexpr double kZeroCelsius = 273.15;    ///< K
inline constexpr double kBoilingCelsius = 100.0;  ///< of the water in the bone, °C

/// Rate of thermal dose: equivalent minutes at 43 °C a minute, R^(43 - T), R = 0.5 from 43 °C up
/// and 0.25 below; [sapareto1984]. Nothing at body temperature and below. What is hotter than
/// boiling water counts as 100 °C: dead at once, and the rate would grow beyond any number.
double cem43_rate(double temperature);

/// Dose of a constant temperature, in equivalent minutes at 43 °C; times in s.
inline double cem43_minutes(double temperature, double time) {
  return cem43_rate(temperature) * time / 60.0;
}

/// Dose at which bone counts as damaged, equivalent minutes: that of 47 °C for one minute, the
/// limit of [eriksson1983]. 50 °C for 30 s is four times as much.
inline constexpr double kBoneDamageCem43 = 16.0;

/// Limits in its place: a temperature, K, that bone must not have for longer than a time, s, all
/// times above it together. [eriksson1983] and, for 50 °C, [lundskog1972].
struct ThermalLimit {
  double temperature = 0.0;
  double time = 0.0;
};
inline constexpr ThermalLimit k47For60s{kZeroCelsius + 47.0, 60.0};
inline constexpr ThermalLimit k50For30s{kZeroCelsius + 50.0, 30.0};

}  // namespace osteomill::thermal
