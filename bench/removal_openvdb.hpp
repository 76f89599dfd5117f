// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "osteomill/geometry/pose.hpp"

/// The same cuts with OpenVDB: the baseline of the removal benchmark. A level set three voxels
/// wide; no engagement is worked out.
namespace osteomill::bench {

struct VdbTool {
  bool ball = true;
  double radius = 0.0;  ///< m
};

class VdbStock {
 public:
  /// A block from lower to upper, m.
  VdbStock(const geometry::Vector3& lower, const geometry::Vector3& upper, double spacing);
  ~VdbStock();
  VdbStock(const VdbStock&) = delete;
  VdbStock& operator=(const VdbStock&) = delete;

  /// A level step, leaf by leaf in their buffers: leaves that the tool misses or has taken before
  /// are passed over, those deep inside it become tiles.
  void cut_leaves(const VdbTool& tool, const geometry::Vector3& from, const geometry::Vector3& to);
  /// The ball put down at a place by csgDifference; without its shank.
  void cut_csg(const VdbTool& tool, const geometry::Vector3& tip);
  double volume() const;  ///< m³

 private:
  struct Grid;
  std::unique_ptr<Grid> grid_;
};

}  // namespace osteomill::bench
