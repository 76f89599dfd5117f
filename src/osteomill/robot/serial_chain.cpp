// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/serial_chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/numerics/decompositions.hpp"

namespace osteomill::robot {
namespace {

using Vector = Eigen::VectorXd;
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;

Pose exponential(const Joint& joint, double q) {
  Pose pose = Pose::Identity();
  if (joint.prismatic) {
    pose.translation() = q * joint.direction;
  } else {
    pose.linear() = Eigen::AngleAxisd(q, joint.direction).toRotationMatrix();
    pose.translation() = joint.point - pose.linear() * joint.point;
  }
  return pose;
}

/// Position error, and rotation error in B, from here to the target.
Eigen::Matrix<double, 6, 1> pose_error(const Pose& here, const Pose& target,
                                       bool free_about_tool_axis) {
  Eigen::Matrix<double, 6, 1> error;
  error.head<3>() = target.translation() - here.translation();
  if (free_about_tool_axis) {
    // The shortest turn of the tool's axis onto its target.
    const Eigen::AngleAxisd turn(
        Eigen::Quaterniond::FromTwoVectors(here.linear().col(2), target.linear().col(2)));
    error.tail<3>() = turn.angle() * turn.axis();
  } else {
    const Eigen::AngleAxisd turn(target.linear() * here.linear().transpose());
    error.tail<3>() = turn.angle() * turn.axis();
  }
  return error;
}

double limit_distance(const SerialChain& chain, const Vector& q) {
  double least = 1.0;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Joint& joint = chain.joints[static_cast<std::size_t>(i)];
    const double half = 0.5 * (joint.high - joint.low);
    least = std::min(least, std::min(q[i] - joint.low, joint.high - q[i]) / half);
  }
  return least;
}

}  // namespace

void check(const SerialChain& chain) {
  if (chain.joints.empty()) {
    throw InvalidInput(Fault{"robot.joints", "", "must have at least one joint", ""});
  }
  for (const Joint& joint : chain.joints) {
    const std::string field = "robot.joints." + joint.name;
    if (std::abs(joint.direction.norm() - 1.0) > 1e-9) {
      throw InvalidInput(Fault{field,
                               fmt::format("direction of length {:g}", joint.direction.norm()),
                               "must be a unit vector", ""});
    }
    if (!(joint.low < joint.high)) {
      throw InvalidInput(Fault{field, fmt::format("[{:g}, {:g}]", joint.low, joint.high),
                               "must be [low, high] with low < high", ""});
    }
    require_non_negative((field + ".compliance").c_str(), joint.compliance, "");
  }
}

SerialChain chain_from_dh(const std::vector<DhRow>& rows) {
  SerialChain chain;
  Pose frame = Pose::Identity();
  for (const DhRow& row : rows) {
    chain.joints.push_back({row.name, row.prismatic, frame.translation(), frame.linear().col(2),
                            row.low, row.high, 0.0});
    frame = frame * Eigen::AngleAxisd(row.theta, Vector3::UnitZ()) *
            Eigen::Translation3d(row.a, 0.0, row.d) *
            Eigen::AngleAxisd(row.alpha, Vector3::UnitX());
  }
  chain.X_BT0 = frame;
  check(chain);
  return chain;
}

Pose forward(const SerialChain& chain, const Vector& q) {
  Pose pose = Pose::Identity();
  for (Eigen::Index i = 0; i < chain.size(); ++i) {
    pose = pose * exponential(chain.joints[static_cast<std::size_t>(i)], q[i]);
  }
  return pose * chain.X_BT0;
}

Jacobian jacobian(const SerialChain& chain, const Vector& q) {
  const Vector3 tool = forward(chain, q).translation();
  Jacobian columns(6, chain.size());
  Pose before = Pose::Identity();
  for (Eigen::Index i = 0; i < chain.size(); ++i) {
    const Joint& joint = chain.joints[static_cast<std::size_t>(i)];
    const Vector3 axis = before.linear() * joint.direction;
    if (joint.prismatic) {
      columns.col(i) << axis, Vector3::Zero();
    } else {
      columns.col(i) << axis.cross(tool - before * joint.point), axis;
    }
    before = before * exponential(joint, q[i]);
  }
  return columns;
}

