// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "osteomill/identify/experiment.hpp"

namespace osteomill::identify {

/// Where the tool axes are among the measured ones: x = sign × measured[axis], and so on.
struct AxisMapping {
  std::array<int, 3> axis{0, 1, 2};
  std::array<int, 3> sign{1, 1, 1};
};

/// {"x", "-y", "z"}, as the case file has it.
std::array<std::string, 3> names_of(const AxisMapping& mapping);

geometry::Vector3 mapped(const AxisMapping& mapping, const geometry::Vector3& force);

/// Whether another reading of the measured axes fits far better than the one given.
struct AxesCheck {
  double misfit_as_given = 0.0;  ///< rms residual of the plausible law over rms force
  double misfit_best = 0.0;
  /// The readings that fit best, within a tenth of each other: the one that is nearest to the given
  /// one first.
  std::vector<AxisMapping> best;
  bool suspicious = false;
};

/// Fits a law of constant pressures and edge forces with tangential and radial ones >= 0 (an edge
/// neither pulls itself forward nor into the bone) under all 48 permutations and signs of the
/// measured axes. The given one is suspicious when another leaves less than half its misfit, and
/// it misses by more than a fifth of the force: an unloaded or noisy component cannot raise it.
AxesCheck check_axes(const std::vector<Experiment>& experiments);

}  // namespace osteomill::identify
