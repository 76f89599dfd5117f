// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/serial_chain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

using units::deg;
using units::mm;
using units::n_per_mm;

Eigen::VectorXd random_joints(const SerialChain& chain, Random& random, double share) {
  Eigen::VectorXd q(chain.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Joint& joint = chain.joints[static_cast<std::size_t>(i)];
    const double middle = 0.5 * (joint.low + joint.high);
    q[i] = middle + share * random.uniform(joint.low - middle, joint.high - middle);
  }
  return q;
}

/// [sugita2009] eq. 1 and 2 written out.
Pose printed_formula(const SevenAxisDimensions& d, const Eigen::VectorXd& q) {
  const Eigen::Matrix3d Ry = Eigen::AngleAxisd(q[1], Vector3::UnitY()).matrix();
  const Eigen::Matrix3d Rz = Eigen::AngleAxisd(q[2], Vector3::UnitZ()).matrix();
  const Eigen::Matrix3d Rx = Eigen::AngleAxisd(q[6], Vector3::UnitX()).matrix();
  Pose pose = Pose::Identity();
  pose.linear() = Ry * Rz * Rx;
  pose.translation() =
      Vector3(q[0], d.c2, 0.0) +
      Ry * (Vector3(d.c3, 0.0, d.c4) + Rz * (Vector3(q[5], d.c5 + q[4], q[3]) + Rx * d.g9));
  return pose;
}

TEST(SevenAxisRobot, IsThePrintedFormula) {
  SevenAxisDimensions d;
  d.c3 = 0.04;
  d.c4 = -0.07;
  const SerialChain robot = seven_axis_robot(d);
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::VectorXd q = random_joints(robot, random, 1.0);
    EXPECT_LT((forward(robot, q).matrix() - printed_formula(d, q).matrix()).norm(), 1e-13);
  }
}

TEST(SevenAxisRobot, IsSingularOnlyAtARightAngleOfC) {
  const SerialChain robot = seven_axis_robot();
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    Eigen::VectorXd q = random_joints(robot, random, 1.0);
    const Dexterity regular = dexterity(robot, q);
    EXPECT_EQ(regular.rank, 6);
    for (const double right : {90.0 * deg, -90.0 * deg}) {
      q[2] = right;
      EXPECT_EQ(dexterity(robot, q).rank, 5);
    }
  }
}

TEST(SevenAxisRobot, HasThePrintedStiffnessAtHome) {
  const SerialChain robot = seven_axis_robot();
  const auto ellipsoid = stiffness_ellipsoid(robot, Eigen::VectorXd::Zero(7));
  ASSERT_EQ(ellipsoid.stiffness.size(), 3u);
  EXPECT_NEAR(ellipsoid.stiffness[0] / n_per_mm, 65.0, 1e-9);
  EXPECT_NEAR(ellipsoid.stiffness[1] / n_per_mm, 72.0, 1e-9);
  EXPECT_NEAR(ellipsoid.stiffness[2] / n_per_mm, 271.0, 1e-9);
  EXPECT_NEAR(std::abs(ellipsoid.directions[2].x()), 1.0, 1e-9);
  // The slides turn with B and C: the same values, other directions.
  Eigen::VectorXd q = Eigen::VectorXd::Zero(7);
  q[1] = 0.5;
  q[2] = -0.4;
  const auto turned = stiffness_ellipsoid(robot, q);
  EXPECT_NEAR(turned.stiffness[2] / n_per_mm, 271.0, 1e-9);
  EXPECT_NEAR(std::abs(turned.directions[2].dot(forward(robot, q).linear().col(0))), 1.0, 1e-9);
}

TEST(SerialChain, JacobianIsTheFiniteDifference) {
  const SerialChain robot = seven_axis_robot();
  Random random(3);
  const double h = 1e-6;
  for (int i = 0; i < 100; ++i) {
    const Eigen::VectorXd q = random_joints(robot, random, 1.0);
    const auto columns = jacobian(robot, q);
    for (Eigen::Index k = 0; k < 7; ++k) {
      const Eigen::VectorXd d = h * Eigen::VectorXd::Unit(7, k);
      const Pose more = forward(robot, q + d);
      const Pose less = forward(robot, q - d);
      const Vector3 v = (more.translation() - less.translation()) / (2.0 * h);
      const Eigen::AngleAxisd turn(more.linear() * less.linear().transpose());
      const Vector3 w = turn.angle() * turn.axis() / (2.0 * h);
      // h²/6 of third derivatives of order 1 m, and rounding 1e-16/h.
      EXPECT_LT((columns.col(k).head<3>() - v).norm(), 1e-8);
      EXPECT_LT((columns.col(k).tail<3>() - w).norm(), 1e-8);
    }
  }
}

