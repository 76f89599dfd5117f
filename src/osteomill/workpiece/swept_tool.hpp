// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/geometry/pose.hpp"
#include "osteomill/workpiece/meridian.hpp"

namespace osteomill::workpiece {

/// The least distance to the cutter (Meridian) over the positions of the tip on the segment from
/// `from` to `to` (frame W, tool axis = +z of W): the signed distance to the swept volume outside
/// and, where the cutter's surface is smooth, inside near the surface. A path in pieces gives the
/// same as the whole path when the least of the pieces is taken, which is why this form is used: on
/// the floor of a ramp at angle a a cylinder's corner leaves it short by up to 1 - 1/(sin a + cos
/// a), on the inner side only.
///
/// Closed form for level and vertical moves and for the ball (a capsule, which sweeps a strip of
/// the vertical plane through the feed); otherwise a minimisation of a convex function.
class SweptTool {
 public:
  /// The meridian must outlive it.
  SweptTool(const Meridian& cutter, const geometry::Vector3& from, const geometry::Vector3& to);
  double distance(const geometry::Vector3& p) const;

 private:
  double ball_distance(double along, double lateral, double height) const;

  const Meridian* cutter_;
  geometry::Vector3 from_;
  double run_ = 0.0;                      ///< horizontal length
  double rise_ = 0.0;                     ///< vertical length, signed
  double along_x_ = 1.0, along_y_ = 0.0;  ///< horizontal direction
};

}  // namespace osteomill::workpiece
