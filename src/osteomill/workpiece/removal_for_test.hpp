// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/base/units.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/cutting_law.hpp"

/// Cutters and a law for the tests of removal.
namespace osteomill::workpiece {

inline cutting::Cutter cylinder(double diameter) {
  cutting::Cutter cutter;
  cutter.radius = 0.5 * diameter;
  cutter.cutting_length = 10 * units::mm;
  return cutter;
}

inline cutting::Cutter ball(double diameter) {
  cutting::Cutter cutter = cylinder(diameter);
  cutter.shape = cutting::CutterShape::ball;
  return cutter;
}

inline cutting::Cutter bull(double diameter, double corner) {
  cutting::Cutter cutter = cylinder(diameter);
  cutter.shape = cutting::CutterShape::bull;
  cutter.corner_radius = corner;
  return cutter;
}

/// A law with chip thickness and with rubbing, so that both kinds of weighting count.
inline cutting::CuttingLaw chip_and_rubbing_law() {
  const auto linear = [](double per_area, double per_length) {
    return cutting::DirectionalLaw{cutting::LinearLaw(per_area, per_length), {}};
  };
  cutting::CuttingLaw law;
  law.tangential = linear(100e6, 2e3);
  law.radial = linear(60e6, 3e3);
  law.orientation = cutting::OrientationCriterion::none;
  return law;
}

}  // namespace osteomill::workpiece
