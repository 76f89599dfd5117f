// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/thermal/analytic_heat.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::thermal {

double half_space_rise(const ThermalMaterial& material, double flux, double depth, double time) {
  require_non_negative("time_s", time, "s");
  if (time == 0.0) return 0.0;
  const double at = material.diffusivity() * time;
  return flux / material.conductivity *
         (2.0 * std::sqrt(at / std::numbers::pi) * std::exp(-depth * depth / (4.0 * at)) -
          depth * std::erfc(depth / (2.0 * std::sqrt(at))));
}

namespace {

// Integrals of exp(-+u) K0(u) from 0 to x: x exp(-+x) (K0(x) -+ K1(x)) +- 1, by differentiation
// with K0' = -K1, K1' = -K0 - K1/x and x K1 -> 1.
double integral_ahead(double x) {
  if (x == 0.0) return 0.0;
  return x * std::exp(-x) * (std::cyl_bessel_k(0.0, x) - std::cyl_bessel_k(1.0, x)) + 1.0;
}
double integral_behind(double x) {
  if (x == 0.0) return 0.0;
  return x * std::exp(x) * (std::cyl_bessel_k(0.0, x) + std::cyl_bessel_k(1.0, x)) - 1.0;
}

}  // namespace

double jaeger_strip_maximum(double half_length_number) {
  const double length = require_positive("half_length_number", half_length_number, "");
  const auto theta = [&](double x) {
    const auto to = [](double u) { return u >= 0.0 ? integral_behind(u) : -integral_ahead(-u); };
    return to(x + length) - to(x - length);
  };
  // One hump between the middle and the trailing edge: golden section.
  double low = 0.0, high = length;
  constexpr double kGolden = 0.61803398874989485;
  for (int step = 0; step < 60; ++step) {
    const double left = high - kGolden * (high - low), right = low + kGolden * (high - low);
    if (theta(left) < theta(right))
      low = left;
    else
      high = right;
  }
  return theta(0.5 * (low + high));
}

}  // namespace osteomill::thermal
