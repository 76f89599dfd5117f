// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "osteomill/geometry/pose.hpp"

namespace osteomill::geometry {

/// A triangle mesh; corners counter-clockwise seen from outside.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;           ///< m
  std::vector<std::array<unsigned, 3>> triangles;  ///< indices into vertices
  std::vector<float> values;                       ///< one a vertex, or empty
};

}  // namespace osteomill::geometry
