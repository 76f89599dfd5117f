// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/vibration/beam.hpp"
#include "osteomill/vibration/modal.hpp"

namespace osteomill::vibration {

enum class BeamTheory {
  euler_bernoulli,  ///< bending and transverse inertia only
  timoshenko        ///< with shear deformation and rotary inertia: stout shafts, high modes
};

enum class Mesh {
  aligned,  ///< a node at every step and support; elements shared out by length
  equal     ///< equal elements; a support inside an element holds its interpolated deflection
};

struct ElementOptions {
  int elements = 40;
  BeamTheory theory = BeamTheory::euler_bernoulli;
  Mesh mesh = Mesh::aligned;
};

/// Mass and stiffness of a beam, its supports eliminated, with its modes.
///
/// Two-node elements with deflection and slope at each node ([plaskos2002] A.1.2 has nine of them);
/// the shape functions are the static solutions of each theory, the mass is consistent. A support
/// between nodes makes the solution's third derivative jump inside an element, which costs one
/// order of convergence: prefer the aligned mesh.
class BeamModel {
 public:
  BeamModel(const Beam& beam, const ElementOptions& options);

  int modes() const { return static_cast<int>(frequencies_hz_.size()); }
  /// Undamped natural frequencies at rest, Hz, lowest first.
  const std::vector<double>& natural_frequencies_hz() const { return frequencies_hz_; }
  /// Deflection at the positions in a mode, scaled so that the largest of them is 1.
  std::vector<double> shape(int mode, const std::vector<double>& positions) const;
  /// Deflection at x in a mode of unit modal mass, kg^(-1/2).
  double normalised_deflection(int mode, double x) const;
  /// Static deflection at `at` under a unit force at `force_at`, m/N.
  double static_compliance(double at, double force_at) const;
  /// Whirl frequencies when the shaft turns with the spindle, Hz: backward and forward of each of
  /// the lowest modes in one list, lowest first. At rest each mode appears twice. With
  /// z = v + i w: M z̈ − i Ω G ż + K z = 0, G from the polar inertia 2ρI; [genta2005] §6.
  std::vector<double> whirl_frequencies_hz(double spindle_speed, int count) const;

 private:
  std::vector<double> nodes_;
  std::vector<double> shear_;                    ///< Φ = 12 EI/(κGA l²) of each element
  std::vector<std::vector<double>> vectors_;     ///< all freedoms, unit modal mass, by mode
  std::vector<std::vector<double>> gyroscopic_;  ///< Φᵀ G Φ over the lowest modes
  std::vector<double> frequencies_hz_;
};

/// The lowest modes at the tip, in one direction, all with the same damping ratio.
std::vector<Mode> tip_modes(const BeamModel& model, double tip, int count, double damping_ratio,
                            double direction_x, double direction_y);

}  // namespace osteomill::vibration
