// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace osteomill::numerics {

/// A second-order lag of unit static gain, G(s) = w_n² / (s² + 2 eta w_n s + w_n²).
struct SecondOrderLag {
  double natural_frequency = 0.0;  ///< w_n, rad/s
  double damping_ratio = 0.0;      ///< eta
};

/// Throws InvalidInput that names the field under `where`, unless w_n > 0 and eta > 0.
void check(const SecondOrderLag& lag, const char* where);

/// Output, its integral and its derivative: position, velocity and acceleration of a feed servo.
struct LagState {
  double integral = 0.0;
  double value = 0.0;
  double rate = 0.0;
};

/// The lag over one time step with its input held: exact for every damping ratio and step length.
class HeldLag {
 public:
  HeldLag(const SecondOrderLag& lag, double time_step);

  LagState advance(const LagState& state, double input) const noexcept {
    const Eigen::Vector3d next =
        transition_ * Eigen::Vector3d(state.integral, state.value, state.rate) + input_ * input;
    return {next[0], next[1], next[2]};
  }
  double time_step() const { return time_step_; }
  const Eigen::Matrix3d& transition() const { return transition_; }
  const Eigen::Vector3d& input() const { return input_; }

 private:
  double time_step_ = 0.0;
  Eigen::Matrix3d transition_;  ///< on (integral, value, rate)
  Eigen::Vector3d input_;
};

}  // namespace osteomill::numerics
