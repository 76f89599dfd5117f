// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/geometry/pose.hpp"

namespace osteomill::cli {

/// A row of a table of means in reproduce/; numbers as printed: mm, mm/min, N.
struct MeanRow {
  std::string tool, kind;
  double depth = 0.0, feed_rate = 0.0, feed_per_tooth = 0.0;
  geometry::Vector3 force = geometry::Vector3::Zero();
};
std::vector<MeanRow> read_mean_rows(const std::string& name);

/// Root mean square of each component.
geometry::Vector3 rms(const std::vector<geometry::Vector3>& values);

/// "1.00 / 2.00 / 3.00"
std::string three(const geometry::Vector3& v, int digits = 2);

}  // namespace osteomill::cli
