// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "osteomill/geometry/pose.hpp"

namespace osteomill::simulate {

/// How the tool moved during one control period, at the sensor's sampling times.
struct Motion {
  double from = 0.0;                  ///< position along the path at the start of the period, m
  std::span<const double> positions;  ///< m
  std::span<const double> feeds;      ///< m/s
  std::span<const double> angles;     ///< of the spindle, rad
  double sample_time = 0.0;           ///< s
  double spindle_speed = 0.0;         ///< rad/s
};

/// What the tool met there. The vectors have one element a sample.
struct Cut {
  std::vector<geometry::Vector3> forces_W;  ///< on the tool, N
  std::vector<double> torques;              ///< that the spindle has to give, N m
  std::vector<char> contacts;               ///< 1 where the cutter touches bone, else 0
  geometry::Vector3 direction_W = geometry::Vector3::UnitX();  ///< of the feed, unit
  double removed_volume = 0.0;                                 ///< over the period, m³
  double contact_length = 0.0;  ///< of the edges in bone, mean over a revolution, m; 0: not known
  double material = 0.0;        ///< mean over what is in contact; 0 in air
};

/// A place on the path.
struct Place {
  int line = 0;                                               ///< from 0
  geometry::Vector3 tip_W = geometry::Vector3::Zero();        ///< m
  geometry::Vector3 direction_W = geometry::Vector3::Zero();  ///< of the feed, unit
  geometry::Vector3 axis_W = geometry::Vector3::UnitZ();      ///< of the tool, unit
  double programmed_feed = 0.0;                               ///< m/s
  bool rapid = false;                                         ///< positioning, not a cut
};

/// A bone with the path that is to be milled into it: what a position along the path means.
class Workpiece {
 public:
  virtual ~Workpiece() = default;
  virtual double length() const = 0;  ///< of the path, m
  virtual int lines() const = 0;
  virtual Place at(double position) const = 0;
  /// To the nearest entry into bone along the path, as control::Observation has it: positive before
  /// the entry, negative past it, infinite when none is known.
  virtual double to_contact(double position) const = 0;
  /// The same to where the cutter is fully engaged at that entry.
  virtual double to_engagement(double position) const = 0;
  /// Where the next control period starts when the tool came from `from` to `to` in this one.
  virtual double next_start(double /*from*/, double to) const { return to; }
  /// Moves the tool, removes what it meets, and fills `cut` (its vectors are sized already).
  virtual void mill(const Motion& motion, Cut& cut) = 0;
  /// Of the hottest bone now that the path will not cut away, K; 0 where temperatures are not
  /// worked out.
  virtual double temperature() const { return 0.0; }
  /// From the tool, where it came to, to the nearest no-go region, m: no more than it really is.
  virtual double no_go_distance() const { return std::numeric_limits<double>::infinity(); }
  /// What Cut::material is, as a key with its unit; and the factor from the key's unit to SI.
  virtual const char* material_key() const = 0;
  virtual double material_unit() const = 0;
};

}  // namespace osteomill::simulate
