// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace osteomill::identify {

/// Forces on the cutter over time at a constant rate. Rows are samples.
///
/// Axes are those of the tool frame T (see cutting::Cutter): x along the horizontal part of the
/// feed, z along the axis out of the bone. Readers turn a sensor's axes and signs into these and
/// take tare and gravity away, so that nothing below them asks how the sensor was mounted.
struct ForceRecord {
  double rate = 0.0;       ///< samples a second, Hz
  Eigen::MatrixX3d force;  ///< n × 3, N
  Eigen::VectorXd tacho =
      {};  ///< n, once-per-revolution signal in any unit; empty when not recorded
  Eigen::VectorXd torque = {};  ///< n, about the axis, N m; empty when not recorded
};

inline double duration(const ForceRecord& record) {
  return static_cast<double>(record.force.rows()) / record.rate;
}

}  // namespace osteomill::identify
