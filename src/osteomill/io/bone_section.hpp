// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/bone/density.hpp"
#include "osteomill/bone/provenance.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/cutting_law.hpp"

/// The table [bone] of a case.
namespace osteomill::io {

class Section;

/// Which angle of the edge tested laws differ in.
enum class TestedBy { rake, inclination };

/// [bone]: the cutting law, the density that it was measured at, and where it comes from.
struct BoneCase {
  cutting::CuttingLaw law;
  bone::ForceDensityLaw density;
  double strength = 1.0;             ///< times the law's force; the law has it in it
  std::optional<double> rake_angle;  ///< of the edges that the law was measured with, rad
  std::optional<std::array<double, 2>>
      speed_range;  ///< surface speeds that it was measured at, m/s
  bone::Provenance provenance;
  std::vector<BoneCase> tested;  ///< laws to interpolate between; `law` is unset then
  TestedBy tested_by = TestedBy::rake;
  std::vector<BoneCase> low_speed;  ///< none or one: holds up to 100 rpm
  std::vector<std::string> notes;   ///< what settle() has to say
};
void bind_bone(Section& section, BoneCase& bone);

/// Makes one law of a [bone] with several: that of the speed regime (see cutting::law_at_speed),
/// then that between the tested angles on both sides of the cutter's rake or helix. Does nothing
/// else than check a plain one. Every command that cuts calls it.
void settle(BoneCase& bone, const cutting::Cutter& cutter,
            std::optional<double> spindle_speed = {});

void bind_provenance(Section& section, bone::Provenance& provenance);

}  // namespace osteomill::io
