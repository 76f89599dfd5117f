// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/cutting/cutter.hpp"
#include "osteomill/geometry/pose.hpp"

namespace osteomill::cutting {

/// What an edge is taken to move along when the chip is worked out.
enum class ToothPath {
  circular,    ///< Martellotti's approximation for feeds much smaller than the radius
  trochoidal,  ///< exact; horizontal feeds and equal flutes
};

/// How the cutter moves. The tool frame T has x along the horizontal part of the feed (see Cutter).
struct Condition {
  double spindle_speed = 0.0;   ///< rad/s
  double feed_per_tooth = 0.0;  ///< m, along the feed direction
  double feed_elevation =
      0.0;  ///< of the feed above the plane normal to the axis, rad; < 0 plunges
  geometry::Vector3 fibre_T = geometry::Vector3::UnitX();  ///< unit vector along the bone's fibres
  ToothPath path = ToothPath::circular;
  /// Turn of the tool for a unit of the feed's way, in T, rad/m, and the height above the tip, m,
  /// of the place c on the axis that the feed is of: a point at p moves by feed + turn × (p - c).
  /// Where the stock says what is cut (EngagedForce) only.
  geometry::Vector3 turn_T = geometry::Vector3::Zero();
  double turn_height = 0.0;
};

/// Fibres in the plane normal to the tool axis, at an angle from the feed towards +y, rad.
geometry::Vector3 fibre_at_angle(double fibre_angle);

/// Unit vector along the feed in T.
geometry::Vector3 feed_direction(const Condition& condition);

/// Feed per tooth of a feed rate, m: c = v 2 pi/(omega N), [plaskos2006] eq. 3.4 in SI.
double feed_per_tooth(double feed_rate, double spindle_speed, int flutes);

/// The feed rate of a condition, m/s.
double feed_rate(const Condition& condition, int flutes);

/// Throws InvalidInput for what cannot be milled, among it slips of unit: 3 mm a tooth, 5000 rad/s.
void check(const Condition& condition, const Cutter& cutter);

/// A nominal cut: bone in a slab along the feed, from the tip up to the axial depth.
enum class ImmersionKind {
  slot,  ///< bone on both sides
  up,    ///< finished wall at +y: the chip grows from nothing
  down,  ///< finished wall at -y: the chip shrinks to nothing
};

struct Immersion {
  ImmersionKind kind = ImmersionKind::slot;
  double radial_depth = 0.0;  ///< m, up and down only; measured at the full radius
  double axial_depth = 0.0;   ///< m
};

void check(const Immersion& immersion, const Cutter& cutter);

/// The bone of an immersion lies between these distances from the axis along y, m.
struct LateralBand {
  double low = 0.0;
  double high = 0.0;
};
LateralBand band(const Immersion& immersion, const Cutter& cutter);

}  // namespace osteomill::cutting
