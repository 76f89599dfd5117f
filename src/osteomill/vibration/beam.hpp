// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace osteomill::vibration {

/// One uniform piece of the tool, holder or attachment: a shaft, with a tube around it if there is
/// one.
struct BeamSegment {
  double length = 0.0;          ///< m
  double diameter = 0.0;        ///< outer diameter of the shaft, m
  double inner_diameter = 0.0;  ///< bore of the shaft, m
  /// Effective over outer diameter of a fluted piece, s in d_e = s d_o; [plaskos2002] §4.2.5 with
  /// s = 0.82 and 0.89 measured in §4.3.1. Stiffness and mass both take the effective diameter.
  double effective_diameter_factor = 1.0;
  double tube_outer_diameter = 0.0;  ///< tube that bends with the shaft, m; 0 when there is none
  double tube_inner_diameter = 0.0;  ///< m
};

enum class SupportType {
  clamp,  ///< neither deflection nor slope
  pin,    ///< no deflection: a bearing; it carries a reaction, so the shear force jumps there
  spring  ///< reaction in proportion to deflection and slope
};

struct Support {
  double position = 0.0;  ///< from the chuck end, m
  SupportType type = SupportType::clamp;
  double stiffness = 0.0;             ///< spring: N/m
  double rotational_stiffness = 0.0;  ///< spring: N m/rad
};

/// A stepped shaft from the chuck end (x = 0) to the free tip, with its supports.
struct Beam {
  std::vector<BeamSegment> segments;
  std::vector<Support> supports;
  double youngs_modulus = 0.0;  ///< Pa
  double density = 0.0;         ///< kg/m³
  double poissons_ratio = 0.3;
};

/// What a beam theory needs of one cross-section; shaft and tube add up, as they deflect together.
struct Section {
  double bending_stiffness = 0.0;  ///< E I, N m²
  double mass_per_length = 0.0;    ///< ρ A, kg/m
  double rotary_inertia = 0.0;     ///< ρ I, kg m
  double shear_stiffness = 0.0;    ///< κ G A, N; κ of [cowper1966] for solid and hollow circles
};

/// Throws InvalidInput that lists every fault: lengths, diameters, supports outside the beam, and
/// a beam that its supports do not hold.
void check(const Beam& beam);

double length(const Beam& beam);
Section section(const Beam& beam, const BeamSegment& segment);

/// Positions where a segment ends or a support stands, from 0 to the length, each once.
std::vector<double> stations(const Beam& beam);

/// Section at x; at a step, that of the piece to the right.
Section section_at(const Beam& beam, double x);

}  // namespace osteomill::vibration
