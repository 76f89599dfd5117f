// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/machine_path.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "osteomill/io/gcode.hpp"

namespace osteomill::io {
namespace {

using geometry::Vector3;
using testing::HasSubstr;

simulate::LineProfileWorkpiece three_lines() {
  simulate::LineProfile profile;
  profile.zones = {{0.0, 66e-3, 3800.0, {}, {}}};
  return simulate::LineProfileWorkpiece(profile);
}

TEST(MachinePath, CutsEveryLineOnceAndTouchesNothingBetween) {
  const simulate::LineProfileWorkpiece workpiece = three_lines();
  double cut = 0.0;
  Vector3 at = Vector3::Zero();
  bool first = true;
  for (const MachineMove& move : machine_path(workpiece, 5e-3)) {
    if (!first) {
      EXPECT_LT((move.start_W - at).norm(), 1e-12) << "moves join";
    }
    first = false;
    at = move.end_W;
    const double length = (move.end_W - move.start_W).norm();
    EXPECT_NEAR(move.to - move.from, move.cut ? length : 0.0, 1e-12);
    if (move.cut) cut += length;
    // The wall is at y = 0 in W; on the way back the tool is further from it.
    if (std::abs(move.end_W.x() - move.start_W.x()) > 1e-3 && !move.cut) {
      EXPECT_LT(move.end_W.y(), workpiece.at(0.0).tip_W.y() - 4e-3);
    }
  }
  EXPECT_NEAR(cut, workpiece.length(), 1e-12);
}

TEST(MachinePath, AFollowerKnowsThePlaceOnEveryLine) {
  const simulate::LineProfileWorkpiece workpiece = three_lines();
  const std::vector<MachineMove> path = machine_path(workpiece, 5e-3);
  PathFollower follower(path);
  PathFollower::Place place = follower.update(Vector3(0.1, -0.2, 0.3));
  EXPECT_FALSE(place.cut) << "on the approach";
  double travelled = 0.0;  // within cuts
  for (const MachineMove& move : path) {
    const double length = (move.end_W - move.start_W).norm();
    // Steps that do not divide the move, as servo cycles do not; a point is reached from 1 um on.
    for (double s = 0.137e-3; s < length - 1e-6; s += 0.137e-3) {
      place = follower.update(move.start_W + s / length * (move.end_W - move.start_W));
      EXPECT_EQ(place.cut, move.cut);
      // Rounding of a place 0.3 m along the path.
      EXPECT_NEAR(place.position, travelled + (move.cut ? s : 0.0), 1e-12);
    }
    place = follower.update(move.end_W);
    if (move.cut) travelled += length;
  }
  EXPECT_TRUE(place.finished);
}

TEST(MachinePath, AFollowerGoesOnWhenNoCycleHitsACorner) {
  PathFollower follower({{Vector3::Zero(), Vector3::Zero(), 0, 0, false},
                         {Vector3::Zero(), Vector3(0.01, 0, 0), 0, 0.01, true},
                         {Vector3(0.01, 0, 0), Vector3(0.01, 0.01, 0), 0.01, 0.02, true}});
  follower.update(Vector3::Zero());
  EXPECT_NEAR(follower.update(Vector3(0.00995, 0, 0)).position, 0.00995, 1e-12);
  EXPECT_NEAR(follower.update(Vector3(0.01, 0.00005, 0)).position, 0.01005, 1e-12);
}

TEST(MachinePath, AFollowerGoesOnInTheMiddleOfALineAfterAStop) {
  const simulate::LineProfileWorkpiece workpiece = three_lines();
  PathFollower follower(machine_path(workpiece, 5e-3));
  const double there = workpiece.length() / 2.0;
  const PathFollower::Place place = follower.update(workpiece.at(there).tip_W);
  EXPECT_TRUE(place.cut);
  EXPECT_NEAR(place.position, there, 1e-12);
}

TEST(MachinePath, TheProgramAsksForAdaptiveFeedAndCutsAtFullFeed) {
  const simulate::LineProfileWorkpiece workpiece = three_lines();
  const std::string program = gcode_of(machine_path(workpiece, 5e-3), 12e-3, 628.3185307);
  EXPECT_THAT(program, HasSubstr("M52 P1\n"));
  EXPECT_THAT(program, HasSubstr("S6000.000 M3\n"));
  EXPECT_THAT(program, HasSubstr("G1 X76.350000 Y-3.000000 Z-5.000000 F720.000000\n"));
  EXPECT_THAT(program, testing::EndsWith("M2\n"));
}

TEST(MachinePath, OfAToolPathGoesUpBeforeItGoesAcrossAndThenAlongAllOfIt) {
  const workpiece::CutSettings cut{3e-3, 100.0};
  const workpiece::ToolPath path = workpiece::lines(
      {Vector3(-10e-3, 2e-3, -1e-3), Vector3(20e-3, 0, 0), Vector3(0, 1e-3, 0), 2, 5e-3}, cut);
  const std::vector<MachineMove> moves = machine_path(path, 2e-3);
  PathFollower follower(moves);
  Vector3 at(3e-3, -4e-3, 0.0);  // where the machine is found
  EXPECT_EQ(follower.update(at).position, 0.0);
  const double top = 4e-3 + 2e-3;  // the way back between the lines, and the clearance
  const auto go = [&](const Vector3& to) {
    PathFollower::Place place;
    for (int i = 1; i <= 50; ++i) place = follower.update(at + (to - at) * (i / 50.0));
    at = to;
    return place;
  };
  EXPECT_FALSE(go(Vector3(at.x(), at.y(), top)).cut);
  EXPECT_FALSE(go(Vector3(-10e-3, 2e-3, top)).cut);
  EXPECT_EQ(go(Vector3(-10e-3, 2e-3, -1e-3)).position, 0.0);
  double length = 0.0;
  for (const workpiece::Move& move : path.moves()) {
    for (std::size_t i = 1; i < move.points_W.size(); ++i) {
      length += (move.points_W[i] - move.points_W[i - 1]).norm();
      const PathFollower::Place place = go(move.points_W[i]);
      EXPECT_NEAR(place.position, length, 1e-9);
      EXPECT_TRUE(place.cut);
    }
  }
  EXPECT_NEAR(length, path.length(), 1e-12);
  EXPECT_TRUE(follower.update(at).finished);
  EXPECT_THAT(gcode_of(moves, 8e-3, 100.0), HasSubstr("G0 Z6.000000\nG0 X-10.000000 Y2.000000"));
}

}  // namespace
}  // namespace osteomill::io
