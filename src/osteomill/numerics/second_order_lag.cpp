// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/second_order_lag.hpp"

#include <string>
#include <unsupported/Eigen/MatrixFunctions>

#include "osteomill/base/error.hpp"

namespace osteomill::numerics {

void check(const SecondOrderLag& lag, const char* where) {
  const std::string name = where;
  require_positive((name + ".natural_frequency_rad_per_s").c_str(), lag.natural_frequency, "rad/s");
  require_positive((name + ".damping_ratio").c_str(), lag.damping_ratio, "");
}

HeldLag::HeldLag(const SecondOrderLag& lag, double time_step)
    : time_step_(require_positive("time_step", time_step, "s")) {
  check(lag, "servo");
  const double w = lag.natural_frequency;
  Eigen::Matrix4d system = Eigen::Matrix4d::Zero();  // (integral, value, rate, held input)
  system(0, 1) = 1.0;
  system(1, 2) = 1.0;
  system.row(2) << 0.0, -w * w, -2.0 * lag.damping_ratio * w, w * w;
  const Eigen::Matrix4d held = (system * time_step).exp();
  transition_ = held.topLeftCorner<3, 3>();
  input_ = held.topRightCorner<3, 1>();
}

}  // namespace osteomill::numerics
