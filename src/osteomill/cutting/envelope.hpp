// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/cutter.hpp"

namespace osteomill::cutting {

/// What a point of the envelope needs for forces.
struct ProfilePoint {
  double z = 0.0;            ///< height above the tip, m
  double radius = 0.0;       ///< m
  double kappa = 0.0;        ///< axial position angle, rad
  double lag = 0.0;          ///< of an edge behind its tip, rad
  double inclination = 0.0;  ///< of an edge against the meridian, rad
  double stretch = 1.0;      ///< length of edge over length of meridian; [tian2023] eq. 3
};

/// The envelope of a cutter along its meridian (the line of equal angle on the envelope), which
/// runs from the tip, or from the rim of a flat bottom, through straight and round parts that join,
/// and on along the shank without end.
class Envelope {
 public:
  explicit Envelope(const Cutter& cutter);

  /// The point at a length along the meridian.
  ProfilePoint at(double length) const;
  /// Length of meridian up to a height.
  double length_to(double z) const;
  /// Whether the meridian at a length runs along the axis: the envelope is a cylinder there.
  bool is_cylinder(double length) const;
  /// Lengths where parts join.
  std::vector<double> joints() const;
  /// Lengths inside parts where the radius, or kappa on a round part, has a value; none where it
  /// does not change.
  std::vector<double> where_radius_is(double radius) const;
  std::vector<double> where_kappa_is(double kappa) const;

 private:
  struct Part {
    double begin = 0.0;   ///< length of meridian at its lower end
    double radius = 0.0;  ///< there
    double z = 0.0;
    double kappa = 0.0;
    double lag = 0.0;
    double curvature = 0.0;  ///< dkappa/ds; 0 on straight parts
    double lead = 0.0;       ///< dlag/dz; unused with constant angle on a straight part
    bool constant_angle = false;
  };
  const Part& part(double length) const;
  void add_line(double radius, double z);
  void add_arc(double corner_radius, double from_kappa, double to_kappa);
  void add_apt(const Cutter& cutter);
  void close(const Cutter& cutter);

  std::vector<Part> parts_;
  double tan_helix_ = 0.0;
};

}  // namespace osteomill::cutting
