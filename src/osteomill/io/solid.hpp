// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "osteomill/geometry/mesh.hpp"
#include "osteomill/geometry/pose.hpp"

namespace osteomill::io {

struct SolidOptions {
  double spacing = 0.5e-3;  ///< of the grid, m
  double inside = 3e-3;     ///< distances are known to this depth, m
  double outside = 3e-3;    ///< and to this height, m
};

/// Signed distance to a closed surface, < 0 inside, from a sparse grid on which it is exact
/// (OpenVDB), linear between. Beyond the depth and the height that were asked for it stays at
/// their values. Copies share the grid; distance() is safe from several threads.
class Solid {
 public:
  /// InvalidInput when the surface does not enclose anything.
  Solid(const geometry::Mesh& mesh, const SolidOptions& options);
  double distance(const geometry::Vector3& p) const;
  /// Corners of the box that the surface lies in.
  const geometry::Vector3& lower() const { return lower_; }
  const geometry::Vector3& upper() const { return upper_; }

 private:
  struct Grid;
  std::shared_ptr<const Grid> grid_;
  geometry::Vector3 lower_, upper_;
};

}  // namespace osteomill::io
