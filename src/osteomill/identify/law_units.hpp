// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "osteomill/cutting/cutting_law.hpp"

/// The unknowns of a cutting law that the forces are linear in.
namespace osteomill::identify {

enum class ForceComponent {
  tangential,
  radial,
  axial,    ///< along the meridian away from the tip
  lateral,  ///< towards the tip
};

/// "tangential", …
const char* name_of(ForceComponent component);

/// One unknown of a cutting law that the force is linear in: the force per width of cut that the
/// coefficient 1 would give, [tian2023] eqs. 8 and 11, [plaskos2002] eq. 1. Axial is the lateral
/// component of cutting::CuttingLaw with its sign changed. Power and log laws are linear in their
/// factor, not in their exponents, which are unknowns of their own: its `exponents()`.
struct UnitForce {
  enum class Kind {
    shear,              ///< h kappa^power
    edge,               ///< kappa^power wherever there is a chip
    edge_along_length,  ///< the same on a length of edge rather than on a width of cut
    power,              ///< (h / 1 mm)^n, [plaskos2006] eq. 2.2
    log,                ///< 10^(K2 L + K3 L²), L = log10(h / 1 µm), [plaskos2006] eq. 2.3
    edge_of_power,      ///< the constant of a power law: as edge
  };
  ForceComponent component = ForceComponent::tangential;
  Kind kind = Kind::shear;
  int power = 0;  ///< of kappa

  /// "Ktc", "Kre"; where powers are told apart "Ktc0", "Ktc1"; "Kt", "Fte" of a power law, "Kt1" of
  /// a log law, whose first number is the logarithm of the factor.
  std::string name(bool numbered) const;
  /// How many exponents it has: 0, 1 or 2.
  int exponents() const { return kind == Kind::power ? 1 : (kind == Kind::log ? 2 : 0); }
  /// "nt"; "Kt2", "Kt3".
  std::vector<std::string> exponent_names() const;
};

int exponents_of(const std::vector<UnitForce>& units);

/// The six of the linear law: Ktc Krc Kac Kte Kre Kae; without axial the four of the plane.
std::vector<UnitForce> linear_law_units(bool axial = true);

/// Those of cutting::PolynomialLaw: shear_order + 1 and edge_order + 1 of each component.
std::vector<UnitForce> polynomial_law_units(int shear_order, int edge_order);

/// Those of power laws, with their constant if asked for, and of log laws: tangential, radial,
/// lateral.
std::vector<UnitForce> power_law_units(bool edge_force);
std::vector<UnitForce> log_law_units();

/// Whether the names of these units carry their power of kappa.
bool numbered(const std::vector<UnitForce>& units);

/// The law of fitted coefficients: linear laws, polynomials where powers of kappa are among them,
/// power or log laws; in the order of `units`, then the exponents in the same order. A log law's
/// factor is given as its logarithm, K1.
/// @param inclination  of the edges the law was measured on, rad: CuttingLaw::lateral_inclination
cutting::CuttingLaw law_of(const std::vector<UnitForce>& units, const Eigen::VectorXd& values,
                           double inclination = 0.0);

}  // namespace osteomill::identify
