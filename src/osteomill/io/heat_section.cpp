// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/heat_section.hpp"

#include "osteomill/base/units.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {

void bind_partition(Section& section, thermal::PartitionOptions& partition) {
  section.number("rubbing_to_bone", partition.rubbing_to_bone, {}, between(0.0, 1.0),
                 "share of the rubbing heat", Need::optional);
  section.number("shear_strain", partition.shear_strain, {}, positive(), "of the chip",
                 Need::optional);
  section.number("friction_share", partition.friction_share, {}, between(0.0, 1.0),
                 "of the cutting heat that arises on the rake face", Need::optional);
  section.number("friction_to_tool", partition.friction_to_tool, {}, between(0.0, 1.0),
                 "of the rake face's heat; the rest goes with the chip", Need::optional);
  section.number("least_chip_um", partition.least_chip, {units::um, "um"}, non_negative(),
                 "an edge that comes from no chip ploughs until its chip is this thick: up-milling",
                 Need::optional);
}

}  // namespace osteomill::io
