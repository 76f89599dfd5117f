// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <vector>

#include "osteomill/simulate/line_profile.hpp"
#include "osteomill/simulate/milling.hpp"

namespace osteomill::simulate {
namespace {

// A machine that moves as the simulated one does meets the same bone, in whatever pieces its motion
// is told.
TEST(Milling, AMotionThatIsFollowedInPiecesGivesTheForcesOfTheSameMotionSimulated) {
  LineProfile profile;
  profile.zones = {{0.0, 66e-3, 3800.0, {}, {}}, {5e-3, 61e-3, 450.0, {}, {2, 3}}};
  Machine machine;
  machine.spindle_speed = 628.3185307179586;
  LineProfileWorkpiece bone(profile), same_bone(profile);
  Milling simulated(bone, machine, 30.0), followed(same_bone, machine, 30.0);
  double position = 0.0;
  // Within the first line, so that no line's end falls into a period.
  for (int period = 0; period < 500; ++period) {
    const double feed = period < 100 ? 3e-3 : 12e-3;
    const Report wanted = simulated.advance({feed, 0, false});
    for (int piece = 0; piece < 10; ++piece) {
      std::vector<double> positions, feeds(8, feed);
      for (int i = 0; i < 8; ++i) positions.push_back(position += feed / 8000.0);
      followed.follow(positions, feeds);
    }
    const Report seen = followed.end_period({feed, 0, false});
    ASSERT_NEAR(seen.position, wanted.position, 1e-12);
    // The place is the same but for rounding, and the profile's table has steps of 2 um: a sample
    // may fall on the other side of one.
    ASSERT_NEAR(seen.mean_force, wanted.mean_force, 1e-3 * (1.0 + wanted.mean_force));
    ASSERT_NEAR(followed.steps().back().feed_work, simulated.steps().back().feed_work,
                1e-3 * (1e-6 + simulated.steps().back().feed_work));
    ASSERT_EQ(followed.steps().back().line, simulated.steps().back().line);
    if (wanted.position > 60e-3) break;
  }
}

}  // namespace
}  // namespace osteomill::simulate
