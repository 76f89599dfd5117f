// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/accuracy/tool_deflection.hpp"

namespace osteomill::accuracy {

/// A point of the cut surface, m: x anterior, y medio-lateral, height out of the bone over the
/// planned plane.
struct SurfacePoint {
  double x = 0.0, y = 0.0, height = 0.0;
};

/// The plane height = offset + slope_x x + slope_y y on which a plate comes to lie.
struct PlatePose {
  double offset = 0.0;
  double slope_x = 0.0, slope_y = 0.0;
  /// Rotations of the plate about the fixed axes x and y, rad: varus/valgus about x (frontal
  /// plane), flexion/extension about y (sagittal plane), as [plaskos2002] Figure 2.1 defines them.
  double varus_valgus = 0.0, flexion_extension = 0.0;
  double largest_gap = 0.0;  ///< between plate and bone, m
  double share_tight = 0.0;  ///< of the points with a gap below 0.3 mm
  double share_wide = 0.0;   ///< below 0.5 mm
};

/// A rigid plate that is pressed on the surface at the middle of the points: it touches at three
/// points around the middle and lies above all others, as the dummy implants of [plaskos2002] §2.2.
PlatePose resting_plate(const std::vector<SurfacePoint>& points);

/// The least-squares plane instead: a plate bedded in cement.
PlatePose fitted_plate(const std::vector<SurfacePoint>& points);

/// One pass of the mill over the cut.
struct Pass {
  double y_from = 0.0, y_to = 0.0;  ///< m; the feed goes from one to the other
  SurfaceError error;               ///< along the tool axis, from the tip
  double tip_x = 0.0;               ///< where the tip is, m; the tool comes from anterior (+x)
};

/// Heights of the surface that the passes leave, on `points_along` points of each.
std::vector<SurfacePoint> milled_surface(const std::vector<Pass>& passes, int points_along = 9);

}  // namespace osteomill::accuracy
