// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/envelope.hpp"
#include "osteomill/cutting/flutes.hpp"

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

/// Forces over a revolution of each unit force: what the unknown coefficients are multiplied with.
/// The mechanics are those of cutting::revolution; here all units are integrated in one pass, and
/// the part of an edge that lifts a chip is cut off exactly where run-out leaves it none, so that
/// the forces are smooth functions of the run-out.
class EdgeColumns {
 public:
  EdgeColumns(const cutting::Cutter& cutter, const cutting::Condition& condition,
              const cutting::Immersion& immersion, std::vector<UnitForce> units);

  /// Forces at rotation angles `angle - phase` of flute 0's tip, rad, with this run-out in place of
  /// the cutter's: 3 n rows (x of all angles, then y, then z), one column a unit; N per Pa (shear)
  /// or per N/m (edge).
  Eigen::MatrixXd at(const std::vector<double>& angle, double phase,
                     const cutting::RunOut& run_out) const;

  const std::vector<UnitForce>& units() const { return units_; }
  const cutting::Cutter& cutter() const { return cutter_; }
  const cutting::Condition& condition() const { return condition_; }

 private:
  struct Place {  ///< a point of the meridian with what every angle needs of it
    cutting::ProfilePoint point;
    double weight = 0.0;  ///< width of cut, m; zero at the end of a panel
    double sin_lag = 0.0, cos_lag = 1.0;
    double sin_kappa = 1.0, cos_kappa = 0.0;
  };
  Place place_at(double length, double weight) const;

  cutting::Cutter cutter_;
  cutting::Condition condition_;
  cutting::LateralBand band_;
  cutting::Envelope envelope_;
  std::vector<UnitForce> units_;
  std::vector<double> ends_;    ///< of panels, lengths along the meridian
  std::vector<Place> at_ends_;  ///< just inside
  std::vector<Place> nodes_;    ///< three a panel
};

}  // namespace osteomill::identify
