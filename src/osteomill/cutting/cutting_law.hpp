// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "osteomill/cutting/edge_force.hpp"

namespace osteomill::cutting {

/// One force component of an edge, along the fibres and across them.
struct DirectionalLaw {
  EdgeForce at_0;  ///< the edge moves along the fibres, or any way when at_90 is unset
  std::optional<EdgeForce> at_90;  ///< the edge moves across the fibres
};

/// What to make of an edge that moves at an angle to the fibres between 0 and 90 degrees.
enum class OrientationCriterion {
  /// F = F0 F90 / (F0 |sin|^n + F90 |cos|^n); [plaskos2002] eq. 5, [plaskos2006] eq. 3.2. On the
  /// force per width; on the specific pressure it is the same, since both have the same chip.
  hankinson,
  /// Each component of the edge's motion meets its own law: [plaskos2002] eq. 4, [plaskos2006]
  /// eq. 3.1, there as the force on the work, here on the tool, and for any direction.
  puw_hocheng,
  /// The law of motion along the fibres in every direction.
  none,
};

/// The force per width of cut on an edge, N/m, in three components that act on the tool:
/// tangential against the edge's motion, radial along the inward normal of the cutter's envelope,
/// lateral along the envelope towards the tip (-z on a cylinder: [plaskos2006] eq. 3.5 with dFz =
/// -dF_l). The axial component of [tian2023] points the other way and enters with its sign changed.
struct CuttingLaw {
  DirectionalLaw tangential;
  DirectionalLaw radial;
  std::optional<DirectionalLaw> lateral;
  OrientationCriterion orientation = OrientationCriterion::hankinson;
  double orientation_exponent = 2.0;
  /// Inclination that the lateral law was measured at, rad; the force is taken as proportional to
  /// the local inclination, as [plaskos2006] 3.2.3 interpolates. 0: use the law as it is.
  double lateral_inclination = 0.0;
  /// Least chip that the edge lifts, m; below it the edge ploughs, and the forces fall in
  /// proportion to h from their values at this chip. 0: the law holds down to nothing. An
  /// assumption: no source here measured ploughing.
  double minimum_chip = 0.0;
};

/// Components of the force per width of cut, N/m.
struct EdgeComponents {
  double tangential = 0.0;
  double radial = 0.0;
  double lateral = 0.0;
};

/// Hankinson's criterion between the forces along (0) and across (90); zero where both are zero.
/// `cosine` is of the angle between motion and fibres.
double hankinson(double along, double across, double cosine, double exponent);

/// Components for an edge that moves at an angle with `cosine` to the fibres;
/// hankinson and none only, puw_hocheng mixes vectors (see milling_force.hpp).
EdgeComponents components(const CuttingLaw& law, const Chip& chip, double cosine,
                          const EdgePlace& place, double inclination);

/// Throws InvalidInput when the values make no law; fields are named "bone.tangential...".
void check(const CuttingLaw& law);

/// The law's edge forces alone: what an edge in contact takes whatever its chip. Nothing for laws
/// without edge force, which do not tell rubbing from cutting.
CuttingLaw edge_part(const CuttingLaw& law);
bool has_edge_force(const CuttingLaw& law);

/// The range that all components were measured on, m.
ChipRange range_of(const CuttingLaw& law);

}  // namespace osteomill::cutting
