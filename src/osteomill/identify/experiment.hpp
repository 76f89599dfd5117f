// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/geometry/pose.hpp"

namespace osteomill::identify {

/// One cut of known condition with the forces that were measured on it.
struct Experiment {
  std::string name;   ///< as the table calls it
  std::string group;  ///< specimens, days or cutters that are left out together; may be empty
  cutting::Cutter cutter;
  cutting::Condition condition;
  cutting::Immersion immersion;
  geometry::Vector3 mean_force = geometry::Vector3::Zero();  ///< in T, N
  /// Standard error of each mean, N; zero where it is not known.
  geometry::Vector3 standard_error = geometry::Vector3::Zero();
};

}  // namespace osteomill::identify
