// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "osteomill/geometry/pose.hpp"
#include "osteomill/workpiece/stock.hpp"

namespace osteomill::workpiece {

/// A bone before it is on a grid: what it is made of at each point of its own frame P, and the box
/// that it lies in there.
struct Anatomy {
  std::function<BoneSample(const Vector3& p_P)> bone;
  Vector3 lower_P = Vector3::Zero();
  Vector3 upper_P = Vector3::Zero();
};

/// Corners of a box.
struct Extent {
  Vector3 lower = Vector3::Zero();
  Vector3 upper = Vector3::Zero();
};

/// The smallest box with the axes of W around the bone. X_PW: pose of W in P.
Extent extent_in(const Anatomy& anatomy, const geometry::Pose& X_PW);

/// The part of the bone in a box of W, on cubes: a bone that is to be cut askew is turned here,
/// so that the tool stays along z of W.
Stock stock_of(const Anatomy& anatomy, const geometry::Pose& X_PW, const Extent& box_W,
               double spacing);

}  // namespace osteomill::workpiece
