// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "osteomill/cutting/shank.hpp"

namespace osteomill::cutting {

enum class CutterShape {
  cylindrical,
  ball,
  bull,     ///< a corner of corner_radius below the cylinder
  tapered,  ///< a ball of corner_radius, then a cone of taper_angle up to the full radius
  apt,      ///< the general cutter of APT: see AptShape
  profile,  ///< straight lines between the points of `profile`
};

/// How the edge winds where the radius changes.
enum class Lead {
  constant_lead,   ///< equal turn for equal height; helix_angle is that at the full radius
  constant_angle,  ///< helix_angle everywhere on straight parts; a rounded part keeps the lead that
                   ///< it has where it ends
};

/// A point of the profile: distance from the axis and height above the tip, m.
struct ProfileCorner {
  double radius = 0.0;
  double z = 0.0;
};

/// The seven-parameter cutter of APT, [engin2001]: a line from the tip, a round corner, a line to
/// the top. Its corner radius is that of the cutter, its height the cutting length; the cutter's
/// radius is that of its top.
struct AptShape {
  double diameter = 0.0;      ///< twice the distance of the axis from where the lines meet, m
  double corner_r = 0.0;      ///< of the corner's centre, from the axis, m
  double corner_z = 0.0;      ///< of the corner's centre, above the tip, m
  double bottom_angle = 0.0;  ///< of the lower line against the plane normal to the axis, rad
  double side_angle = 0.0;    ///< of the upper line against the axis, widening upwards, rad
};

/// Where the parts of an APT cutter join.
struct AptJoints {
  ProfileCorner lower;       ///< end of the lower line, where the corner begins
  ProfileCorner upper;       ///< end of the corner, where the upper line begins
  double lower_kappa = 0.0;  ///< of the corner's ends, rad
  double upper_kappa = 0.0;
  double top_radius = 0.0;  ///< m
};

/// How the cutter sits in the spindle: its axis beside the spindle's by `offset` at the tip, and
/// leaning by `tilt` so that the distance changes with height. Directions are angles by which they
/// lag behind flute 0 at the tip, like the other flutes: a flute that lags by as much is farthest
/// out.
struct RunOut {
  double offset = 0.0;        ///< m
  double offset_angle = 0.0;  ///< rad
  double tilt = 0.0;          ///< m a m of height
  double tilt_angle = 0.0;    ///< rad
};

/// A milling cutter: a surface of revolution about the tool axis with flutes on it. End edges on a
/// flat bottom are not modelled, as in all the sources.
///
/// Tool frame T: origin at the tip on the axis, z from the tip towards the spindle, x along the
/// feed (the projection of the feed on the plane normal to z), y = z × x. Rotation angles are
/// measured from +y towards +x, so an edge at angle theta and radius r is at (r sin theta, r cos
/// theta): clockwise seen from the spindle, a right-hand cutter turning as M3 does. With this the
/// uncut chip thickness of a horizontal feed is f_z sin kappa sin theta.
struct Cutter {
  CutterShape shape = CutterShape::cylindrical;
  double radius = 0.0;  ///< full radius, m
  int flutes = 2;
  double helix_angle = 0.0;                 ///< rad; > 0 right-hand
  double rake_angle = 0.0;                  ///< rad
  double cutting_length = 0.0;              ///< axial length with edges, from the tip, m
  double corner_radius = 0.0;               ///< bull, tapered and apt, m
  double taper_angle = 0.0;                 ///< tapered: half the angle of the cone, rad
  std::vector<ProfileCorner> profile = {};  ///< from the tip up; radius and z do not fall
  Lead lead = Lead::constant_lead;
  std::vector<double> pitch = {};         ///< from each flute to the next, rad; empty: equal
  std::vector<double> radius_error = {};  ///< of each flute, m; empty: none
  RunOut run_out = {};
  AptShape apt = {};
  std::optional<Shank> shank = {};  ///< how it is held; forces do not need it
};

/// Throws InvalidInput that names the field, when the values do not make a cutter.
void check(const Cutter& cutter);

/// Throws InvalidInput where the lines and the corner do not meet to a profile that rises outwards.
AptJoints apt_joints(const AptShape& apt, double corner_radius, double height);

/// Radius of the envelope at height z above the tip, m; z >= 0, above the cutting length the shank
/// is taken as full radius.
double radius_at(const Cutter& cutter, double z);

/// Axial position angle kappa at height z: angle between the tool axis and the outward normal of
/// the envelope, rad; pi/2 on a cylinder, 0 at the tip of a ball.
double axial_position_angle(const Cutter& cutter, double z);

/// How far an edge lags behind its tip at height z, rad. Constant lead: z tan(helix)/R, which on a
/// ball is (1 - cos kappa) tan(helix); [tian2023] eq. 4.
double lag_angle(const Cutter& cutter, double z);

}  // namespace osteomill::cutting
