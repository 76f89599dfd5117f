// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/vibration/regeneration.hpp"

namespace osteomill::vibration {

/// Rotation angles between which an edge of a cylinder is in the bone, rad.
struct ContactAngles {
  double entry = 0.0;
  double exit = 0.0;
};

/// Of a slot 0 … π; with `share` the radial depth over the diameter, up 0 … arccos(1 − 2 share),
/// down the mirror image; [altintas1995].
ContactAngles contact_angles(cutting::ImmersionKind kind, double share);

/// The regeneration of a cut in bone: the slopes of its non-linear, anisotropic law at the chip
/// that the edge has at each rotation angle. A law with an infinite slope at h = 0 is taken at no
/// less than `thinnest_chip`: there the vibration itself makes the chip. Cylindrical cutters only.
Regeneration linearised_cut(const cutting::Cutter& cutter, const cutting::CuttingLaw& law,
                            const cutting::Condition& condition,
                            const cutting::Immersion& immersion, double thinnest_chip = 0.5e-6);

}  // namespace osteomill::vibration
