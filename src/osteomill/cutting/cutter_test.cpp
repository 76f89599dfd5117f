// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/cutter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::cutting {
namespace {

Cutter ball() { return {CutterShape::ball, 4e-3, 2, 0.5, 0.0, 20e-3}; }

TEST(Cutter, BallIsASphereThenACylinder) {
  for (const double z : {0.0, 0.5e-3, 1e-3, 3.9e-3, 4e-3, 9e-3}) {
    const double kappa = axial_position_angle(ball(), z);
    const double r = radius_at(ball(), z);
    EXPECT_NEAR(r, 4e-3 * std::sin(kappa), 1e-15);
    EXPECT_NEAR(std::min(z, 4e-3), 4e-3 * (1.0 - std::cos(kappa)), 1e-15);
  }
}

TEST(Cutter, LagOfAConstantLeadBallFollowsTianAndMa) {
  const double z = 1.3e-3;
  EXPECT_NEAR(lag_angle(ball(), z),
              (1.0 - std::cos(axial_position_angle(ball(), z))) * std::tan(0.5), 1e-15);
}

TEST(Cutter, RefusesWhatIsNoCutter) {
  const auto broken = [](auto change) {
    Cutter cutter = ball();
    change(cutter);
    return cutter;
  };
  EXPECT_NO_THROW(check(ball()));
  EXPECT_THROW(check(broken([](Cutter& c) { c.radius = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) { c.radius = std::nan(""); })), InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) { c.flutes = 0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) { c.helix_angle = std::numbers::pi / 2.0; })),
               InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) { c.cutting_length = -1.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) { c.shape = CutterShape::bull; })), InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) {
                 c.shape = CutterShape::bull;
                 c.corner_radius = 5e-3;
               })),
               InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) { c.shape = CutterShape::profile; })), InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) {
                 c.shape = CutterShape::profile;
                 c.profile = {{1e-3, 0.0}, {2e-3, 1e-3}, {1e-3, 2e-3}};
               })),
               InvalidInput);
  const auto apt = [&](AptShape shape, double corner) {
    return broken([&](Cutter& c) {
      c.shape = CutterShape::apt;
      c.apt = shape;
      c.corner_radius = corner;
    });
  };
  EXPECT_NO_THROW(check(apt({8e-3, 2.5e-3, 1.5e-3, 0.0, 0.0}, 1.5e-3)));
  EXPECT_THROW(check(apt({8e-3, 2.5e-3, 1.5e-3, 0.0, 0.0}, 1.2e-3)), InvalidInput);  // too small
  EXPECT_THROW(check(apt({8e-3, 2.5e-3, 1.5e-3, 0.0, 0.1}, 1.5e-3)), InvalidInput);  // passes by
  EXPECT_THROW(check(apt({8e-3, 2.5e-3, 1.5e-3, -0.1, 0.0}, 1.5e-3)), InvalidInput);
  EXPECT_THROW(check(apt({9e-3, 3e-3, 1.5e-3, 0.0, 0.0}, 1.5e-3)), InvalidInput);  // radius is not
  EXPECT_THROW(check(broken([](Cutter& c) { c.pitch = {3.0, 3.0}; })), InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) { c.pitch = {6.0}; })), InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) { c.radius_error = {1e-6}; })), InvalidInput);
  EXPECT_THROW(check(broken([](Cutter& c) { c.run_out.offset = 3e-3; })), InvalidInput);
}

}  // namespace
}  // namespace osteomill::cutting
