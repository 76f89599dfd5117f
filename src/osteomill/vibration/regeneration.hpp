// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <complex>
#include <functional>
#include <vector>

#include "osteomill/vibration/modal.hpp"

namespace osteomill::vibration {

/// How much more force an edge makes when its chip gets thicker: ∂F/∂h per unit edge length, N/m².
/// For a linear law these are its cutting coefficients K_tc and K_rc; for any other law the slope
/// at the chip thickness that the edge has at that angle.
struct EdgeStiffness {
  double tangential = 0.0;
  double radial = 0.0;
};

/// How the force on the tool answers the vibration of the tip while the cutter turns.
///
/// A tip displaced by d makes the chip thicker by n·(d(t) − d(t − T)), n = (sin θ, cos θ) and T the
/// tooth period; with the forces on the tool of [plaskos2006] §3.2 each edge in the cut adds
///   ΔF = W(θ) (d(t) − d(t − T)),  W = (K_t t − K_r n) nᵀ,  t = (−cos θ, sin θ),  N/m².
/// Down-milling has θ in (π/2, π], up-milling in [0, π/2), a slot [0, π].
class Regeneration {
 public:
  /// Constant coefficients. `lag` is the angle by which an edge lags per metre above the tip,
  /// tan(helix)/R.
  Regeneration(int flutes, double entry, double exit, double lag, EdgeStiffness stiffness);
  /// Coefficients that depend on the rotation angle: a non-linear or anisotropic law linearised at
  /// the working point. Taken as constant in each of `cells` parts of the cut.
  Regeneration(int flutes, double entry, double exit, double lag,
               const std::function<EdgeStiffness(double theta)>& stiffness, int cells = 360);

  int flutes() const { return flutes_; }
  double pitch() const;
  bool has_helix() const { return lag_ != 0.0; }
  double entry() const { return entry_; }
  double exit() const { return exit_; }
  double lag() const { return lag_; }

  /// Mean over rotation angles from theta_0 to theta_1 of the sum over all edges and the depth:
  /// stiffness that the cut adds, N/m.
  Eigen::Matrix2d mean(double theta_0, double theta_1, double depth) const;
  /// At one angle, N/m.
  Eigen::Matrix2d at(double theta, double depth) const;
  /// Fourier coefficient over a pitch per unit depth of straight flutes, N/m²:
  /// Σ_r W_r e^{i r N θ}. W_0 is the mean, which the helix does not change.
  Eigen::Matrix2cd harmonic(int r) const;
  /// What the helix makes of it, the mean of e^{−i r N Λ z} over a depth; 1 for straight flutes.
  std::complex<double> helix_factor(int r, double depth) const;
  /// Slope of one edge at a rotation angle reduced to [0, 2π); zero out of the cut.
  EdgeStiffness edge(double theta) const;
  /// Angles in [0, pitch) at which W jumps, or has a kink when there is a helix.
  std::vector<double> breaks(double depth) const;

 private:
  /// ∫₀^θ of one edge's W, continued over all revolutions.
  Eigen::Matrix2d integral(double theta) const;
  Eigen::Matrix2d integral_over_edges(double theta) const;

  int flutes_;
  double entry_, exit_, lag_;
  std::vector<EdgeStiffness> cells_;
  std::vector<Eigen::Matrix2d> cumulative_;  ///< integral at the lower end of each cell, and total
};

/// Modes and cut together, reduced to the directions in which the tip can move. A measured
/// receptance, in the same directions, takes the place of the modes in the frequency-domain
/// methods; those in time need the modes that were fitted to it.
class RegenerativeSystem {
 public:
  RegenerativeSystem(std::vector<Mode> modes, Regeneration cut, Receptance measured = {});

  /// Measured, or that of the modes; m/N, at any frequency, the conjugate below zero.
  TipReceptance receptance(double frequency_hz) const;

  const std::vector<Mode>& modes() const { return modes_; }
  const Regeneration& cut() const { return cut_; }
  int outputs() const { return static_cast<int>(basis_.cols()); }  ///< 1 or 2
  int states() const { return 2 * static_cast<int>(modes_.size()); }
  const Eigen::Matrix2Xd& basis() const { return basis_; }
  /// Tip displacement in the basis from the modal coordinates, outputs × modes.
  const Eigen::MatrixXd& shapes() const { return shapes_; }
  /// Free vibration ẏ = A y of y = (q, q̇/ω₀); ω₀ keeps both halves of one size.
  const Eigen::MatrixXd& free_motion() const { return free_motion_; }
  /// ẏ = … + B F for a force in the basis.
  const Eigen::MatrixXd& input() const { return input_; }
  double reference_omega() const { return reference_omega_; }
  double highest_frequency_hz() const;
  double tooth_period(double spindle_speed) const { return cut_.pitch() / spindle_speed; }

 private:
  std::vector<Mode> modes_;
  Regeneration cut_;
  Receptance measured_;
  Eigen::Matrix2Xd basis_;
  Eigen::MatrixXd shapes_, free_motion_, input_;
  double reference_omega_ = 0.0;
};

}  // namespace osteomill::vibration
