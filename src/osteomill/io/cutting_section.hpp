// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "osteomill/bone/density.hpp"
#include "osteomill/bone/provenance.hpp"
#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/cutting_law.hpp"
#include "osteomill/cutting/tilted_cut.hpp"
#include "osteomill/io/bone_section.hpp"

/// The tables [cutter], [bone] and [cut] of a case.
namespace osteomill::io {

class Section;

/// [cutter]: the shape, and what the catalogue says of it.
struct CutterCase {
  cutting::Cutter cutter;
  bone::Provenance provenance;
};
void bind_cutter(Section& section, CutterCase& cutter);

/// What a result that uses them has to say: values that were not measured, a law that was measured
/// with another rake or, when the spindle speed is given, at other speeds.
std::vector<std::string> caveats_of(const CutterCase& cutter, const BoneCase& bone,
                                    std::optional<double> spindle_speed = {});

/// [cut]: one cutting condition. The feed is given as a rate or a tooth.
struct CutCase {
  double spindle_speed = 0.0;            ///< rad/s
  std::optional<double> feed_rate;       ///< m/s
  std::optional<double> feed_per_tooth;  ///< m
  double feed_elevation = 0.0;           ///< rad
  double fibre_angle = 0.0;              ///< from the feed, rad
  double fibre_elevation = 0.0;          ///< above the plane normal to the axis, rad
  cutting::Immersion immersion;
  double lead = 0.0;  ///< lean of the axis towards the feed, rad
  double tilt = 0.0;  ///< lean of the axis towards +y, rad
  cutting::ToothPath path = cutting::ToothPath::circular;
};
/// `nominal`: with the keys of the immersion and the lean; otherwise a map says what is in bone.
void bind_cut(Section& section, CutCase& cut, bool nominal = true);

/// The leaning cut of the tables, when lead or tilt is not 0.
std::optional<cutting::TiltedCut> tilted_cut_of(const CutCase& cut);

/// The condition of a cut; checked against the cutter, with all faults of both at once.
cutting::Condition condition_of(const CutCase& cut, const cutting::Cutter& cutter,
                                bool nominal = true);

}  // namespace osteomill::io
