// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/calibrate/guide_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/calibrate/simulated_tracker.hpp"
#include "osteomill/robot/placement.hpp"

namespace osteomill::calibrate {
namespace {

using units::deg;
using units::mm;

GuideFrame guide() {
  GuideFrame frame;
  const SimulatedRobot robot = simulated_robot();
  // At P1 the guide points posteriorly, its plane holds the axis A2.
  const Pose X_GF = robot.truth.X_FG0.inverse();
  frame.tip_G = X_GF * Vector3(robot.truth.A2_F.point + Vector3(0.0, -30.0 * mm, 20.0 * mm));
  frame.direction_G = X_GF.linear() * -Vector3::UnitY();
  frame.normal_G =
      (X_GF.linear() * robot.truth.A2_F.direction).cross(frame.direction_G).normalized();
  frame.direction_G = frame.normal_G.cross(X_GF.linear() * robot.truth.A2_F.direction).normalized();
  return frame;
}

/// Mahalanobis distance squared of an axis from the truth, direction and position apart.
Eigen::Vector2d distances(const GuideModel& found, const GuideCovariance& covariance,
                          const GuideModel& truth, int first) {
  const Axis& a = first == 0 ? found.A1_F : found.A2_F;
  const Axis& b = first == 0 ? truth.A1_F : truth.A2_F;
  // The four small parameters that carry the found axis onto the true one, by their definition.
  Eigen::Matrix<double, 6, 4> basis;
  for (int k = 0; k < 4; ++k) {
    Eigen::Matrix<double, kGuideParameters, 1> step =
        Eigen::Matrix<double, kGuideParameters, 1>::Zero();
    step[first + k] = 1e-7;
    const GuideModel next = moved(found, step);
    const Axis& c = first == 0 ? next.A1_F : next.A2_F;
    basis.col(k) << (c.point - a.point) / 1e-7, (c.direction - a.direction) / 1e-7;
  }
  Eigen::Matrix<double, 6, 1> off;
  const Vector3 r = b.point - a.point;
  // Any point of the true axis will do: the one across from the found point.
  off << r - b.direction * (a.direction.dot(r) / a.direction.dot(b.direction)),
      b.direction - a.direction;
  const Eigen::Vector4d step = basis.colPivHouseholderQr().solve(off);
  const Eigen::Matrix4d c = covariance.block<4, 4>(first, first);
  return {step.head<2>().dot(c.topLeftCorner<2, 2>().inverse() * step.head<2>()),
          step.tail<2>().dot(c.bottomRightCorner<2, 2>().inverse() * step.tail<2>())};
}

TEST(GuideCalibration, FindsTheRobotWithoutNoiseExactly) {
  SimulatedRobot robot = simulated_robot();
  robot.tracker = {1e-9, 1e-9};
  robot.hall_sd = Halls::Zero();
  Random random(1);
  const GuideCalibration found = calibrate_guide(play_procedure(robot, random));
  EXPECT_TRUE(found.usable);
  const Halls somewhere = robot.truth.reference + Halls(37.0, -50.0);
  const Pose error = robot.truth.pose(somewhere).inverse() * found.fit.model.pose(somewhere);
  EXPECT_LT(error.translation().norm(), 1e-8);
  EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 1e-8);
}

TEST(GuideCalibration, StatesTheUncertaintyOfItsAxesHonestly) {
  const SimulatedRobot robot = simulated_robot();
  const int trials = 500;
  std::array<int, 6> inside{};
  int usable = 0;
  for (int trial = 0; trial < trials; ++trial) {
    Random random(2, static_cast<std::uint64_t>(trial));
    const GuideCalibration found = calibrate_guide(play_procedure(robot, random));
    usable += found.usable;
    const Eigen::Vector2d one = distances(found.fit.model, found.fit.covariance, robot.truth, 0);
    const Eigen::Vector2d two = distances(found.fit.model, found.fit.covariance, robot.truth, 4);
    // 95 % of two degrees of freedom.
    inside[0] += one[0] < 5.991;
    inside[1] += one[1] < 5.991;
    inside[2] += two[0] < 5.991;
    inside[3] += two[1] < 5.991;
    // Plane and circle alone, as the thesis did it.
    const AxisFit& fit = found.axis1;
    const Vector3 direction = fit.direction.dot(robot.truth.A1_F.direction) > 0.0
                                  ? robot.truth.A1_F.direction
                                  : Vector3(-robot.truth.A1_F.direction);
    const Eigen::Vector2d tilt(direction.dot(fit.tangent1), direction.dot(fit.tangent2));
    const Vector3 r = robot.truth.A1_F.point - fit.point;
    const Vector3 off = r - direction * (fit.direction.dot(r) / fit.direction.dot(direction));
    const Eigen::Vector2d shift(off.dot(fit.tangent1), off.dot(fit.tangent2));
    inside[4] += shift.dot(fit.position_covariance.inverse() * shift) < 5.991;
    inside[5] += tilt.dot(fit.direction_covariance.inverse() * tilt) < 5.991;
  }
  for (const int count : inside) EXPECT_GE(count / static_cast<double>(trials), 0.93) << count;
  // No false alarm: the alarm's own level is 1e-4.
  EXPECT_GE(usable, trials - 2);
}

using Kind = CalibrationFault::Kind;

std::vector<CalibrationFault> faults_of(const SimulatedFaults& faults, std::uint64_t seed) {
  Random random(seed);
  return calibrate_guide(play_procedure(simulated_robot(), random, faults)).faults;
}

TEST(GuideCalibration, NamesAMovedReferenceBody) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SimulatedFaults faults;
    faults.reference_moves_at = 6 + seed;
    faults.reference_shift.linear() =
        Eigen::AngleAxisd(1.5 * deg, Vector3(1.0, 1.0, -0.5).normalized()).matrix();
    faults.reference_shift.translation() = Vector3(0.5, -1.0, 1.0) * mm;
    const auto found = faults_of(faults, seed);
    ASSERT_FALSE(found.empty()) << seed;
    EXPECT_EQ(found[0].kind, Kind::moved_reference) << found[0].text;
    EXPECT_THAT(found[0].text, testing::HasSubstr("reference body"));
  }
}

