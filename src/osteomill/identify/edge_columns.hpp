// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/envelope.hpp"
#include "osteomill/identify/law_units.hpp"

namespace osteomill::identify {

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
  /// or per N/m (edge, power and log). `exponents` are those of the units, in their order.
  Eigen::MatrixXd at(const std::vector<double>& angle, double phase, const cutting::RunOut& run_out,
                     const Eigen::Ref<const Eigen::VectorXd>& exponents = Eigen::VectorXd()) const;

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
  /// The same between the ends of a panel, without weight.
  Place place_in(std::size_t panel, double length) const;

  cutting::Cutter cutter_;
  cutting::Condition condition_;
  cutting::LateralBand band_;
  cutting::Envelope envelope_;
  std::vector<UnitForce> units_;
  std::vector<double> ends_;    ///< of panels, lengths along the meridian
  std::vector<Place> at_ends_;  ///< just inside
  std::vector<bool> upright_;   ///< panels on a cylinder
  std::vector<Place> nodes_;    ///< three a panel
};

}  // namespace osteomill::identify
