// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/bone/provenance.hpp"

namespace osteomill::bone {

/// Apparent density of bone from a CT: density = at_zero + per_hounsfield × HU, never below 0.
/// A scanner with a phantom has its own line; the default is a published one.
struct DensityFromCt {
  Sourced at_zero{131.0, "kg/m3", Obtained::measured, "[rho1995]"};
  Sourced per_hounsfield{1.067, "kg/m3", Obtained::measured, "[rho1995]"};
};

/// Apparent density, kg/m³.
double apparent_density(double hounsfield, const DensityFromCt& line = {});

/// How a cutting force measured on bone of one density is carried over to another:
/// (density / reference)^exponent. No measured law of cutting force against density was found; the
/// square is that of compressive strength and is ASSUMED here.
struct ForceDensityLaw {
  Sourced reference{1900.0, "kg/m3", Obtained::assumed, "wet cortical bone"};
  Sourced exponent{2.0, "", Obtained::assumed, "as compressive strength"};
};

/// Force at a density over force at the reference density.
double force_scale(double density, const ForceDensityLaw& law = {});

}  // namespace osteomill::bone
