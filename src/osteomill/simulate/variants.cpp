// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/variants.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::simulate {

void check(const VariantOptions& options) {
  require_non_negative("variants.gain_sigma", options.gain_sigma, "");
  require_positive("variants.correlation_mm", options.correlation / units::mm, "mm");
  require_non_negative("variants.noise_n", options.noise, "N");
  require_within("variants.delay_updates[0]", options.delay[0], 1, 100, "");
  require_within("variants.delay_updates[1]", options.delay[1], options.delay[0], 100, "");
  require_positive("variants.hard_width_mm", options.hard_width / units::mm, "mm");
  require_non_negative("map.error_mm", options.map_error / units::mm, "mm");
  require_positive("variants.hard_factor", options.hard_factor, "");
}

Variant vary(const LineProfile& profile, const Machine& machine, const VariantOptions& options,
             std::uint64_t number) {
  check(options);
  Random random(options.seed, number);
  Variant made{profile, machine};
  const double span = options.delay[1] - options.delay[0] + 1;
  made.machine.delay_updates =
      options.delay[0] + static_cast<int>(std::floor(span * random.uniform()));
  made.machine.force_noise = options.noise;
  made.machine.seed = random.bits();

  const double dx = 0.05e-3;  // 1/23 of a hard zone, 1/30 of the correlation length
  made.profile.variation_spacing = dx;
  const auto points = static_cast<std::size_t>(std::ceil(profile.line_length / dx)) + 1;
  const double memory = std::exp(-dx / options.correlation);
  for (int line = 0; line < profile.lines; ++line) {
    std::vector<double> factors(points);
    double g = random.normal();
    for (double& factor : factors) {
      factor = std::max(0.1, 1.0 + options.gain_sigma * g);
      g = memory * g + std::sqrt(1.0 - memory * memory) * random.normal();
    }
    if (options.hard_zones) {
      const double from = random.uniform(0.0, profile.line_length - options.hard_width);
      for (std::size_t i = 0; i < points; ++i) {
        const double x = static_cast<double>(i) * dx;
        if (x >= from && x <= from + options.hard_width) factors[i] *= options.hard_factor;
      }
    }
    made.profile.variation.push_back(std::move(factors));
  }
  // Last, so that bones and delays are those of a map without error.
  if (options.map_error > 0.0) {
    made.machine.map_offset = random.uniform(-options.map_error, options.map_error);
  }
  return made;
}

}  // namespace osteomill::simulate