Dexterity dexterity(const SerialChain& chain, const Vector& q, double length) {
  require_positive("dexterity.length_mm", length / units::mm, "mm");
  Jacobian scaled = jacobian(chain, q);
  scaled.topRows<3>() /= length;
  // Slides count in lengths too.
  for (Eigen::Index i = 0; i < chain.size(); ++i) {
    if (chain.joints[static_cast<std::size_t>(i)].prismatic) scaled.col(i) *= length;
  }
  const Eigen::MatrixXd gram = scaled * scaled.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  Dexterity result;
  result.manipulability = 1.0;
  const double largest = std::sqrt(eigen.eigenvalues()[5]);
  for (int k = 0; k < 6; ++k) {
    const double value = std::sqrt(std::max(0.0, eigen.eigenvalues()[k]));
    result.rank += value > 1e-6 * largest;
    result.manipulability *= value;
    if (k == 0) result.smallest = value;
  }
  return result;
}

InverseResult inverse(const SerialChain& chain, const Pose& X_BT, const Vector& start,
                      const InverseOptions& options) {
  check(chain);
  if (start.size() != chain.size()) {
    throw InvalidInput(Fault{"reach.start", fmt::format("{} values", start.size()),
                             fmt::format("must be {} joint values", chain.size()), ""});
  }
  Vector low(chain.size());
  Vector high(chain.size());
  for (Eigen::Index i = 0; i < chain.size(); ++i) {
    low[i] = chain.joints[static_cast<std::size_t>(i)].low;
    high[i] = chain.joints[static_cast<std::size_t>(i)].high;
  }
  const Vector middle = 0.5 * (low + high);
  const Vector half = 0.5 * (high - low);
  InverseResult best;
  best.position_error = std::numeric_limits<double>::infinity();
  Random random(options.seed);
  for (int attempt = 0; attempt <= options.starts; ++attempt) {
    Vector q = start;
    for (Eigen::Index i = 0; i < q.size() && attempt > 0; ++i) {
      q[i] = random.uniform(low[i], high[i]);
    }
    q = q.cwiseMax(low).cwiseMin(high);
    InverseResult result;
    double damping = 1e-3;
    Eigen::Matrix<double, 6, 1> error;
    for (int round = 0; round < options.max_iterations; ++round) {
      const Pose here = forward(chain, q);
      error = pose_error(here, X_BT, options.free_about_tool_axis);
      result.position_error = error.head<3>().norm();
      result.rotation_error = error.tail<3>().norm();
      result.iterations = round;
      // Positions in decimetres, so that they weigh like radians.
      Eigen::Matrix<double, 6, 1> scaled = error;
      scaled.head<3>() *= 10.0;
      Jacobian columns = jacobian(chain, q);
      if (options.free_about_tool_axis) {
        const Vector3 axis = here.linear().col(2);
        columns.bottomRows<3>() -= axis * (axis.transpose() * columns.bottomRows<3>());
      }
      columns.topRows<3>() *= 10.0;
      // Joints in shares of their half range; one that is at a limit and pushed out is held.
      Jacobian weighted = columns * half.asDiagonal();
      const Vector wish = (middle - q).cwiseQuotient(half);
      Vector step;
      std::vector<bool> held(static_cast<std::size_t>(q.size()), false);
      for (int pass = 0; pass <= q.size(); ++pass) {
        const Eigen::Matrix<double, 6, 6> gram =
            weighted * weighted.transpose() +
            damping * damping * Eigen::Matrix<double, 6, 6>::Identity();
        const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(gram);
        Vector free_wish = 0.2 * wish;
        for (Eigen::Index i = 0; i < q.size(); ++i) {
          if (held[static_cast<std::size_t>(i)]) free_wish[i] = 0.0;
        }
        step = free_wish + weighted.transpose() * solver.solve(scaled - weighted * free_wish);
        bool again = false;
        for (Eigen::Index i = 0; i < q.size(); ++i) {
          const double there = q[i] + step[i] * half[i];
          if (held[static_cast<std::size_t>(i)] ||
              !((q[i] <= low[i] && there < low[i]) || (q[i] >= high[i] && there > high[i]))) {
            continue;
          }
          held[static_cast<std::size_t>(i)] = true;
          weighted.col(i).setZero();
          again = true;
        }
        if (!again) break;
      }
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        if (held[static_cast<std::size_t>(i)]) step[i] = 0.0;
      }
      const bool there = result.position_error < options.position_tolerance &&
                         result.rotation_error < options.rotation_tolerance;
      // Once there, go on only while the joints still move towards the middle.
      if (there && (step.norm() < 1e-6 || round + 1 == options.max_iterations)) {
        result.converged = true;
        break;
      }
      const double longest = step.cwiseAbs().maxCoeff();
      if (longest > 0.3) step *= 0.3 / longest;
      const Vector next = (q + step.cwiseProduct(half)).cwiseMax(low).cwiseMin(high);
      if (there) {
        // Motion in the null space must not lose the pose again by its curvature for good.
        result.converged = true;
        result.q = q;
      }
      q = next;
      damping = std::clamp(scaled.norm() * 0.1, 1e-8, 0.1);
    }
    if (!result.converged || result.position_error < options.position_tolerance) result.q = q;
    const Eigen::Matrix<double, 6, 1> last =
        pose_error(forward(chain, result.q), X_BT, options.free_about_tool_axis);
    result.position_error = last.head<3>().norm();
    result.rotation_error = last.tail<3>().norm();
    result.converged = result.position_error < options.position_tolerance &&
                       result.rotation_error < options.rotation_tolerance;
    result.limit_distance = limit_distance(chain, result.q);
    if (result.converged) return result;
    if (result.position_error + 0.1 * result.rotation_error <
        best.position_error + 0.1 * best.rotation_error) {
      best = result;
    }
  }
  best.reason = fmt::format(
      "no joint values within the limits reach the pose: {:.3f} mm and {:.3f} deg are left after "
      "{} "
      "starts",
      best.position_error / units::mm, best.rotation_error / units::deg, options.starts + 1);
  return best;
}

