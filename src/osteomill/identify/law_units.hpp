// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "osteomill/cutting/cutting_law.hpp"

/// The unknowns of a cutting law that the forces are linear in.
namespace osteomill::identify {

enum class ForceComponent { tangential, radial, axial };

/// One unknown of a cutting law that the force is linear in: the force per width of cut that the
/// coefficient 1 would give, [tian2023] eqs. 8 and 11, [plaskos2002] eq. 1. Axial points from the
/// tip up: the lateral component of cutting::CuttingLaw with its sign changed.
struct UnitForce {
  enum class Kind {
    shear,              ///< h kappa^power
    edge,               ///< kappa^power wherever there is a chip
    edge_along_length,  ///< the same on a length of edge rather than on a width of cut
  };
  ForceComponent component = ForceComponent::tangential;
  Kind kind = Kind::shear;
  int power = 0;  ///< of kappa

  /// "Ktc", "Kre"; where powers are told apart "Ktc0", "Ktc1".
  std::string name(bool numbered) const;
};

/// The six of the linear law: Ktc Krc Kac Kte Kre Kae; without axial the four of the plane.
std::vector<UnitForce> linear_law_units(bool axial = true);

/// Those of cutting::PolynomialLaw: shear_order + 1 and edge_order + 1 of each component.
std::vector<UnitForce> polynomial_law_units(int shear_order, int edge_order);

/// Whether the names of these units carry their power of kappa.
bool numbered(const std::vector<UnitForce>& units);

/// The law of fitted coefficients: linear laws, or polynomials where powers of kappa are among
/// them; in the order of `units`.
cutting::CuttingLaw law_of(const std::vector<UnitForce>& units, const Eigen::VectorXd& values);

}  // namespace osteomill::identify
