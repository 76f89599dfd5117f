// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/milling_force.hpp"

namespace osteomill::cutting {

/// Forces over a revolution, N, at equal steps of the rotation angle; structure of arrays.
struct SlicedRevolution {
  std::vector<double> x, y, z;
};

struct SliceOptions {
  int steps = 360;
  int slices = 100;
  bool vectorise = true;  ///< false: the plain loop, one element after the other
};

/// The algorithm of [plaskos2006] 3.2.3: the cutter in axial slices, each edge element taken at the
/// middle of its slice, the cutter turned step by step. Fast where log or power laws meet Hankinson
/// (n = 2): elements in contact are found by exact arcs and their forces worked out in vectors. Its
/// error is of second order in the slices for smooth laws; `revolution` has none of it.
/// Equal flutes on a circular path only.
SlicedRevolution sliced_revolution(const Cutter& cutter, const CuttingLaw& law,
                                   const Condition& condition, const Immersion& immersion,
                                   const SliceOptions& options = {});

}  // namespace osteomill::cutting
