// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "osteomill/cutting/cutter.hpp"

namespace osteomill::workpiece {

/// The cutter with all its lengths multiplied, for work in voxels.
cutting::Cutter scaled(cutting::Cutter cutter, double factor);

/// The outline of a cutter in the half-plane of distance from the axis r and height above the tip
/// z, as a convex body that goes on upwards at full radius without end.
class Meridian {
 public:
  /// Throws InvalidInput when the outline isn't convex: every point of the cutter's front must be
  /// seen along the feed (see ShadowMap). Lengths are multiplied by `factor`.
  explicit Meridian(const cutting::Cutter& cutter, double factor = 1.0);

  /// Signed distance to the cutter, < 0 inside; there it is minus the distance to the nearest part
  /// of the outline. Rises with r, falls with z.
  double distance(double r, double z) const {
    if (kind_ == Kind::general) return general_distance(r, z);
    if (kind_ == Kind::ball) {
      const double below = std::min(0.0, z - radius_);
      return std::sqrt(r * r + below * below) - radius_;
    }
    const double wall = r - radius_;
    if (wall > 0.0 && z < 0.0) return std::sqrt(wall * wall + z * z);
    return std::max(wall, -z);
  }

  /// Largest r at this height with at most this distance; < 0 when there is none.
  double section_radius(double z, double offset) const;

  bool is_ball() const { return kind_ == Kind::ball; }
  bool is_cylinder() const { return kind_ == Kind::cylinder; }
  double radius() const { return radius_; }
  double cutting_length() const { return cutting_length_; }
  /// From this height on the wall is the nearest part for all points within `band` of it.
  double upright_from(double band) const;

 private:
  enum class Kind { cylinder, ball, general };
  struct Corner {
    double r = 0.0, z = 0.0;
  };
  struct Line {
    Corner from, to;
    double normal_r = 0.0, normal_z = 0.0;  ///< outwards, unit
  };
  struct Arc {
    Corner centre;
    double radius = 0.0;
    double last_cosine = 0.0;   ///< of kappa where it ends
    double first_cosine = 1.0;  ///< where it begins
  };
  void add_line(const Corner& from, const Corner& to);
  double general_distance(double r, double z) const;

  Kind kind_ = Kind::cylinder;
  double radius_ = 0.0;
  double cutting_length_ = 0.0;
  double top_ = 0.0;  ///< where the full radius begins
  std::vector<Line> lines_;
  std::vector<Arc> arcs_;
};

}  // namespace osteomill::workpiece
