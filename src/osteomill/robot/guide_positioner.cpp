// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/guide_positioner.hpp"

#include <fmt/format.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

/// Unit vector at an angle from +y, anticlockwise.
Vector2 heading(double angle) { return {-std::sin(angle), std::cos(angle)}; }

/// Derivative of heading: turned by +90°.
Vector2 turned(const Vector2& v) { return {-v.y(), v.x()}; }

bool within(const JointRange& range, double angle) {
  const double turn = 2.0 * std::numbers::pi;
  // The nearest copy of the angle to the middle of the range decides; 1e-9 rad for rounding.
  const double middle = 0.5 * (range.low + range.high);
  const double off = angle - middle;
  const double nearest = middle + off - turn * std::round(off / turn);
  return nearest >= range.low - 1e-9 && nearest <= range.high + 1e-9;
}

void check_range(const char* field, const JointRange& range) {
  require_finite(field, range.low, "rad");
  require_finite(field, range.high, "rad");
  if (!(range.low < range.high)) {
    throw InvalidInput(Fault{
        field, fmt::format("[{:g}, {:g}] deg", range.low / units::deg, range.high / units::deg),
        "must be [low, high] with low < high", ""});
  }
}

}  // namespace

void check(const GuidePositioner& robot) {
  require_positive("robot.l1_mm", robot.link1 / units::mm, "mm");
  require_non_negative("robot.l2_mm", robot.link2 / units::mm, "mm");
  require_non_negative("robot.slide_stroke_mm", robot.slide_stroke / units::mm, "mm");
  require_within("robot.tool_thickness_mm", robot.tool_thickness / units::mm, 0.0, 30.0, "mm");
  check_range("robot.theta1_range_deg", robot.range1);
  check_range("robot.theta2_range_deg", robot.range2);
}

double wrapped(double angle) {
  const double turn = 2.0 * std::numbers::pi;
  const double in = angle - turn * std::round(angle / turn);
  return in <= -std::numbers::pi ? in + turn : in;
}

GuidePose forward(const GuidePositioner& robot, const Vector2& axis_position,
                  const JointAngles& joints, double slide) {
  GuidePose pose;
  pose.X1 = axis_position + robot.link1 * heading(joints.theta1);
  pose.X2 = pose.X1 + (robot.link2 + slide) * heading(joints.theta1 + joints.theta2);
  return pose;
}

std::optional<JointAngles> inverse(const GuidePositioner& robot, const Vector2& axis_position,
                                   const CutLine& line, Branch branch) {
  const Vector2& c = line.direction;
  const Vector2 from_entry = axis_position - line.entry;
  const double along = from_entry.dot(c);
  const double off = from_entry.dot(turned(c));
  const double discriminant = (robot.link1 - off) * (robot.link1 + off);
  if (!(discriminant >= 0.0)) return std::nullopt;
  const double reach = std::sqrt(discriminant);
  const double at = branch == Branch::outermost ? along - reach : along + reach;
  const Vector2 link = line.entry + at * c - axis_position;
  JointAngles joints;
  joints.theta1 = std::atan2(-link.x(), link.y());
  joints.theta2 = wrapped(std::atan2(-c.x(), c.y()) - joints.theta1);
  return joints;
}

bool within_limits(const GuidePositioner& robot, const JointAngles& joints) {
  return within(robot.range1, joints.theta1) && within(robot.range2, joints.theta2);
}

Eigen::Matrix2d plane_jacobian(const GuidePositioner& robot, const Vector2& axis_position,
                               const JointAngles& joints) {
  const Vector2 guide = heading(joints.theta1 + joints.theta2);
  const Vector2 normal = turned(guide);
  const Vector2 link = robot.link1 * heading(joints.theta1);
  // rho = normal · X1; d(normal)/d(phi) = −guide.
  const double turning = -guide.dot(axis_position + link);
  Eigen::Matrix2d jacobian;
  jacobian << 1.0, 1.0, turning + normal.dot(turned(link)), turning;
  return jacobian;
}

double plane_determinant(const GuidePositioner& robot, const JointAngles& joints) {
  return -robot.link1 * std::cos(joints.theta2);
}

Eigen::Matrix2d tip_jacobian(const GuidePositioner& robot, const JointAngles& joints,
                             double slide) {
  const Vector2 guide = (robot.link2 + slide) * heading(joints.theta1 + joints.theta2);
  Eigen::Matrix2d jacobian;
  jacobian.col(1) = turned(guide);
  jacobian.col(0) = turned(robot.link1 * heading(joints.theta1)) + jacobian.col(1);
  return jacobian;
}

GuidePlay guide_play(const GuidePositioner& robot, const JointAngles& joints, double play1,
                     double play2, double slide) {
  const Vector2 normal = turned(heading(joints.theta1 + joints.theta2));
  const Eigen::Matrix2d jacobian = tip_jacobian(robot, joints, slide);
  return {play1 + play2, std::abs(normal.dot(jacobian.col(0))) * play1 +
                             std::abs(normal.dot(jacobian.col(1))) * play2};
}

}  // namespace osteomill::robot
