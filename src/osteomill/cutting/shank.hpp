// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace osteomill::cutting {

struct Cutter;

/// How a cutter is made and held beyond its edges: what deflection and vibration need of it.
struct Shank {
  double free_length = 0.0;     ///< from the tip to where it is held: the overhang, m
  double diameter = 0.0;        ///< of the shank above the edges, m
  double youngs_modulus = 0.0;  ///< Pa
  double density = 0.0;         ///< kg/m³
  /// Diameter of a round shaft that bends as the fluted part over the cutter's diameter: s in
  /// d_e = s d_o, 0.82 and 0.89 measured in [plaskos2002] 4.3.1.
  double effective_diameter_factor = 0.8;
  /// Of holder, spindle or bearing at the held end, N/m and N m/rad; both 0: rigid.
  double holder_stiffness = 0.0;
  double holder_rotational_stiffness = 0.0;
};

/// Throws InvalidInput with every fault, named "cutter.shank...".
void check(const Shank& shank, const Cutter& cutter);

}  // namespace osteomill::cutting
