// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/calibrate/shape_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::calibrate {
namespace {

using units::deg;
using units::mm;

Vector3 noise(Random& random, double sd) {
  const double x = random.normal();
  const double y = random.normal();
  return sd * Vector3(x, y, random.normal());
}

Pose some_pose(Random& random, double turn) {
  Pose pose = Pose::Identity();
  pose.linear() =
      Eigen::AngleAxisd(random.uniform(0.0, turn), noise(random, 1.0).normalized()).matrix();
  pose.translation() = noise(random, 0.1);
  return pose;
}

/// Points on an arc about an axis, and what the fit says about the axis.
struct Arc {
  Vector3 direction = Vector3(0.2, -0.3, 1.0).normalized();
  Vector3 centre{0.01, -0.02, 0.03};
  Vector3 first = direction.cross(Vector3::UnitX()).normalized();
  double radius = 0.08;
  double range = 100.0 * deg;
  int stops = 11;

  std::vector<Vector3> points() const {
    std::vector<Vector3> list;
    for (int i = 0; i < stops; ++i) {
      const double angle = range * i / (stops - 1);
      list.push_back(centre +
                     radius * (std::cos(angle) * first + std::sin(angle) * direction.cross(first)));
    }
    return list;
  }
};

TEST(AxisFit, FindsTheAxisOfExactPoints) {
  const Arc arc;
  const AxisFit fit = fit_axis(arc.points());
  EXPECT_NEAR(std::abs(fit.direction.dot(arc.direction)), 1.0, 1e-14);
  EXPECT_LT((fit.point - arc.centre).norm(), 1e-12);
  EXPECT_NEAR(fit.radius, arc.radius, 1e-12);
  EXPECT_NEAR(fit.angle_range, arc.range, 1e-9);
}

TEST(AxisFit, FollowsARigidMotion) {
  Random random(1);
  const Arc arc;
  auto points = arc.points();
  for (Vector3& p : points) p += noise(random, 0.1 * mm);
  const AxisFit before = fit_axis(points);
  const Pose move = some_pose(random, 3.0);
  for (Vector3& p : points) p = move * p;
  const AxisFit after = fit_axis(points);
  EXPECT_LT((after.point - move * before.point).norm(), 1e-10);
  EXPECT_NEAR(std::abs(after.direction.dot(move.linear() * before.direction)), 1.0, 1e-12);
}

TEST(AxisFit, StatesItsUncertaintyHonestly) {
  // 95 % regions of direction and position: chi-squared with two degrees of freedom below 5.991.
  const int trials = 2000;
  int direction_inside = 0;
  int position_inside = 0;
  const Arc arc;
  for (int trial = 0; trial < trials; ++trial) {
    Random random(2, static_cast<std::uint64_t>(trial));
    auto points = arc.points();
    std::vector<double> sd;
    for (Vector3& p : points) {
      sd.push_back(random.uniform(0.05, 0.3) * mm);  // stops of different quality
      p += noise(random, sd.back());
    }
    const AxisFit fit = fit_axis(points, sd);
    const Vector3 truth =
        fit.direction.dot(arc.direction) > 0.0 ? arc.direction : Vector3(-arc.direction);
    const Eigen::Vector2d tilt(truth.dot(fit.tangent1), truth.dot(fit.tangent2));
    const Vector3 off = arc.centre - fit.point;
    const Eigen::Vector2d shift(off.dot(fit.tangent1), off.dot(fit.tangent2));
    direction_inside += tilt.dot(fit.direction_covariance.inverse() * tilt) < 5.991;
    position_inside += shift.dot(fit.position_covariance.inverse() * shift) < 5.991;
  }
  // Three standard errors of a share of 0.95.
  const double margin = 3.0 * std::sqrt(0.95 * 0.05 / trials);
  EXPECT_NEAR(direction_inside / static_cast<double>(trials), 0.95, margin);
  EXPECT_NEAR(position_inside / static_cast<double>(trials), 0.95, margin);
}

TEST(AxisFit, GivesBadStopsTheirWeight) {
  const Arc arc;
  auto points = arc.points();
  std::vector<double> sd(points.size(), 0.05 * mm);
  Random random(3);
  for (Vector3& p : points) p += noise(random, 0.05 * mm);
  points[4] += Vector3(3.0, -2.0, 2.0) * mm;
  const double unweighted = (fit_axis(points).point - arc.centre).norm();
  sd[4] = 4.0 * mm;
  const double weighted = (fit_axis(points, sd).point - arc.centre).norm();
  EXPECT_LT(weighted, 0.2 * unweighted);
}

TEST(SphereFit, FindsCentreAndRadiusWithTheirDeviation) {
  Random random(4);
  const Vector3 centre(0.3, -0.1, 0.5);
  int inside = 0;
  const int trials = 500;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<Vector3> points;
    for (int i = 0; i < 60; ++i) {
      // A cap, as the hip's motion covers.
      const Vector3 d =
          Vector3(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 1.0).normalized();
      points.push_back(centre + 0.4 * d + noise(random, 0.5 * mm));
    }
    const SphereFit fit = fit_sphere(points);
    const double z = (fit.radius - 0.4) / std::sqrt(fit.covariance(3, 3));
    inside += std::abs(z) < 1.96;
  }
  // Small samples with unknown noise: Student's t with 56 degrees is within 0.3 % of normal.
  EXPECT_GT(inside / static_cast<double>(trials), 0.95 - 3.0 * std::sqrt(0.95 * 0.05 / trials));
}

