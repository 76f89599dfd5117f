// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/vibration/beam.hpp"

namespace osteomill::accuracy {

/// How far the tool gives way at one height when it is pushed at another, m/N; heights above the
/// tip. The same in x and y.
class ToolCompliance {
 public:
  /// A uniform shaft of the effective diameter, clamped at `length` above the tip:
  ///   δ(k, m) = F v_k² (3 v_m − v_k)/6EI for v_k <= v_m, else F v_m² (3 v_k − v_m)/6EI, v = l − z;
  /// [plaskos2002] eq. 10, where the first branch is printed with v_m². `support_compliance` adds
  /// what holds the tool (guide, fixation, bone), m/N.
  static ToolCompliance cantilever(double length, double effective_diameter, double youngs_modulus,
                                   double support_compliance = 0.0);
  /// A stepped beam on its supports; the tip is its free end.
  static ToolCompliance of_beam(const vibration::Beam& beam, double support_compliance = 0.0);

  double length() const { return length_; }  ///< free length, m
  double between(double height, double force_height) const;
  double tip_stiffness() const { return 1.0 / between(0.0, 0.0); }

 private:
  double length_ = 0.0;
  double bending_stiffness_ = 0.0;  ///< of a cantilever
  double support_ = 0.0;
  std::vector<double> stations_;  ///< of a beam: heights, from the tip
  std::vector<double> table_;     ///< compliance between stations
};

}  // namespace osteomill::accuracy
