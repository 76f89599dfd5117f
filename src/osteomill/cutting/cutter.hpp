// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace osteomill::cutting {

enum class CutterShape { cylindrical, ball };

/// A milling cutter: a surface of revolution about the tool axis with equally spaced flutes on it.
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
  double helix_angle = 0.0;     ///< constant lead; angle at the full radius, rad; > 0 right-hand
  double rake_angle = 0.0;      ///< rad
  double cutting_length = 0.0;  ///< axial length with edges, from the tip, m
};

/// Throws InvalidInput that names the field, when the values do not make a cutter.
void check(const Cutter& cutter);

/// Radius of the envelope at height z above the tip, m; z >= 0, above the cutting length the shank
/// is taken as full radius.
double radius_at(const Cutter& cutter, double z);

/// Axial position angle kappa at height z: angle between the tool axis and the outward normal of
/// the envelope, rad; pi/2 on a cylinder, 0 at the tip of a ball.
double axial_position_angle(const Cutter& cutter, double z);

/// How far an edge lags behind its tip at height z, rad. Cylinder: z tan(helix)/R. Ball with
/// constant lead: (1 - cos kappa) tan(helix) = z tan(helix)/R as well; [tian2023] eq. 4.
double lag_angle(const Cutter& cutter, double z);

/// What a point of the envelope needs for forces, by height.
struct ProfilePoint {
  double z = 0.0;            ///< height above the tip, m
  double radius = 0.0;       ///< m
  double kappa = 0.0;        ///< axial position angle, rad
  double lag = 0.0;          ///< of an edge, rad
  double inclination = 0.0;  ///< of an edge against the meridian, rad
  double stretch = 1.0;      ///< length of edge over length of meridian; [tian2023] eq. 3
};

/// Length of the meridian (the line of equal angle on the envelope) from the tip to height z, m.
double meridian_length(const Cutter& cutter, double z);

/// The point at a length along the meridian from the tip.
ProfilePoint profile_at(const Cutter& cutter, double meridian_length);

}  // namespace osteomill::cutting
