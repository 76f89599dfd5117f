// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/local_gain.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/random.hpp"

namespace osteomill::identify {
namespace {

TEST(LocalGain, FollowsAStepByFourWithinFiveSamplesOfAHundredHertz) {
  int followed = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    GainEstimate estimate;
    for (int i = 0; i < 105; ++i) {
      const double gain = i < 100 ? 1000.0 : 4000.0;
      update(estimate, 4e-3, gain * 4e-3 * (1.0 + 0.05 * random.normal()), 0.01, {});
    }
    followed += std::abs(estimate.gain / 4000.0 - 1.0) <= 0.1;
  }
  EXPECT_GE(followed, 95);
}

}  // namespace
}  // namespace osteomill::identify
