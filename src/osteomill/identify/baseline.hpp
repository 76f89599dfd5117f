// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "osteomill/identify/force_record.hpp"
#include "osteomill/identify/segments.hpp"

namespace osteomill::identify {

enum class BaselineKind {
  none,
  tare,   ///< mean of the idle parts
  drift,  ///< straight line between the idle parts, level before the first and behind the last
};

/// What a sensor shows without a cut.
struct Baseline {
  Eigen::MatrixX3d offset;                          ///< 1 × 3 or n × 3, N: taken from every sample
  Eigen::Vector3d first = Eigen::Vector3d::Zero();  ///< N, mean of the first idle part
  Eigen::Vector3d last = Eigen::Vector3d::Zero();   ///< N, mean of the last idle part
};

/// Takes the baseline away; returns it. Throws InvalidInput when the record has no idle part, or,
/// for a drift, none on either side of the cut.
Baseline remove_baseline(ForceRecord& record, const std::vector<Segment>& idle, BaselineKind kind);

/// Weight of what hangs on the sensor, N: mass × 9.80665 m/s² × direction.
/// @param down  unit vectors down in the axes of the force, 1 × 3 or one a sample
void remove_gravity(Eigen::MatrixX3d& force, double mass, const Eigen::MatrixX3d& down);

/// `down` turned about an axis of the sensor by an angle a sample: for a sensor that turns. A
/// sensor that turns by +angle about its axis sees the vertical turn by −angle.
Eigen::MatrixX3d turned_down(const Eigen::Vector3d& down, const Eigen::Vector3d& axis,
                             const Eigen::VectorXd& angle);

}  // namespace osteomill::identify
