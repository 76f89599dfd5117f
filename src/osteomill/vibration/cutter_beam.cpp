// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/cutter_beam.hpp"

#include "osteomill/base/error.hpp"

namespace osteomill::vibration {

Beam beam_of(const cutting::Cutter& cutter) {
  if (!cutter.shank) {
    throw InvalidInput(Fault{"cutter.shank", "", "is missing",
                             "describe how the cutter is held, or give a [beam]"});
  }
  const cutting::Shank& shank = *cutter.shank;
  cutting::check(shank, cutter);
  Beam beam;
  beam.youngs_modulus = shank.youngs_modulus;
  beam.density = shank.density;
  // Rounding of lengths in millimetres leaves no piece of nothing.
  const double plain = shank.free_length - cutter.cutting_length;
  if (plain > 1e-9) beam.segments.push_back({.length = plain, .diameter = shank.diameter});
  beam.segments.push_back({.length = plain > 1e-9 ? cutter.cutting_length : shank.free_length,
                           .diameter = 2.0 * cutter.radius,
                           .effective_diameter_factor = shank.effective_diameter_factor});
  Support held{.position = 0.0, .type = SupportType::clamp};
  if (shank.holder_stiffness > 0.0) {
    held = {0.0, SupportType::spring, shank.holder_stiffness, shank.holder_rotational_stiffness};
  }
  beam.supports = {held};
  return beam;
}

}  // namespace osteomill::vibration
