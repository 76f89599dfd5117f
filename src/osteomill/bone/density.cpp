// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/bone/density.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::bone {

double apparent_density(double hounsfield, const DensityFromCt& line) {
  return std::max(0.0, line.at_zero.value + line.per_hounsfield.value * hounsfield);
}

double force_scale(double density, const ForceDensityLaw& law) {
  require_positive("bone.reference_density_kg_per_m3", law.reference.value, "kg/m3");
  return std::pow(require_non_negative("density_kg_per_m3", density, "kg/m3") / law.reference.value,
                  law.exponent.value);
}

}  // namespace osteomill::bone
