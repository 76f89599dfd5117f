// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/profile_slab.hpp"

#include <algorithm>
#include <cmath>

#include "osteomill/workpiece/remover.hpp"

namespace osteomill::io {

using geometry::Vector3;
using workpiece::Stock;

namespace {

constexpr double kSpacing = 0.4e-3;     // m
constexpr double kThickness = 8e-3;     // behind the wall, m
constexpr double kBelowLines = 10e-3;   // below the last line, m
constexpr double kPerNewtonMms = 1e-3;  // N/(m/s) to N/(mm/s)

}  // namespace

Stock slab_of(const simulate::LineProfile& profile) {
  const double depth = profile.lines * profile.axial_depth + kBelowLines;
  const Vector3 lower(0.0, 0.0, -depth);
  const Vector3 upper(profile.line_length, kThickness, 0.0);
  const Vector3 margin = Vector3::Constant(2.0 * kSpacing);
  const auto bone = [&](const Vector3& p) {
    const double line = std::floor(-p.z() / profile.axial_depth);
    const double x = std::clamp(p.x(), 0.01 * kSpacing, profile.line_length - 0.01 * kSpacing);
    const double gain =
        simulate::gain_at(profile, std::clamp(static_cast<int>(line), 0, profile.lines - 1), x);
    const Vector3 outside = (lower - p).cwiseMax(p - upper);
    return workpiece::BoneSample{outside.maxCoeff(), {gain * kPerNewtonMms, 1.0}};
  };
  return Stock(workpiece::cubes_over(lower - margin, upper + margin, kSpacing), bone);
}

void mill_slab(const std::vector<simulate::Step>& steps, const cutting::Cutter& cutter,
               Stock& slab) {
  workpiece::Remover remover(slab, cutter);
  for (std::size_t i = 1; i < steps.size(); ++i) {
    if (steps[i - 1].line == steps[i].line) remover.step(steps[i - 1].tip_W, steps[i].tip_W);
  }
}

}  // namespace osteomill::io
