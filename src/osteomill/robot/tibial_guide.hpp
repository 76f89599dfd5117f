// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "osteomill/base/units.hpp"
#include "osteomill/geometry/pose.hpp"

namespace osteomill::robot {

/// The adjustable tibial guide: a slide along the bone (P/D), two turning axes (F/E, then V/V) and
/// a slide of the guide (A/P) that does not move its plane. [plaskos2006] 5.5.2.
///
/// Frame B of its base (pinned to the tibia, seen by the tracker), frame A of the anatomy: x medial
/// to lateral, y anterior, z proximal along the mechanical axis. Plane of the guide at zero:
/// normal_B through centre_B, where the two turning axes meet.
struct TibialGuide {
  geometry::Vector3 slide_B = geometry::Vector3::UnitZ();
  geometry::Vector3 flexion_axis_B = geometry::Vector3::UnitX();
  geometry::Vector3 varus_axis_B = geometry::Vector3::UnitY();  ///< as it stands at zero flexion
  geometry::Vector3 normal_B = geometry::Vector3::UnitZ();
  geometry::Vector3 centre_B = geometry::Vector3::Zero();
  double height = 0.0;                     ///< of the plane above the centre, along the normal, m
  double slide_range = 0.020;              ///< total, m; "~20 mm"
  double angle_range = 35.0 * units::deg;  ///< total, rad; "35°"
};

struct TibialJoints {
  double slide = 0.0;    ///< P/D, m
  double flexion = 0.0;  ///< F/E, rad
  double varus = 0.0;    ///< V/V, rad
};

/// What the navigation screen shows: the guide's plane in the anatomy.
struct TibialDisplay {
  double varus = 0.0;  ///< slope of the plane towards lateral, rad
  double slope =
      0.0;  ///< slope towards anterior, posterior slope positive: anterior edge is higher
  double depth = 0.0;  ///< height of the plane over the anatomy's origin, at the origin, m
};
TibialDisplay display(const TibialGuide& guide, const geometry::Pose& X_AB,
                      const TibialJoints& joints);

struct TibialSetting {
  bool reachable = false;
  std::string reason;
  TibialJoints joints;
};
/// Joint values that show the target, in closed form: two turns that carry one direction onto
/// another (Paden and Kahan's second sub-problem), then the slide. No iteration, no coupling.
TibialSetting solve(const TibialGuide& guide, const geometry::Pose& X_AB,
                    const TibialDisplay& target);

/// Adjusting as it was done: turn one axis until its own angle on the screen is right, lock, turn
/// the other, and again; the screen shows what each step did.
struct AdjustmentStep {
  TibialJoints joints;
  TibialDisplay shown;
};
std::vector<AdjustmentStep> adjust_by_screen(const TibialGuide& guide, const geometry::Pose& X_AB,
                                             const TibialJoints& start, const TibialDisplay& target,
                                             double tolerance, int most_steps = 50);

}  // namespace osteomill::robot
