// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/cutting/condition.hpp"
#include "osteomill/cutting/cutter.hpp"
#include "osteomill/cutting/cutting_law.hpp"
#include "osteomill/cutting/envelope.hpp"
#include "osteomill/geometry/pose.hpp"

namespace osteomill::cutting {

/// What the bone does to the cutter, in the tool frame T; the moment is about the tip.
struct Load {
  geometry::Vector3 force = geometry::Vector3::Zero();   ///< N
  geometry::Vector3 moment = geometry::Vector3::Zero();  ///< N m

  /// Torque that the spindle must give, N m: the cutter turns about -z.
  double torque() const { return moment.z(); }
  /// Moment that bends the cutter at a height above the tip, N m.
  double bending_moment(double height) const;
  Load& operator+=(const Load& other);
};

/// Power that the spindle gives at a load, W.
inline double spindle_power(const Load& load, double spindle_speed) {
  return load.torque() * spindle_speed;
}

/// One revolution: load at equal steps of the rotation angle of the first flute's tip.
struct Revolution {
  std::vector<double> angle;  ///< rad
  std::vector<Load> loads;
};

/// Unit vector along the motion of an edge at rotation angle theta.
geometry::Vector3 motion(double theta);

/// Outward normal of the envelope.
geometry::Vector3 outward_normal(double theta, double kappa);

/// Uncut chip thickness on a circular tooth path, m: h = f_z max(0, n · f), n the outward normal of
/// the envelope and f the feed direction. For a horizontal feed it is f_z sin kappa sin theta:
/// [plaskos2006] eq. 3.3, [tian2023] eq. 9.
double chip_thickness(const Condition& condition, double theta, double kappa);

/// Force on the tool per width of cut, N/m, of an edge at rotation angle theta:
///   -F_t t - F_r n - F_l e,  t = (cos theta, -sin theta, 0) the motion,
///   n = (sin kappa sin theta, sin kappa cos theta, -cos kappa) the outward normal,
///   e = (cos kappa sin theta, cos kappa cos theta, sin kappa) along the meridian.
/// [plaskos2006] eq. 3.5 for kappa = pi/2; [tian2023] eq. 14, whose printed -LQ must be +LQ.
geometry::Vector3 edge_force(const CuttingLaw& law, const Condition& condition, double theta,
                             const ProfilePoint& point);

/// The same with chip thickness, motion and normal worked out.
geometry::Vector3 edge_force(const CuttingLaw& law, double h, const geometry::Vector3& fibre,
                             const geometry::Vector3& t, const geometry::Vector3& n,
                             const ProfilePoint& point);

/// How well a mean is wanted.
struct MeanOptions {
  /// Largest error of the mean force, relative to its magnitude. Adaptive: each smooth piece of the
  /// envelope gets more nodes until that changes it by less than its share. The errors are smaller
  /// than the changes that stop it (tested). With run-out, where along the edge it lifts off is a
  /// kink that limits the error to about 1e-3.
  double tolerance = 1e-5;
};

/// Mean over a revolution in a nominal cut, by Gauss quadrature between exact entry and exit (edge
/// laws have an infinite slope at h = 0, so the nodes are gathered there).
Load mean_load(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
               const Immersion& immersion, const MeanOptions& options = {});

/// The same for each flute; they differ with pitch, radius errors and run-out.
std::vector<Load> flute_means(const Cutter& cutter, const CuttingLaw& law,
                              const Condition& condition, const Immersion& immersion,
                              const MeanOptions& options = {});

/// Instantaneous loads over a revolution in a nominal cut; every flute is integrated along its edge
/// between the exact ends of its contact.
Revolution revolution(const Cutter& cutter, const CuttingLaw& law, const Condition& condition,
                      const Immersion& immersion, int steps = 360);

/// Volume that a nominal cut removes in unit time, m³/s; BVR = f d DOC, [plaskos2002] 4.
double removal_rate(const Cutter& cutter, const Condition& condition, const Immersion& immersion);

/// Largest uncut chip thickness in a nominal cut, m.
double largest_chip(const Cutter& cutter, const Condition& condition, const Immersion& immersion);

}  // namespace osteomill::cutting
