// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/workpiece/meridian.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::workpiece {
namespace {

cutting::Cutter of(cutting::CutterShape shape) {
  cutting::Cutter cutter;
  cutter.shape = shape;
  cutter.radius = 4.0;
  cutter.cutting_length = 10.0;
  cutter.corner_radius = 1.0;
  cutter.taper_angle = 0.3;
  cutter.profile = {{1.0, 0.0}, {3.0, 1.0}, {4.0, 4.0}};
  if (shape == cutting::CutterShape::apt) {
    // A corner that touches its bottom line at 0.3 rad and crosses a leaning side.
    cutter.apt = {7.0, 2.6, 2.6 * std::tan(0.3) + 1.0 / std::cos(0.3), 0.3, 0.1};
    cutter.radius = cutting::apt_joints(cutter.apt, 1.0, 10.0).top_radius;
  }
  return cutter;
}

TEST(Meridian, IsZeroOnTheEnvelopeWithUnitSlopeAcrossIt) {
  using enum cutting::CutterShape;
  for (const auto shape : {cylindrical, ball, bull, tapered, profile, apt}) {
    const cutting::Cutter cutter = of(shape);
    const Meridian meridian(cutter);
    for (double z = 0.05; z < 9.0; z += 0.173) {
      const double r = cutting::radius_at(cutter, z);
      const double kappa = cutting::axial_position_angle(cutter, z);
      EXPECT_NEAR(meridian.distance(r, z), 0.0, 1e-9) << static_cast<int>(shape) << " " << z;
      const double out = 1e-3;  // small against the distance between joints of the outline
      EXPECT_NEAR(meridian.distance(r + out * std::sin(kappa), z - out * std::cos(kappa)), out,
                  1e-6)
          << static_cast<int>(shape) << " " << z;
    }
  }
}

TEST(Meridian, SectionsAreWhereTheDistanceIs) {
  using enum cutting::CutterShape;
  for (const auto shape : {cylindrical, ball, bull, tapered, profile, apt}) {
    const Meridian meridian(of(shape));
    for (double z = -0.4; z < 9.0; z += 0.173)
      for (const double offset : {-0.5, 0.5}) {
        const double r = meridian.section_radius(z, offset);
        if (r >= 0.0) {
          EXPECT_LE(meridian.distance(0.999 * r, z), offset + 1e-9);
          EXPECT_GE(meridian.distance(1.001 * r + 1e-3, z), offset);
        } else {
          EXPECT_GT(meridian.distance(0.0, z), offset - 1e-9);
        }
      }
  }
}

TEST(Meridian, OfABullWithAFullCornerIsABall) {
  cutting::Cutter bull = of(cutting::CutterShape::bull);
  bull.corner_radius = 4.0;
  const Meridian rounded(bull), ball(of(cutting::CutterShape::ball));
  for (double z = -1.0; z < 8.0; z += 0.31)
    for (double r = 0.0; r < 6.0; r += 0.29)
      EXPECT_NEAR(rounded.distance(r, z), ball.distance(r, z), 1e-12);
}

TEST(Meridian, RefusesAHollowOutline) {
  cutting::Cutter hollow = of(cutting::CutterShape::profile);
  hollow.profile = {{1.0, 0.0}, {1.5, 3.0}, {4.0, 4.0}};
  EXPECT_THROW(Meridian{hollow}, InvalidInput);
  hollow.profile = {{1.0, 0.0}, {3.0, 3.0}};  // a step to the shank
  EXPECT_THROW(Meridian{hollow}, InvalidInput);
}

}  // namespace
}  // namespace osteomill::workpiece
