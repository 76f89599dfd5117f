// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/online_track.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"

namespace osteomill::identify {
namespace {

/// Air, bone of strength 0.5, bone of strength 2, at feeds that change, 4 N/(mm/s) at strength 1.
std::vector<OnlinePeriod> recording() {
  Random random(5);
  std::vector<OnlinePeriod> periods;
  for (int i = 1; i <= 600; ++i) {
    const double strength = i <= 100 ? 0.0 : i <= 300 ? 0.5 : 2.0;
    const double feed = 4e-3 + 1e-3 * std::sin(0.05 * i);
    const double force = strength * 4e3 * feed * (1.0 + 0.03 * random.normal());
    periods.push_back({0.01 * i, feed, force + 0.2 * random.normal()});
  }
  return periods;
}

TEST(OnlineTrack, TellsAirFromBoneAndOneBoneFromAnother) {
  for (const OnlineMethod method :
       {OnlineMethod::kalman, OnlineMethod::least_squares, OnlineMethod::gain_slope}) {
    TrackOptions options;
    options.method = method;
    const OnlineTrack track = follow(recording(), FeedResponse(4e3), options);
    EXPECT_EQ(track.periods_in_bone, 500);
    EXPECT_FALSE(track.in_bone[99]);
    EXPECT_TRUE(track.in_bone[100]);
    // Noise of 3 % and 0.2 N of 8 N, averaged over a few samples.
    EXPECT_NEAR(track.estimates[290].strength, 0.5, 0.06) << static_cast<int>(method);
    EXPECT_NEAR(track.estimates[590].strength, 2.0, 0.2) << static_cast<int>(method);
    EXPECT_NEAR(track.median, 2.0, 0.1);
    EXPECT_NEAR(track.low, 0.5, 0.06);
  }
}

TEST(OnlineTrack, RefusesWhatIsNoRecording) {
  const FeedResponse response(4e3);
  EXPECT_THROW(follow({}, response, {}), InvalidInput);
  EXPECT_THROW(follow({{0.02, 1e-3, 1.0}, {0.01, 1e-3, 1.0}}, response, {}), InvalidInput);
  TrackOptions power;
  power.measure = OnlineMeasure::power;
  power.method = OnlineMethod::gain_slope;
  EXPECT_THROW(follow(recording(), response, power), InvalidInput);
}

}  // namespace
}  // namespace osteomill::identify