Eigen::Matrix<double, 6, 6> tool_compliance(const SerialChain& chain, const Vector& q) {
  const Jacobian columns = jacobian(chain, q);
  Vector compliance(chain.size());
  for (Eigen::Index i = 0; i < chain.size(); ++i) {
    compliance[i] = chain.joints[static_cast<std::size_t>(i)].compliance;
  }
  return columns * compliance.asDiagonal() * columns.transpose();
}

StiffnessEllipsoid stiffness_ellipsoid(const SerialChain& chain, const Vector& q) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
      tool_compliance(chain, q).topLeftCorner<3, 3>());
  StiffnessEllipsoid result;
  for (int k = 2; k >= 0; --k) {
    if (!(eigen.eigenvalues()[k] > 1e-12 * eigen.eigenvalues()[2])) continue;
    result.stiffness.push_back(1.0 / eigen.eigenvalues()[k]);
    result.directions.push_back(eigen.eigenvectors().col(k));
  }
  return result;
}

SerialChain seven_axis_robot(const SevenAxisDimensions& d) {
  using units::deg;
  using units::n_per_mm;
  const Vector3 i = Vector3::UnitX();
  const Vector3 j = Vector3::UnitY();
  const Vector3 k = Vector3::UnitZ();
  const Vector3 on_b = d.c2 * j;
  const Vector3 on_c = on_b + d.c3 * i + d.c4 * k;
  const Vector3 on_a = on_c + d.c5 * j;
  SerialChain chain;
  chain.joints = {
      {"Z", true, Vector3::Zero(), i, -0.20, 0.20, 0.0},
      {"B", false, on_b, j, -60.0 * deg, 60.0 * deg, 0.0},
      {"C", false, on_c, k, -60.0 * deg, 60.0 * deg, 0.0},
      {"W", true, Vector3::Zero(), k, -0.10, 0.10, 1.0 / (65.0 * n_per_mm)},
      {"V", true, Vector3::Zero(), j, -0.10, 0.10, 1.0 / (72.0 * n_per_mm)},
      {"U", true, Vector3::Zero(), i, -0.10, 0.10, 1.0 / (271.0 * n_per_mm)},
      {"A", false, on_a, i, -90.0 * deg, 90.0 * deg, 0.0},
  };
  chain.X_BT0 = Pose::Identity();
  chain.X_BT0.translation() = on_a + d.g9;
  return chain;
}

}  // namespace osteomill::robot
