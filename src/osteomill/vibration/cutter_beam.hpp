// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/vibration/beam.hpp"

namespace osteomill::vibration {

/// A cutter with its shank as a beam: the shank from where it is held, then the fluted part with
/// its effective diameter (of the full diameter, whatever the shape of the tip); clamped, or on the
/// holder's springs. Throws InvalidInput for a cutter that says nothing of its shank.
Beam beam_of(const cutting::Cutter& cutter);

}  // namespace osteomill::vibration
