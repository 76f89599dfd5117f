// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/base/random.hpp"

#include <gtest/gtest.h>

namespace osteomill {
namespace {

TEST(Random, DependsOnSeedAndStreamAlone) {
  Random one(7, 3);
  Random other(7, 3);
  Random next_stream(7, 4);
  Random next_seed(8, 3);
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t value = one.bits();
    EXPECT_EQ(value, other.bits());
    EXPECT_NE(value, next_stream.bits());
    EXPECT_NE(value, next_seed.bits());
  }
}

TEST(Random, HasTheMomentsOfItsDistributions) {
  Random random(1);
  const int count = 200000;
  double sum = 0.0;
  double sum_normal = 0.0;
  double squares = 0.0;
  double fourths = 0.0;
  for (int i = 0; i < count; ++i) {
    const double u = random.uniform();
    ASSERT_GT(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    const double z = random.normal();
    sum_normal += z;
    squares += z * z;
    fourths += z * z * z * z;
  }
  // Five standard errors of each mean; variances 1/12, 1, 2 and 96 (the seed is fixed).
  EXPECT_NEAR(sum / count, 0.5, 5.0 * std::sqrt(1.0 / 12.0 / count));
  EXPECT_NEAR(sum_normal / count, 0.0, 5.0 * std::sqrt(1.0 / count));
  EXPECT_NEAR(squares / count, 1.0, 5.0 * std::sqrt(2.0 / count));
  EXPECT_NEAR(fourths / count, 3.0, 5.0 * std::sqrt(96.0 / count));
}

}  // namespace
}  // namespace osteomill
