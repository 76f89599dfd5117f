// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/tool_path.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::workpiece {
namespace {

const CutSettings kCut{3e-3, 628.0};

TEST(ToolPath, GivesThePointDirectionAndMoveAtAnArcLength) {
  Lines three;
  three.start_W = Vector3(1e-3, 2e-3, -1e-3);
  three.along_W = Vector3(30e-3, 0.0, 0.0);
  three.step_over_W = Vector3(0.0, 5e-3, 0.0);
  three.count = 3;
  const ToolPath path = zigzag(three, kCut);
  EXPECT_NEAR(path.length(), 3 * 30e-3 + 2 * 5e-3, 1e-15);
  const PathPoint point = path.at(30e-3 + 5e-3 + 10e-3);
  EXPECT_LT((point.position_W - Vector3(21e-3, 7e-3, -1e-3)).norm(), 1e-15);
  EXPECT_LT((point.direction_W + Vector3::UnitX()).norm(), 1e-15);
  EXPECT_EQ(point.move, 1u);
  EXPECT_EQ(path.moves()[point.move].line, 2);
  EXPECT_EQ(path.at(-1.0).position_W, three.start_W);
  EXPECT_LT((path.at(1.0).position_W - Vector3(31e-3, 12e-3, -1e-3)).norm(), 1e-15);
  EXPECT_THAT(path.corners_between(20e-3, 40e-3),
              testing::ElementsAre(testing::DoubleEq(30e-3), testing::DoubleEq(35e-3)));
  EXPECT_THAT(path.corners_between(30.1e-3, 34.9e-3), testing::IsEmpty());
}

TEST(ToolPath, LinesGoBackAboveTheBoneAsRapids) {
  Lines two;
  two.count = 2;
  const ToolPath path = lines(two, kCut);
  ASSERT_EQ(path.moves().size(), 3u);
  EXPECT_EQ(path.moves()[1].kind, MoveKind::rapid);
  EXPECT_EQ(path.moves()[2].points_W.front(), two.step_over_W);
  EXPECT_EQ(path.moves()[2].line, 2);
}

TEST(ToolPath, KeepsItsLengthWhenMovedRigidly) {
  const ToolPath path = line(Vector3::Zero(), Vector3(3e-3, 4e-3, 0.0), kCut);
  geometry::Pose X = geometry::Pose::Identity();
  X.rotate(Eigen::AngleAxisd(0.7, Vector3(1.0, 2.0, 3.0).normalized()))
      .pretranslate(Vector3(1, 2, 3));
  const ToolPath moved = transformed(path, X);
  EXPECT_NEAR(moved.length(), 5e-3, 1e-14);  // rounding of coordinates of a few metres
  EXPECT_EQ(moved.at(0.0).position_W, X * Vector3::Zero());
}

TEST(Arc, StaysWithinTheChordErrorAndEndsWhereItShould) {
  const Vector3 centre(1e-3, -2e-3, 4e-3);
  const auto points = arc(centre + Vector3(7e-3, 0.0, 0.0), centre, Vector3::UnitZ(),
                          1.5 * std::numbers::pi, 2e-3, 5e-6);
  EXPECT_LT((points.back() - (centre + Vector3(0.0, -7e-3, 2e-3))).norm(), 1e-15);
  double largest = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Vector3 middle = 0.5 * (points[i - 1] + points[i]) - centre;
    largest = std::max(largest, 7e-3 - std::hypot(middle.x(), middle.y()));
  }
  EXPECT_LE(largest, 5e-6);
  EXPECT_GT(largest, 1e-6) << "more points than needed";
}

TEST(ToolPath, RefusesWhatIsNoPath) {
  const auto with = [](Move move) { return ToolPath({std::move(move)}); };
  const Vector3 a = Vector3::Zero(), b = Vector3::UnitX();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ToolPath({}), InvalidInput);
  EXPECT_THROW(with({MoveKind::cut, {a}, 1.0, 1.0, 1}), InvalidInput);
  EXPECT_THROW(with({MoveKind::cut, {a, a}, 1.0, 1.0, 1}), InvalidInput);
  EXPECT_THROW(with({MoveKind::cut, {a, b}, 0.0, 1.0, 1}), InvalidInput);
  EXPECT_THROW(with({MoveKind::cut, {a, b}, -1.0, 1.0, 1}), InvalidInput);
  EXPECT_THROW(with({MoveKind::cut, {a, b}, 1.0, 0.0, 1}), InvalidInput);
  EXPECT_THROW(with({MoveKind::cut, {a, b}, nan, 1.0, 1}), InvalidInput);
  EXPECT_THROW(with({MoveKind::cut, {a, Vector3(nan, 0, 0)}, 1.0, 1.0, 1}), InvalidInput);
  const Move first{MoveKind::cut, {a, b}, 1.0, 1.0, 1};
  const Move elsewhere{MoveKind::cut, {a, b}, 1.0, 1.0, 2};
  EXPECT_THROW(ToolPath({first, elsewhere}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::workpiece