TEST(PlaneFit, GivesNormalAndOffset) {
  Random random(5);
  const Vector3 normal = Vector3(1.0, 2.0, -0.5).normalized();
  const Vector3 a = normal.cross(Vector3::UnitX()).normalized();
  std::vector<Vector3> points;
  for (int i = 0; i < 50; ++i) {
    points.push_back(0.02 * normal + random.uniform(-0.05, 0.05) * a +
                     random.uniform(-0.05, 0.05) * normal.cross(a));
  }
  const PlaneFit fit = fit_plane(points);
  EXPECT_NEAR(std::abs(fit.normal.dot(normal)), 1.0, 1e-12);
  EXPECT_NEAR(std::abs(fit.offset), 0.02, 1e-12);
  EXPECT_LT(fit.quality.residual_rms, 1e-15);
}

TEST(PivotFit, FindsTheTip) {
  Random random(6);
  const Vector3 tip(0.01, 0.0, -0.15);
  const Vector3 pivot(0.2, 0.1, 0.3);
  std::vector<Pose> poses;
  for (int i = 0; i < 40; ++i) {
    Pose pose = some_pose(random, 1.0);
    pose.translation() = pivot - pose.linear() * tip + noise(random, 0.3 * mm);
    poses.push_back(pose);
  }
  const PivotFit fit = fit_pivot(poses);
  // Four standard deviations of its own covariance.
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(fit.tip_P[k], tip[k], 4.0 * std::sqrt(fit.covariance(k, k)));
  }
  EXPECT_NEAR(fit.quality.residual_rms, 0.3 * mm, 0.05 * mm);
}

TEST(RegistrationFit, UndoesARigidMotion) {
  Random random(7);
  const Pose truth = some_pose(random, 3.0);
  std::vector<Vector3> a;
  std::vector<Vector3> b;
  for (int i = 0; i < 5; ++i) {
    b.push_back(noise(random, 0.05));
    a.push_back(truth * b.back());
  }
  EXPECT_LT((register_points(a, b).X_AB.matrix() - truth.matrix()).norm(), 1e-12);
}

TEST(ShapeFits, RefuseWhatCannotBeFitted) {
  const std::vector<Vector3> two = {Vector3::Zero(), Vector3::UnitX()};
  const std::vector<Vector3> line = {Vector3::Zero(), Vector3::UnitX(), 2.0 * Vector3::UnitX(),
                                     3.0 * Vector3::UnitX()};
  const std::vector<Vector3> flat = {Vector3::Zero(), Vector3::UnitX(), Vector3::UnitY(),
                                     Vector3(1.0, 1.0, 0.0), Vector3(2.0, 1.0, 0.0)};
  EXPECT_THROW(fit_plane(two), InvalidInput);
  EXPECT_THROW(fit_plane(line), InvalidInput);
  EXPECT_THROW(fit_sphere(flat), InvalidInput);
  EXPECT_THROW(fit_axis(line), InvalidInput);
  Arc narrow;
  narrow.range = 5.0 * deg;
  EXPECT_THROW(fit_axis(narrow.points()), InvalidInput);
  EXPECT_THROW(fit_axis(Arc().points(), {1.0, 2.0}), InvalidInput);
  EXPECT_THROW(fit_pivot({Pose::Identity(), Pose::Identity(), Pose::Identity()}), InvalidInput);
  EXPECT_THROW(register_points(flat, line), InvalidInput);
  auto nan = Arc().points();
  nan[0].x() = std::nan("");
  EXPECT_THROW(fit_axis(nan), InvalidInput);
}

}  // namespace
}  // namespace osteomill::calibrate
