// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "osteomill/cutting/cutting_law.hpp"
#include "osteomill/identify/experiment.hpp"

namespace osteomill::identify {

enum class LawForm {
  linear,  ///< F = K_c h + K_e per width of cut, [plaskos2002] eq. 1
  /// F = h sum c_i kappa^i + S sum e_i kappa^i, [tian2023] eqs. 5 and 11: the edge force is per
  /// length of edge, S times longer than the width of cut.
  polynomial,
  power,  ///< F = K h^n + F_e, [plaskos2006] eq. 2.2
  log,    ///< log10 F = K3 L² + K2 L + K1, [plaskos2006] eq. 2.3
};

/// The form of a cutting law whose coefficients are to be found; each component has its own.
struct ForceModel {
  LawForm form = LawForm::linear;
  int shear_order = 0;       ///< polynomial: of the pressures in kappa; -1: none, linear as well
  int edge_order = 0;        ///< polynomial: of the edge forces in kappa; -1: none, linear as well
  bool edge_force = false;   ///< power: with the constant F_e
  bool directional = false;  ///< power and log: one law along the fibres, one across (Hankinson)

  bool operator==(const ForceModel&) const = default;
};

/// "linear", "shear order 3, edge order 0", "edge order 2 without shear", "log", "power with edge
/// force, along and across the fibres"
std::string name_of(const ForceModel& model);

/// Whether the forces are linear in the coefficients: linear and polynomial.
bool is_linear(const ForceModel& model);

enum class Dimension { pressure, force_per_width, number };

/// Units as the catalogue has them: N/mm², N/mm, 1. Value in SI = value in the unit × factor.
double factor_of(Dimension dimension);
const char* unit_of(Dimension dimension);

/// A coefficient that is to be found, with what it may be, in SI.
struct CoefficientKey {
  std::string name;
  Dimension dimension = Dimension::number;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

/// Names follow [tian2023]: Ktc0 … of the pressures, Kte0 … of the edge forces, the number left out
/// where there is one only; t, r, a are tangential, radial (inwards), axial (along the meridian
/// away from the tip, as there). Power: Kt, nt, Fte …; log: Kt1, Kt2, Kt3 …; their third component
/// is lateral, l, towards the tip ([plaskos2006] eq. 3.5), since such a law cannot be negative.
std::vector<CoefficientKey> coefficients_of(const ForceModel& model);

/// The law with these values, SI, in the order of coefficients_of. `inclination` is that of the
/// edges it is measured on, rad; see CuttingLaw::lateral_inclination.
cutting::CuttingLaw law_of(const ForceModel& model, const Eigen::VectorXd& values,
                           const cutting::ChipRange& range = {}, double inclination = 0.0);

/// Mean forces of the experiments under a law, N: x, y, z of the first, then of the second, ...
Eigen::VectorXd mean_forces(const cutting::CuttingLaw& law,
                            const std::vector<Experiment>& experiments);

/// Measured forces in the same order.
Eigen::VectorXd measured_forces(const std::vector<Experiment>& experiments);

/// Derivatives of the mean forces by the coefficients. Of a linear model they are the forces of
/// unit coefficients, integrated by the cutting room ([tian2023] eq. 16); of the others central
/// differences.
Eigen::MatrixXd sensitivities(const ForceModel& model, const Eigen::VectorXd& values,
                              const std::vector<Experiment>& experiments);

/// Where to begin the search of a model that is not linear: the power law with one exponent for
/// all components that fits best.
Eigen::VectorXd starting_values(const ForceModel& model,
                                const std::vector<Experiment>& experiments);

/// Smallest and largest value among the experiments of the largest chip of each, m.
cutting::ChipRange chip_range(const std::vector<Experiment>& experiments);

/// Largest axial position angle in the cuts, rad.
double largest_kappa(const std::vector<Experiment>& experiments);

/// Helix angle that all cutters share when all are cylinders, rad; 0 otherwise.
double common_inclination(const std::vector<Experiment>& experiments);

}  // namespace osteomill::identify
