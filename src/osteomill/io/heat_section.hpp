// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/thermal/heat_partition.hpp"

namespace osteomill::io {

class Section;

/// The keys of [heat] that say where the energy of a cut goes; of `force` and of `simulate`.
void bind_partition(Section& section, thermal::PartitionOptions& partition);

}  // namespace osteomill::io