TEST(GuideCalibration, NamesASlippedBrakeAndItsAxis) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SimulatedFaults faults;
    faults.brake_slips_at = 8 + seed;
    faults.slipping_axis = seed % 2 == 0 ? 1 : 2;
    faults.slip = 2.0 * deg;
    const auto found = faults_of(faults, 100 + seed);
    ASSERT_FALSE(found.empty()) << seed;
    EXPECT_EQ(found[0].kind, Kind::slip) << found[0].text;
    EXPECT_THAT(found[0].text,
                testing::HasSubstr(seed % 2 == 0 ? "brake of axis 1" : "brake of axis 2"));
  }
}

TEST(GuideCalibration, NamesAHiddenMarkerAndADisturbedStop) {
  SimulatedFaults hidden;
  hidden.hidden_at = 7;
  hidden.hidden_share = 0.6;
  const auto found = faults_of(hidden, 5);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, Kind::hidden_marker);
  EXPECT_EQ(found[0].stop, "A1 stop 5");
  SimulatedFaults disturbed;
  disturbed.disturbed_at = 17;
  disturbed.disturbance.translation() = Vector3(2.0, 0.0, -1.0) * mm;
  const auto named = faults_of(disturbed, 6);
  ASSERT_FALSE(named.empty());
  EXPECT_EQ(named[0].kind, Kind::bad_stop) << named[0].text;
  EXPECT_EQ(named[0].stop, "A2 stop 4");
}

TEST(GuideCalibration, DrivesTheGuideOntoEveryCut) {
  const SimulatedRobot robot = simulated_robot();
  const auto lines = robot::cut_lines(robot::profile_of(robot::generic_family(), 4));
  Pose X_FI = Pose::Identity();
  Random random(7);
  const GuideRecord record = play_procedure(robot, random);
  const GuideCalibration found = calibrate_guide(record);
  const ImplantTurn turn = turn_implant(X_FI, Vector3::Zero(), found.fit.model.A1_F);
  EXPECT_NEAR(turn.angle, std::acos(robot.truth.A1_F.direction.z()), 0.3 * deg);
  const auto cuts = planned_cuts(lines, turn.X_FF * X_FI);
  const auto targets = cut_targets(found.fit, guide(), cuts, robot.hall_sd);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    ASSERT_TRUE(targets[i].reachable) << robot::name(cuts[i].cut);
    const PlaneError error = plane_error(robot.truth.pose(targets[i].halls), guide(), cuts[i],
                                         robot.truth.A1_F.direction);
    // Five standard deviations as stated; the seed is fixed.
    EXPECT_LT(std::abs(error.flexion), 5.0 * targets[i].sd.flexion);
    EXPECT_LT(std::abs(error.offset), 5.0 * targets[i].sd.offset);
    EXPECT_LT(std::abs(error.tilt), 5.0 * targets[i].sd.tilt);
    EXPECT_LT(targets[i].sd.flexion, 0.3 * deg);
    EXPECT_NEAR(targets[i].left.flexion, 0.0, 1e-9);
    EXPECT_NEAR(targets[i].left.offset, 0.0, 1e-9);
  }
}

