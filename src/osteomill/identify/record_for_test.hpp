// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "osteomill/identify/force_record.hpp"

/// A record whose truth is known, for the tests of the signal steps.
namespace osteomill::identify {

struct RecordForTest {
  double rate = 8000.0;   // Hz
  double speed = 5000.0;  // rpm
  int flutes = 2;
  double idle = 0.5;                      // s, before and behind the cut
  double cut = 2.0;                       // s
  Eigen::Vector3d mean{8.0, -20.0, 5.0};  // N
  Eigen::Vector3d ripple{6.0, 9.0, 2.0};  // N, amplitude of the tooth passing
  double run_out = 0.0;  // amplitude at the revolution over that of the tooth passing
  double noise = 0.0;    // N
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // N
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();   // N/s
  double wander = 0.0;                               // of the speed, as a share, a sine of 1 Hz
  double start = 0.7;                                // rad, angle at the first sample
  bool tacho = false;
  unsigned seed = 1;

  double turn(double t) const {
    const double omega = 2.0 * std::numbers::pi * speed / 60.0;
    return start + omega * (t + wander / (2.0 * std::numbers::pi) *
                                    (1.0 - std::cos(2.0 * std::numbers::pi * t)));
  }
  Eigen::Vector3d at(double angle) const {
    const double tooth = flutes * angle;
    return mean +
           ripple.cwiseProduct(
               Eigen::Vector3d(std::cos(tooth), std::sin(tooth + 0.4), std::cos(2.0 * tooth))) +
           run_out * ripple * std::cos(angle - 0.2);
  }
  ForceRecord make() const {
    const auto n = static_cast<Eigen::Index>((cut + 2.0 * idle) * rate);
    ForceRecord out{.rate = rate, .force = Eigen::MatrixX3d::Zero(n, 3), .tacho = {}, .torque = {}};
    if (tacho) out.tacho.setZero(n);
    std::mt19937 engine(seed);
    std::normal_distribution<double> normal;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double t = static_cast<double>(i) / rate;
      Eigen::Vector3d f = offset + drift * t;
      if (t >= idle && t < idle + cut) f += at(turn(t));
      for (int axis = 0; axis < 3; ++axis) f[axis] += noise * normal(engine);
      out.force.row(i) = f.transpose();
      if (tacho) {
        // A flank of a tenth of a turn, so that its crossing lies between samples.
        const double turns = turn(t) / (2.0 * std::numbers::pi) + 0.05;
        const double share = turns - std::floor(turns);
        out.tacho[i] = 5.0 * (share < 0.1 ? share / 0.1 : (share < 0.3 ? 1.0 : 0.0));
      }
    }
    return out;
  }
};

}  // namespace osteomill::identify
