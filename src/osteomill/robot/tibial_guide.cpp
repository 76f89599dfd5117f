// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/tibial_guide.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

using geometry::Pose;
using geometry::Vector3;

void check(const TibialGuide& guide) {
  for (const auto& [field, axis] : {std::pair{"guide.slide", guide.slide_B},
                                    std::pair{"guide.flexion_axis", guide.flexion_axis_B},
                                    std::pair{"guide.varus_axis", guide.varus_axis_B},
                                    std::pair{"guide.normal", guide.normal_B}}) {
    if (std::abs(axis.norm() - 1.0) > 1e-9) {
      throw InvalidInput(
          Fault{field, fmt::format("length {:g}", axis.norm()), "must be a unit vector", ""});
    }
  }
  if (guide.flexion_axis_B.cross(guide.varus_axis_B).norm() < 0.1) {
    throw InvalidInput(Fault{"guide.varus_axis", "nearly parallel to the flexion axis",
                             "must stand across it", ""});
  }
}

/// Angle of the turn about `axis` that carries a onto b.
double turn_between(const Vector3& axis, const Vector3& a, const Vector3& b) {
  const Vector3 pa = a - axis * axis.dot(a);
  const Vector3 pb = b - axis * axis.dot(b);
  return std::atan2(axis.dot(pa.cross(pb)), pa.dot(pb));
}

Vector3 normal_of(const TibialGuide& guide, const TibialJoints& joints) {
  return Eigen::AngleAxisd(joints.flexion, guide.flexion_axis_B) *
         (Eigen::AngleAxisd(joints.varus, guide.varus_axis_B) * guide.normal_B);
}

TibialDisplay shown(const Vector3& normal_A, const Vector3& point_A) {
  // z = depth + x tan(varus) − ... : the plane as a height over the anatomy's x and y.
  return {std::atan2(-normal_A.x(), normal_A.z()), std::atan2(-normal_A.y(), normal_A.z()),
          normal_A.dot(point_A) / normal_A.z()};
}

}  // namespace

TibialDisplay display(const TibialGuide& guide, const Pose& X_AB, const TibialJoints& joints) {
  check(guide);
  const Vector3 normal = normal_of(guide, joints);
  const Vector3 point = guide.centre_B + joints.slide * guide.slide_B + guide.height * normal;
  return shown(X_AB.linear() * normal, X_AB * point);
}

TibialSetting solve(const TibialGuide& guide, const Pose& X_AB, const TibialDisplay& target) {
  check(guide);
  const Vector3 normal_A =
      Vector3(-std::tan(target.varus), -std::tan(target.slope), 1.0).normalized();
  const Vector3 q = X_AB.linear().transpose() * normal_A;
  const Vector3& p = guide.normal_B;
  const Vector3& u1 = guide.flexion_axis_B;
  const Vector3& u2 = guide.varus_axis_B;
  const double c = u1.dot(u2);
  const double a = (c * u2.dot(p) - u1.dot(q)) / (c * c - 1.0);
  const double b = (c * u1.dot(q) - u2.dot(p)) / (c * c - 1.0);
  const Vector3 across = u1.cross(u2);
  const double rest = (1.0 - a * a - b * b - 2.0 * a * b * c) / across.squaredNorm();
  TibialSetting best;
  if (rest < 0.0) {
    best.reason = "no turns of the two axes give this plane; pin the base straighter";
    return best;
  }
  double least = std::numeric_limits<double>::infinity();
  for (const double sign : {1.0, -1.0}) {
    const Vector3 middle = a * u1 + b * u2 + sign * std::sqrt(rest) * across;
    TibialJoints joints;
    joints.varus = turn_between(u2, p, middle);
    joints.flexion = turn_between(u1, middle, q);
    const double size = std::max(std::abs(joints.varus), std::abs(joints.flexion));
    if (size >= least) continue;
    least = size;
    const Vector3 normal = normal_of(guide, joints);
    const Vector3 at_zero = guide.centre_B + guide.height * normal;
    const Vector3 n_A = X_AB.linear() * normal;
    const double depth = n_A.dot(X_AB * at_zero) / n_A.z();
    const double per_slide = n_A.dot(X_AB.linear() * guide.slide_B) / n_A.z();
    if (std::abs(per_slide) < 0.1) {
      best.reason = "the slide runs along the plane and cannot set its depth";
      continue;
    }
    joints.slide = (target.depth - depth) / per_slide;
    best.joints = joints;
    best.reachable =
        std::abs(joints.slide) <= 0.5 * guide.slide_range && size <= 0.5 * guide.angle_range;
    best.reason = best.reachable ? ""
                                 : fmt::format(
                                       "beyond the guide's range: slide {:.1f} mm, F/E {:.1f} deg, "
                                       "V/V {:.1f} deg; pin the base nearer to the target",
                                       joints.slide / units::mm, joints.flexion / units::deg,
                                       joints.varus / units::deg);
  }
  return best;
}

std::vector<AdjustmentStep> adjust_by_screen(const TibialGuide& guide, const Pose& X_AB,
                                             const TibialJoints& start, const TibialDisplay& target,
                                             double tolerance, int most_steps) {
  require_positive("tolerance_deg", tolerance / units::deg, "deg");
  std::vector<AdjustmentStep> steps{{start, display(guide, X_AB, start)}};
  const auto off = [&](const TibialDisplay& d) {
    return std::max(std::abs(d.varus - target.varus), std::abs(d.slope - target.slope));
  };
  // One axis at a time: secant on its own angle until the screen shows it right.
  const auto turn = [&](bool varus) {
    TibialJoints joints = steps.back().joints;
    double& joint = varus ? joints.varus : joints.flexion;
    const auto wrong = [&](double value) {
      joint = value;
      const TibialDisplay d = display(guide, X_AB, joints);
      return varus ? d.varus - target.varus : d.slope - target.slope;
    };
    double x0 = joint;
    double x1 = joint + 0.01;
    double f0 = wrong(x0);
    for (int i = 0; i < 30; ++i) {
      const double f1 = wrong(x1);
      if (std::abs(f1) < 1e-12 || f1 == f0) break;
      const double next = x1 - f1 * (x1 - x0) / (f1 - f0);
      x0 = x1;
      f0 = f1;
      x1 = next;
    }
    joint = x1;
    steps.push_back({joints, display(guide, X_AB, joints)});
  };
  for (int i = 0; i < most_steps && off(steps.back().shown) > tolerance; ++i) turn(i % 2 == 0);
  return steps;
}

}  // namespace osteomill::robot
