// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/cutting/cutting_law.hpp"

namespace osteomill::cutting {

/// A cutting law together with the edge geometry that it was measured with.
struct TestedLaw {
  CuttingLaw law;
  double angle = 0.0;  ///< rake, or inclination of the edge, rad
};

/// What interpolation gives and how far it is from the exact blend.
struct InterpolatedLaw {
  CuttingLaw law;
  double largest_deviation = 0.0;  ///< relative, of any component over the common range
};

/// The law for an angle between two tested ones. At each chip thickness the force is linear in the
/// angle, as [plaskos2006] 3.2.3 has it ("interpolated linearly between 0 and 20 degrees rake");
/// the blend is written as a log law again, fitted over the range that both laws share, and its
/// deviation is stated. Log laws only. A direction that only one law tells apart is taken from the
/// single law of the other. InvalidInput outside the two angles: nothing is extrapolated.
InterpolatedLaw interpolate(const TestedLaw& low, const TestedLaw& high, double angle);

/// Which law speaks at a surface speed: [plaskos2006] 3.2.3 has the low-speed law up to 100 rpm and
/// the high-speed law above, on the cutter at hand. There is no data between 0.1 and 0.3 m/s, so
/// the change is a step, there.
const CuttingLaw& law_at_speed(const CuttingLaw& low_speed, const CuttingLaw& high_speed,
                               double spindle_speed);

}  // namespace osteomill::cutting