TEST(GuideCalibration, TargetsAreThoseOfThePlanarRobotWhenTheAxesAreParallel) {
  SimulatedRobot robot = simulated_robot();
  robot.truth.A1_F.direction = Vector3::UnitZ();
  robot.truth.A2_F.direction = Vector3::UnitZ();
  const auto lines = robot::cut_lines(robot::profile_of(robot::generic_family(), 4));
  GuideFrame frame;
  const Pose X_GF = robot.truth.X_FG0.inverse();
  frame.tip_G = X_GF * Vector3(robot.truth.A2_F.point + Vector3(0.0, -30.0 * mm, 0.0));
  frame.direction_G = X_GF.linear() * -Vector3::UnitY();
  frame.normal_G = X_GF.linear() * Vector3::UnitX();
  GuideFit fit;
  fit.model = robot.truth;
  const auto targets =
      cut_targets(fit, frame, planned_cuts(lines, Pose::Identity()), Halls::Zero());
  const robot::Vector2 X0(robot.truth.A1_F.point.head<2>());
  const robot::Vector2 X1(robot.truth.A2_F.point.head<2>());
  const robot::GuidePositioner planar{.link1 = (X1 - X0).norm(), .link2 = 30.0 * mm};
  const double theta1_at_p1 = std::atan2(-(X1 - X0).x(), (X1 - X0).y());
  const double phi_at_p1 = std::numbers::pi;  // the guide points posteriorly
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const auto joints = robot::inverse(planar, X0, lines[i], robot::Branch::outermost);
    ASSERT_EQ(joints.has_value(), targets[i].reachable);
    if (!joints) continue;
    EXPECT_NEAR(robot::wrapped(targets[i].joints[0] - (joints->theta1 - theta1_at_p1)), 0.0, 1e-9);
    EXPECT_NEAR(
        robot::wrapped(targets[i].joints.sum() - (joints->theta1 + joints->theta2 - phi_at_p1)),
        0.0, 1e-9);
  }
}

TEST(GuideCalibration, SensorConstantsOfTheThreePosesAgreeWithinTheNoise) {
  const SimulatedRobot robot = simulated_robot();
  Random random(8);
  const GuideRecord record = play_procedure(robot, random);
  const GuideCalibration found = calibrate_guide(record);
  const SensorConstants constants =
      sensor_constants(found.fit.model, guide(), record, Vector3::UnitY());
  // 0.713 deg over root 30 in the guide's direction, 0.46 mm over root 30 at 60 mm, times the gear;
  // the range of three is below five standard deviations.
  EXPECT_LT(constants.spread[0], 5.0 * 100.0 * 0.2 * deg);
  EXPECT_LT(constants.spread[1], 5.0 * 100.0 * 0.2 * deg);
  // By definition theta at P1 from the constants is the angle that the truth has there.
  const Vector3 link = robot.truth.A2_F.point - robot.truth.A1_F.point;
  const double theta1 = std::atan2(-link.x(), link.y());
  EXPECT_NEAR((robot.truth.reference[0] - constants.mean[0]) / 100.0, theta1, 0.5 * deg);
}

TEST(PoseFilter, SettlesToATenthOfADegreeAndRejectsBlunders) {
  Random random(9);
  const Pose still = simulated_robot().truth.X_FG0;
  PoseFilter filter;
  auto samples = readings(still, {}, 400, random);
  samples[50].X_FG.translation() += Vector3(30.0, 0.0, 0.0) * mm;
  double turn = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto filtered = filter.push(samples[i]);
    ASSERT_TRUE(filtered);
    if (i < 20) continue;
    // Ten readings: 0.15 mm a coordinate; one accepted blunder would be 3 mm.
    EXPECT_LT((filtered->translation() - still.translation()).norm(), 0.9 * mm) << i;
    turn += rotation_between(still, *filtered).squaredNorm() / 3.0;
    ++count;
  }
  // Ten readings of 0.713 deg: 0.23 deg; the published "about 0.1 deg" is the display's flicker.
  EXPECT_LT(std::sqrt(turn / count), 0.713 * deg / std::sqrt(10.0) * 1.1);
}

TEST(PoseFilter, FollowsABodyThatMoves) {
  Random random(10);
  PoseFilter filter;
  const Pose first = simulated_robot().truth.X_FG0;
  Pose second = first;
  second.translation() += Vector3(50.0, 0.0, 0.0) * mm;
  for (const PoseSample& sample : readings(first, {}, 30, random)) filter.push(sample);
  Vector3 last = Vector3::Zero();
  for (const PoseSample& sample : readings(second, {}, 20, random)) {
    const auto filtered = filter.push(sample);
    if (filtered) last = filtered->translation();
  }
  EXPECT_LT((last - second.translation()).norm(), 1.0 * mm);
  EXPECT_FALSE(PoseFilter().push({.visible = false, .X_FG = first}));
}

TEST(GuideCalibration, RefusesHalfARecording) {
  Random random(11);
  GuideRecord record = play_procedure(simulated_robot(), random);
  record.sweep1.resize(2);
  EXPECT_THROW(calibrate_guide(record), InvalidInput);
  record = play_procedure(simulated_robot(), random);
  for (PoseSample& sample : record.sweep2[3].samples) sample.visible = false;
  EXPECT_THROW(calibrate_guide(record), InvalidInput);
  record = play_procedure(simulated_robot(), random);
  EXPECT_THROW(calibrate_guide(record, {.gear = {0.0, 100.0}}), InvalidInput);
  record.passive[0].samples[0].X_FG.translation().x() = std::nan("");
  EXPECT_THROW(calibrate_guide(record), InvalidInput);
  EXPECT_THROW(guide_frame_from_cones({Vector3::Zero(), Vector3::UnitX()}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::calibrate
