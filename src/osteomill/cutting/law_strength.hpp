// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/cutting/cutting_law.hpp"

namespace osteomill::cutting {

/// The law of bone that takes `strength` times the force in every component and at every chip: a
/// patient's bone against the catalogue's. strength > 0.
CuttingLaw scaled(const CuttingLaw& law, double strength);

}  // namespace osteomill::cutting
