// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/simulate/line_profile.hpp"
#include "osteomill/simulate/milling.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::io {

/// A line profile has no shape of its own; for the eye it is a slab of its lines, each as deep as
/// the axial depth: the wall is y = 0 with the bone behind it at y > 0, line i lies between z = -i
/// a_p and -(i + 1) a_p. In place of a density its voxels hold the cutting gain, N/(mm/s).
workpiece::Stock slab_of(const simulate::LineProfile& profile);

/// Mills the slab as far as the steps came.
void mill_slab(const std::vector<simulate::Step>& steps, const cutting::Cutter& cutter,
               workpiece::Stock& slab);

}  // namespace osteomill::io
