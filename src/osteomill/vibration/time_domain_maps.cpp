// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/time_domain_maps.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/vibration/exponential.hpp"

namespace osteomill::vibration {
namespace {

constexpr int kAny = Eigen::Dynamic;

void check_condition(double spindle_speed, double depth, int steps) {
  require_positive("cut.spindle_speed_rpm", spindle_speed / units::rpm, "rpm");
  require_non_negative("cut.axial_depth_mm", depth / units::mm, "mm");
  require_within("options.steps", steps, 2.0, 100000.0, "");
}

/// S states and O outputs, known to the compiler for the usual cases.
template <int S, int O>
struct Builder {
  using States = Eigen::Matrix<double, S, S>;
  using Input = Eigen::Matrix<double, S, O>;
  using Output = Eigen::Matrix<double, O, S>;
  using Stiffness = Eigen::Matrix<double, O, O>;

  const RegenerativeSystem& system;
  double spindle_speed;
  double depth;
  int steps;

  Stiffness stiffness(int step) const {
    const double width = system.cut().pitch() / steps;
    return system.basis().transpose() * system.cut().mean(step * width, (step + 1) * width, depth) *
           system.basis();
  }

  DelayMap empty() const {
    DelayMap map;
    map.states = system.states();
    map.outputs = system.outputs();
    map.steps = steps;
    map.output = Eigen::MatrixXd::Zero(map.outputs, map.states);
    map.output.leftCols(map.states / 2) = system.shapes();
    map.matrices.resize(map.stride() * static_cast<std::size_t>(steps));
    return map;
  }

  void store(DelayMap& map, int step, const States& p, const Input& g, const Input& h) const {
    double* at = map.matrices.data() + map.stride() * static_cast<std::size_t>(step);
    const Eigen::Index s = map.states, o = map.outputs;
    Eigen::Map<States>(at, s, s) = p;
    Eigen::Map<Input>(at + s * s, s, o) = g;
    Eigen::Map<Input>(at + s * (s + o), s, o) = h;
  }

  DelayMap semi() const {
    DelayMap map = empty();
    const double dt = system.tooth_period(spindle_speed) / steps;
    const States a0 = system.free_motion() * dt;
    const Input b = system.input() * dt;
    const Output c = map.output;
    for (int i = 0; i < steps; ++i) {
      const Input bw = b * stiffness(i);
      States z = a0;
      z.noalias() += bw * c;
      const ExponentialFunctions<States> f = exponential_functions(z);
      const Input new_share = -(f.phi_2 * bw);
      Input old_share = -(f.phi_1 * bw);
      old_share -= new_share;
      store(map, i, f.phi_0, old_share, new_share);
    }
    return map;
  }

