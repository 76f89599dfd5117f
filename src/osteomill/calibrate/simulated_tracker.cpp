// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/calibrate/simulated_tracker.hpp"

#include <fmt/format.h>

#include <cmath>

namespace osteomill::calibrate {
namespace {

using units::deg;
using units::mm;

Vector3 normal_vector(Random& random, double sd) {
  const double x = random.normal(0.0, sd);
  const double y = random.normal(0.0, sd);
  const double z = random.normal(0.0, sd);
  return {x, y, z};
}

}  // namespace

SimulatedRobot simulated_robot() {
  SimulatedRobot robot;
  // F: x distal, y anterior, z lateral; the robot stands on the medial side. G is on the guide,
  // some 60 mm from A2 and 90 mm from A1, so that both circles are large against the camera's
  // noise.
  robot.truth.A1_F = {{-33.0 * mm, 4.0 * mm, -40.0 * mm}, Vector3(0.01, -0.008, 1.0).normalized()};
  robot.truth.A2_F = {{2.0 * mm, 52.7 * mm, -40.0 * mm}, robot.truth.A1_F.direction};
  robot.truth.X_FG0.translation() = Vector3(28.0 * mm, 108.0 * mm, -25.0 * mm);
  robot.truth.X_FG0.linear() =
      (Eigen::AngleAxisd(0.4, Vector3::UnitX()) * Eigen::AngleAxisd(-0.7, Vector3::UnitY()))
          .toRotationMatrix();
  robot.truth.reference = {1234.0 * deg, -567.0 * deg};
  robot.truth.gear = {100.0, 100.0};
  return robot;
}

std::vector<PoseSample> readings(const Pose& X_FG, const TrackerNoise& noise, int count,
                                 Random& random) {
  std::vector<PoseSample> samples;
  for (int i = 0; i < count; ++i) {
    PoseSample sample;
    sample.X_FG = X_FG;
    sample.X_FG.translation() += normal_vector(random, noise.position);
    const Vector3 turn = normal_vector(random, noise.rotation);
    if (turn.norm() > 0.0) {
      sample.X_FG.linear() = X_FG.linear() * Eigen::AngleAxisd(turn.norm(), turn.normalized());
    }
    samples.push_back(sample);
  }
  return samples;
}

GuideRecord play_procedure(const SimulatedRobot& robot, Random& random,
                           const SimulatedFaults& faults) {
  std::size_t number = 0;
  const auto stop = [&](std::string name, double theta1, double theta2) {
    StopRecord record;
    record.name = std::move(name);
    const Halls there =
        robot.truth.reference + Halls(theta1, theta2).cwiseProduct(robot.truth.gear);
    Halls actual = there;
    if (faults.brake_slips_at && number >= *faults.brake_slips_at) {
      const int joint = faults.slipping_axis - 1;
      actual[joint] += faults.slip * robot.truth.gear[joint];
    }
    Pose X_FG = robot.truth.pose(actual);
    if (faults.reference_moves_at && number >= *faults.reference_moves_at) {
      X_FG = faults.reference_shift * X_FG;
    }
    if (faults.disturbed_at == number) X_FG = X_FG * faults.disturbance;
    record.samples = readings(X_FG, robot.tracker, robot.samples, random);
    if (faults.hidden_at == number) {
      const auto hidden = static_cast<std::size_t>(faults.hidden_share * robot.samples);
      for (std::size_t i = 0; i < hidden && i < record.samples.size(); ++i) {
        record.samples[i].visible = false;
      }
    }
    // The mean of as many sensor readings as camera readings.
    const double root = std::sqrt(static_cast<double>(robot.samples));
    record.halls[0] = there[0] + random.normal(0.0, robot.hall_sd[0] / root);
    record.halls[1] = there[1] + random.normal(0.0, robot.hall_sd[1] / root);
    ++number;
    return record;
  };
  GuideRecord record;
  const double half = 0.5 * robot.range1;
  record.passive = {stop("P1", 0.0, 0.0), stop("P2", -half, 0.0), stop("P3", half, 0.0)};
  const int stops1 = static_cast<int>(std::round(robot.range1 / robot.step)) + 1;
  for (int i = 0; i < stops1; ++i) {
    record.sweep1.push_back(stop(fmt::format("A1 stop {}", i + 1), half - i * robot.step, 0.0));
  }
  const int stops2 = static_cast<int>(std::round(robot.range2 / robot.step)) + 1;
  for (int i = 0; i < stops2; ++i) {
    record.sweep2.push_back(
        stop(fmt::format("A2 stop {}", i + 1), 0.0, robot.start2 - i * robot.step));
  }
  return record;
}

}  // namespace osteomill::calibrate
