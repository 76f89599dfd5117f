// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/geometry/pose.hpp"

namespace osteomill::workpiece {

/// Signed distance to a cutter whose tip is at the origin, tool axis z, from a point at distance r
/// from the axis and at height z above the tip; < 0 inside. The shank goes on upwards at full
/// radius without end. Inside the corner of a cylinder it is minus the smaller of the distances to
/// the wall and to the end face.
double tool_distance(const cutting::Cutter& cutter, double r, double z);

/// The least tool_distance over the positions of the tip on the segment from `from` to `to`
/// (frame W, tool axis = +z of W): the signed distance to the swept volume outside and, where the
/// cutter's surface is smooth, inside near the surface. A path in pieces gives the same as the
/// whole path when the least of the pieces is taken, which is why this form is used: on the floor
/// of a ramp at angle a a cylinder's corner leaves it short by up to 1 - 1/(sin a + cos a), on the
/// inner side only.
///
/// Closed form for the ball (a capsule sweeps a strip of the vertical plane through the feed) and
/// for horizontal and vertical moves; otherwise a convex minimisation by bisection of the slope.
class SweptTool {
 public:
  SweptTool(const cutting::Cutter& cutter, const geometry::Vector3& from,
            const geometry::Vector3& to);
  double distance(const geometry::Vector3& p) const;

 private:
  double ball_distance(double along, double lateral, double height) const;
  double cylinder_distance(double along, double lateral, double height) const;

  cutting::Cutter cutter_;
  geometry::Vector3 from_;
  double run_ = 0.0;                      ///< horizontal length
  double rise_ = 0.0;                     ///< vertical length, signed
  double along_x_ = 1.0, along_y_ = 0.0;  ///< horizontal direction
};

}  // namespace osteomill::workpiece
