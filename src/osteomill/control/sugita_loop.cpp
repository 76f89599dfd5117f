// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/sugita_loop.hpp"

#include <algorithm>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::control {

void check(const SugitaLoop& loop) {
  require_positive("controller.reference_force_n", loop.reference_force, "N");
  require_positive("controller.gain_up", loop.gain_up, "");
  require_positive("controller.gain_down", loop.gain_down, "");
  require_positive("controller.full_feed_mm_per_s", loop.full_feed / units::mm_per_s, "mm/s");
}

double gain_on_sum(const SugitaLoop& loop, double gain) noexcept {
  switch (loop.reading) {
    case SumReading::sum:
      return gain * units::mm_per_s;
    case SumReading::mean:
      return gain * units::mm_per_s / kSugitaTaps;
    case SumReading::override:
      break;
  }
  return gain / 100.0 * loop.full_feed;
}

SugitaStep step(const SugitaLoop& loop, const SugitaState& state, double last_feed,
                double mean_force) noexcept {
  SugitaStep next;
  next.state.differences[0] = loop.reference_force - mean_force;
  std::copy_n(state.differences.begin(), kSugitaTaps - 1, next.state.differences.begin() + 1);
  const double sum =
      std::accumulate(next.state.differences.begin(), next.state.differences.end(), 0.0);
  next.feed = last_feed + gain_on_sum(loop, sum >= 0.0 ? loop.gain_up : loop.gain_down) * sum;
  return next;
}

}  // namespace osteomill::control
