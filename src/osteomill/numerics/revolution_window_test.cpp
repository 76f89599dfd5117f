// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/numerics/revolution_window.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace osteomill::numerics {
namespace {

constexpr double kSpeed = 6000.0 * 2.0 * std::numbers::pi / 60.0;  // 100 revolutions a second

TEST(RevolutionWindow, HoldsWholeRevolutions) {
  EXPECT_EQ(RevolutionWindow(kSpeed, 8000.0, 10e-3).size(), 80U);
  EXPECT_EQ(RevolutionWindow(kSpeed, 8000.0, 25e-3).size(), 160U);
  EXPECT_EQ(RevolutionWindow(kSpeed, 8000.0, 1e-3).size(), 80U) << "a revolution at least";
}

TEST(RevolutionWindow, SeesMeanAndLinesOfASignalWhateverItsPhase) {
  for (const double phase : {0.0, 0.7, 2.0}) {
    RevolutionWindow window(kSpeed, 8000.0, 10e-3);
    for (int i = 0; i < 203; ++i) {
      const double angle = kSpeed * i / 8000.0 + phase;
      window.add(5.0 + 3.0 * std::cos(2.0 * angle) + 0.5 * std::sin(angle));
    }
    // Rounding of 80 terms.
    EXPECT_NEAR(window.mean(), 5.0, 1e-12);
    EXPECT_NEAR(window.line(2), 3.0, 1e-12);
    EXPECT_NEAR(window.line(1), 0.5, 1e-12);
    EXPECT_NEAR(window.line(3), 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace osteomill::numerics
