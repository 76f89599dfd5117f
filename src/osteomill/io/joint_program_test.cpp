// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/joint_program.hpp"

#include <gmock/gmock.h>

#include <sstream>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/workpiece/tool_pose.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using testing::HasSubstr;
using testing::Not;

/// The work below the point in which the rotary axes meet.
CarryingRobot robot_over(const Vector3& work_B) {
  robot::SevenAxisDimensions dimensions;
  dimensions.c5 = 0.0;
  dimensions.g9.setZero();
  CarryingRobot robot{robot::seven_axis_robot(dimensions)};
  robot.X_BW.translation() = work_B;
  return robot;
}

/// 30 mm of the tip, while the tool leans over from -15 to 25 degrees, and a straight line after
/// it.
std::vector<MachineMove> leaning() {
  const auto axis = [](double angle) { return Vector3(std::sin(angle), 0.0, std::cos(angle)); };
  const Vector3 a(-15e-3, 0.0, 0.0);
  const Vector3 b(15e-3, 0.0, 2e-3);
  const Vector3 c(15e-3, 20e-3, 2e-3);
  const Vector3 from = axis(-15 * units::deg);
  const Vector3 to = axis(25 * units::deg);
  const double length = (b - a).norm();
  return {{a, a, 0.0, 0.0, false, false, from, from},
          {a, b, 0.0, length, true, false, from, to},
          {b, c, length, length + 20e-3, true, false, to, to}};
}

TEST(JointProgram, KeepsTheTipOnThePathAndTheToolInItsAxisBetweenTheValuesOfTheJoints) {
  const CarryingRobot robot = robot_over({0.0, 0.3, 0.0});
  const std::vector<MachineMove> path = leaning();
  const std::vector<JointMove> moves = joint_program(robot, path, 12e-3);
  double time = 0.0;
  double position = 0.0;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    ASSERT_TRUE(moves[i].cut);
    EXPECT_EQ(moves[i].q[0], moves.front().q[0]) << "the first slide stands";
    const double way = moves[i].time * 12e-3;
    for (int k = 1; k <= 8; ++k) {
      const double part = k / 8.0;
      const geometry::Pose X_WT =
          robot.tool_in_work(moves[i - 1].q + part * (moves[i].q - moves[i - 1].q));
      const double there = position + part * way;
      const MachineMove& move = path[there <= path[1].to + 1e-9 ? 1 : 2];
      const double share = std::min(1.0, (there - move.from) / (move.to - move.from));
      const workpiece::ToolPose tool = workpiece::between({move.start_W, move.axis_start_W},
                                                          {move.end_W, move.axis_end_W}, share);
      // The chords' 5 um, and the axis turns as evenly as the joints do.
      EXPECT_LT((X_WT.translation() - tool.tip_W).norm(), 5.5e-6);
      EXPECT_LT(workpiece::angle_between(X_WT.linear().col(2), tool.axis_W), 0.01 * units::deg);
    }
    time += moves[i].time;
    position += way;
  }
  EXPECT_NEAR(time, path.back().to / 12e-3, 1e-12) << "the tip's feed is the full feed";
}

TEST(JointProgram, StopsAtACornerAndAtTheEndAndNowhereElse) {
  const CarryingRobot robot = robot_over({0.0, 0.3, 0.0});
  const std::vector<MachineMove> path = leaning();
  const std::vector<JointMove> moves = joint_program(robot, path, 12e-3);
  std::vector<Vector3> stops;
  for (const JointMove& move : moves) {
    if (move.stop && move.cut) stops.push_back(robot.tool_in_work(move.q).translation());
  }
  ASSERT_EQ(stops.size(), 2U);
  // The inverse is exact to 0.1 um.
  EXPECT_LT((stops[0] - path[1].end_W).norm(), 0.2e-6);
  EXPECT_LT((stops[1] - path[2].end_W).norm(), 0.2e-6);
}

TEST(JointProgram, IsWrittenInInverseTimeWithTheAxesOfTheRobot) {
  const CarryingRobot robot = robot_over({0.0, 0.3, 0.0});
  const std::vector<JointMove> moves = joint_program(robot, leaning(), 12e-3);
  const std::string text = gcode_of(robot, moves, 6000 * units::rpm);
  EXPECT_THAT(text, HasSubstr("G93"));
  EXPECT_THAT(text, HasSubstr("M52 P1"));
  EXPECT_THAT(text, HasSubstr("S6000.000 M3"));
  EXPECT_THAT(text, Not(HasSubstr(" X")));
  // The last cut again, from its line: the joints in mm and degrees, and 1/F in minutes.
  std::istringstream lines(text);
  std::string line;
  std::string last;
  while (std::getline(lines, line)) {
    if (line.rfind("G1 ", 0) == 0) last = line;
  }
  Eigen::VectorXd q(7);
  double inverse = 0.0;
  ASSERT_EQ(std::sscanf(last.c_str(), "G1 Z%lf B%lf C%lf W%lf V%lf U%lf A%lf F%lf", &q[0], &q[1],
                        &q[2], &q[3], &q[4], &q[5], &q[6], &inverse),
            8)
      << last;
  for (const int turning : {1, 2, 6}) q[turning] *= units::deg;
  for (const int sliding : {0, 3, 4, 5}) q[sliding] *= units::mm;
  EXPECT_NEAR(60.0 / inverse, moves.back().time, 1e-6);
  // Seven digits behind the point: 1e-7 degrees are 1 nm at half a metre.
  EXPECT_LT((robot.tool_in_work(q).translation() - leaning().back().end_W).norm(), 0.2e-6);
}

TEST(JointProgram, NamesThePlaceThatIsOutOfReach) {
  const CarryingRobot robot = robot_over({0.0, 0.9, 0.0});
  try {
    joint_program(robot, leaning(), 12e-3);
    FAIL() << "0.6 m beside the robot's work";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("robot.work"));
    EXPECT_THAT(error.what(), HasSubstr("mm along the path"));
    EXPECT_THAT(error.what(), HasSubstr("no joint values within the limits"));
  }
}

}  // namespace
}  // namespace osteomill::io