TEST(SerialChain, InverseReachesEveryPoseThatForwardGives) {
  const SerialChain robot = seven_axis_robot();
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    const Eigen::VectorXd q = random_joints(robot, random, 0.9);
    const Pose target = forward(robot, q);
    const InverseResult found = inverse(robot, target, Eigen::VectorXd::Zero(7));
    ASSERT_TRUE(found.converged) << i << ": " << found.reason;
    EXPECT_LT((forward(robot, found.q).matrix() - target.matrix()).norm(), 5e-6);
    EXPECT_GE(found.limit_distance, 0.0);
  }
}

TEST(SerialChain, ASpareJointKeepsTheOthersFromTheirLimits) {
  const SerialChain robot = seven_axis_robot();
  // Z and U are parallel at home: 150 mm along x may be shared, where U alone has 100 mm.
  Eigen::VectorXd q = Eigen::VectorXd::Zero(7);
  q[0] = 0.18;
  q[5] = -0.03;
  const InverseResult found = inverse(robot, forward(robot, q), q);
  ASSERT_TRUE(found.converged);
  EXPECT_NEAR(found.q[0] + found.q[5], 0.15, 1e-6);
  // Least (Z/200)² + (U/100)² with Z + U = 150: Z = 120, U = 30, and Z is 40 % from its limit.
  EXPECT_NEAR(found.limit_distance, 0.4, 1e-4);
}

TEST(SerialChain, SaysWhatItCannotReach) {
  const SerialChain robot = seven_axis_robot();
  Pose far = Pose::Identity();
  far.translation() = Vector3(2.0, 0.0, 0.0);
  const InverseResult found = inverse(robot, far, Eigen::VectorXd::Zero(7));
  EXPECT_FALSE(found.converged);
  EXPECT_NE(found.reason, "");
}

TEST(SerialChain, FromDenavitAndHartenbergIsTheProductOfTheirMatrices) {
  const std::vector<DhRow> rows = {{.name = "1", .a = 0.1, .alpha = 0.5, .d = 0.2, .theta = 0.3},
                                   {.name = "2", .prismatic = true, .a = -0.05, .alpha = -1.2},
                                   {.name = "3", .a = 0.02, .alpha = 1.5, .d = -0.1, .theta = 1.0}};
  const SerialChain chain = chain_from_dh(rows);
  const Eigen::Vector3d q(0.7, 0.08, -0.4);
  Pose product = Pose::Identity();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double turn = rows[i].theta + (rows[i].prismatic ? 0.0 : q[static_cast<int>(i)]);
    const double move = rows[i].d + (rows[i].prismatic ? q[static_cast<int>(i)] : 0.0);
    product = product * Eigen::AngleAxisd(turn, Vector3::UnitZ()) *
              Eigen::Translation3d(rows[i].a, 0.0, move) *
              Eigen::AngleAxisd(rows[i].alpha, Vector3::UnitX());
  }
  EXPECT_LT((forward(chain, q).matrix() - product.matrix()).norm(), 1e-13);
}

TEST(SerialChain, RefusesBadJoints) {
  EXPECT_THROW(check(SerialChain{}), InvalidInput);
  SerialChain robot = seven_axis_robot();
  robot.joints[2].direction *= 2.0;
  EXPECT_THROW(check(robot), InvalidInput);
  robot = seven_axis_robot();
  robot.joints[3].low = 1.0;
  EXPECT_THROW(check(robot), InvalidInput);
  robot = seven_axis_robot();
  robot.joints[3].compliance = -1.0;
  EXPECT_THROW(check(robot), InvalidInput);
  EXPECT_THROW(inverse(seven_axis_robot(), Pose::Identity(), Eigen::VectorXd::Zero(3)),
               InvalidInput);
}

}  // namespace
}  // namespace osteomill::robot
