// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

/// Factors from the field's units to SI. `3.0 * units::mm` is a length in metres;
/// `length / units::mm` is a number of millimetres.
namespace osteomill::units {

inline constexpr double mm = 1e-3;
inline constexpr double um = 1e-6;
inline constexpr double deg = std::numbers::pi / 180.0;
inline constexpr double rpm = 2.0 * std::numbers::pi / 60.0;  // to rad/s
inline constexpr double minute = 60.0;
inline constexpr double ms = 1e-3;
inline constexpr double gpa = 1e9;
inline constexpr double mpa = 1e6;
inline constexpr double hz = 1.0;  // cycles per second stay cycles per second

inline constexpr double mm_per_s = mm;
inline constexpr double mm_per_min = mm / minute;
inline constexpr double mm2 = mm * mm;
inline constexpr double mm3 = mm * mm * mm;
inline constexpr double n_per_mm = 1.0 / mm;
inline constexpr double n_per_mm2 = 1.0 / mm2;
inline constexpr double n_mm = mm;  // moment

}  // namespace osteomill::units