  DelayMap full() const {
    DelayMap map = empty();
    const double dt = system.tooth_period(spindle_speed) / steps;
    const Output c = map.output;
    const States z = system.free_motion() * dt;
    const ExponentialFunctions<States> f = exponential_functions(z);
    const Input b = system.input() * dt;
    const Input late = f.phi_2 * b, early = f.phi_1 * b - late;
    const States one = States::Identity(map.states, map.states);
    for (int i = 0; i < steps; ++i) {
      const Stiffness w = stiffness(i);
      const Input late_w = late * w, early_w = early * w;
      const States left = one - late_w * c;
      const States solve = left.inverse();
      const States p = solve * (f.phi_0 + early_w * c);
      store(map, i, p, -(solve * early_w), -(solve * late_w));
    }
    return map;
  }
};

template <class Make>
DelayMap dispatch(const RegenerativeSystem& system, double speed, double depth, int steps,
                  Make make) {
  check_condition(speed, depth, steps);
  const int s = system.states(), o = system.outputs();
  if (s == 2 && o == 1) return make(Builder<2, 1>{system, speed, depth, steps});
  if (s == 4 && o == 1) return make(Builder<4, 1>{system, speed, depth, steps});
  if (s == 4 && o == 2) return make(Builder<4, 2>{system, speed, depth, steps});
  return make(Builder<kAny, kAny>{system, speed, depth, steps});
}

}  // namespace

int default_steps(const RegenerativeSystem& system, double spindle_speed) {
  const double oscillations = system.highest_frequency_hz() * system.tooth_period(spindle_speed);
  return std::clamp(static_cast<int>(std::ceil(40.0 * oscillations)), 40, 4000);
}

DelayMap semi_discretisation(const RegenerativeSystem& system, double spindle_speed, double depth,
                             int steps) {
  return dispatch(system, spindle_speed, depth, steps, [](const auto& b) { return b.semi(); });
}

DelayMap full_discretisation(const RegenerativeSystem& system, double spindle_speed, double depth,
                             int steps) {
  return dispatch(system, spindle_speed, depth, steps, [](const auto& b) { return b.full(); });
}

Multiplier collocation_multiplier(const RegenerativeSystem& system, double spindle_speed,
                                  double depth, int elements) {
  check_condition(spindle_speed, depth, elements);
  // Gauss–Legendre collocation of three stages: order six.
  const double r = std::sqrt(15.0);
  const std::array<double, 3> nodes = {0.5 - r / 10.0, 0.5, 0.5 + r / 10.0};
  Eigen::Matrix3d weights;
  weights << 5.0 / 36.0, 2.0 / 9.0 - r / 15.0, 5.0 / 36.0 - r / 30.0,  //
      5.0 / 36.0 + r / 24.0, 2.0 / 9.0, 5.0 / 36.0 - r / 24.0,         //
      5.0 / 36.0 + r / 30.0, 2.0 / 9.0 + r / 15.0, 5.0 / 36.0;
  const Eigen::RowVector3d end(5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0);

  const double pitch = system.cut().pitch();
  std::vector<double> marks = system.cut().breaks(depth);
  if (marks.empty() || marks.front() > 0.0) marks.insert(marks.begin(), 0.0);
  marks.push_back(pitch);
  std::vector<double> mesh{0.0};
  for (std::size_t i = 0; i + 1 < marks.size(); ++i) {
    const double gap = marks[i + 1] - marks[i];
    const int parts = std::max(1, static_cast<int>(std::lround(elements * gap / pitch)));
    for (int k = 1; k <= parts; ++k) mesh.push_back(marks[i] + gap * k / parts);
  }

  const Eigen::Index s = system.states(), o = system.outputs();
  const Eigen::Index count = static_cast<Eigen::Index>(mesh.size()) - 1;
  const Eigen::Index n = s + 3 * count * o;
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(o, s);
  c.leftCols(s / 2) = system.shapes();
  Eigen::MatrixXd state = Eigen::MatrixXd::Identity(s, n);  // y as a function of the unknowns
  Eigen::MatrixXd map(n, n);
  for (Eigen::Index e = 0; e < count; ++e) {
    const double low = mesh[static_cast<std::size_t>(e)];
    const double width = mesh[static_cast<std::size_t>(e) + 1] - low;
    const double dt = width / spindle_speed;
    Eigen::MatrixXd left = Eigen::MatrixXd::Identity(3 * s, 3 * s);
    Eigen::MatrixXd right(3 * s, n), slopes_y(s, 3 * s);
    Eigen::MatrixXd delayed = Eigen::MatrixXd::Zero(3 * s, n);
    for (int j = 0; j < 3; ++j) {
      const Eigen::MatrixXd bw =
          system.input() * system.basis().transpose() *
          system.cut().at(low + nodes[static_cast<std::size_t>(j)] * width, depth) * system.basis();
      const Eigen::MatrixXd a = system.free_motion() + bw * c;
      slopes_y.middleCols(j * s, s) = a;
      delayed.block(j * s, s + (3 * e + j) * o, s, o) = -bw;
      for (int i = 0; i < 3; ++i) left.block(i * s, j * s, s, s) -= dt * weights(i, j) * a;
    }
    for (int i = 0; i < 3; ++i) {
      right.middleRows(i * s, s) = state;
      for (int j = 0; j < 3; ++j) {
        right.middleRows(i * s, s) += dt * weights(i, j) * delayed.middleRows(j * s, s);
      }
    }
    const Eigen::MatrixXd stages = left.partialPivLu().solve(right);
    for (int j = 0; j < 3; ++j) {
      map.middleRows(s + (3 * e + j) * o, o) = c * stages.middleRows(j * s, s);
      state += dt * end[j] *
               (slopes_y.middleCols(j * s, s) * stages.middleRows(j * s, s) +
                delayed.middleRows(j * s, s));
    }
  }
  map.topRows(s) = state;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(map, false);
  std::complex<double> best = 0.0;
  for (const std::complex<double>& value : solver.eigenvalues()) {
    if (std::abs(value) > std::abs(best)) best = value;
  }
  return {{best.real(), std::abs(best.imag())}, static_cast<int>(n)};
}

}  // namespace osteomill::vibration
