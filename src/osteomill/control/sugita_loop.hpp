// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace osteomill::control {

/// How the sum of the loop filter is read; the paper prints no units that would decide it.
enum class SumReading : std::uint8_t {
  sum,      ///< as printed: gain in mm/s per N on the sum of the taps
  mean,     ///< taps normalised: gain in mm/s per N on their mean
  override  ///< as printed, the feed being in per cent of the full feed: gain in %/N on the sum
};

/// The published force loop: loop filter and accumulator.
///
///   L(i) = G sum_{k=i-4..i} (F_ref - F(k)),   v_ref(i) = v_ref(i-1) + L(i)
///
/// [sugita2009] eqs. 3 and 4, with G = 0.05 when the sum is not negative (acceleration) and 0.1
/// otherwise. The printed sum runs from i - n to i; "5 taps" in the text fixes it. As printed
/// (`sum`) the loop limit-cycles for every K_f that gives 12 N near 3 mm/s, so the paper cannot
/// have meant it in mm/s; see docs/theory/control.md.
struct SugitaLoop {
  double reference_force = 12.0;  ///< F_ref, N
  double gain_up = 0.05;          ///< per N, in the unit of the reading
  double gain_down = 0.1;         ///< per N, in the unit of the reading
  SumReading reading = SumReading::override;
  double full_feed = 12e-3;  ///< what 100 % are, m/s
};

/// Throws InvalidInput that names the field, when the values do not make a loop.
void check(const SugitaLoop& loop);

inline constexpr int kSugitaTaps = 5;

/// The last force differences, newest first.
struct SugitaState {
  std::array<double, kSugitaTaps> differences{};
};

/// Change of feed per N of the taps' sum, m/s: G in SI under the loop's reading.
double gain_on_sum(const SugitaLoop& loop, double gain) noexcept;

/// The new taps and the unlimited new feed, from the feed that was commanded last.
struct SugitaStep {
  SugitaState state;
  double feed = 0.0;  ///< m/s
};
SugitaStep step(const SugitaLoop& loop, const SugitaState& state, double last_feed,
                double mean_force) noexcept;

}  // namespace osteomill::control
