// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/thermal/thermal_dose.hpp"

#include <algorithm>
#include <cmath>

namespace osteomill::thermal {

double cem43_rate(double temperature) {
  const double above = std::min(temperature - kZeroCelsius, kBoilingCelsius) - 43.0;
  if (above <= 37.0 - 43.0) return 0.0;
  return std::exp2(above >= 0.0 ? above : 2.0 * above);
}

}  // namespace osteomill::thermal
