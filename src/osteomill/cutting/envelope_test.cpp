// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/envelope.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

constexpr double kPi = std::numbers::pi;

Cutter of(CutterShape shape) {
  Cutter cutter{shape, 4e-3, 2, 0.5, 0.0, 20e-3};
  cutter.corner_radius = 1.5e-3;
  cutter.taper_angle = 7.0 * units::deg;
  cutter.profile = {{1e-3, 0.0}, {2e-3, 1e-3}, {2.5e-3, 4e-3}, {4e-3, 4.5e-3}};
  if (shape == CutterShape::apt) {
    // A corner that touches a bottom line at 20 degrees and crosses a side line at 5 degrees.
    const double bottom = 20.0 * units::deg;
    cutter.apt = {7e-3, 2.2e-3, 2.2e-3 * std::tan(bottom) + 1.5e-3 / std::cos(bottom), bottom,
                  5.0 * units::deg};
    cutter.radius = apt_joints(cutter.apt, cutter.corner_radius, cutter.cutting_length).top_radius;
  }
  return cutter;
}

const CutterShape kShapes[] = {CutterShape::cylindrical, CutterShape::ball,    CutterShape::bull,
                               CutterShape::tapered,     CutterShape::profile, CutterShape::apt};

TEST(Envelope, RunsAlongItsOwnNormal) {
  for (const CutterShape shape : kShapes) {
    for (const Lead lead : {Lead::constant_lead, Lead::constant_angle}) {
      Cutter cutter = of(shape);
      cutter.lead = lead;
      const Envelope envelope(cutter);
      const double ds = 1e-9;
      for (double s = 0.05e-3; s < 12e-3; s += 0.37e-3) {
        const ProfilePoint low = envelope.at(s - ds);
        const ProfilePoint mid = envelope.at(s);
        const ProfilePoint high = envelope.at(s + ds);
        // Central differences over 1 nm: rounding of lengths of 1 cm.
        EXPECT_NEAR((high.radius - low.radius) / (2.0 * ds), std::cos(mid.kappa), 1e-6);
        EXPECT_NEAR((high.z - low.z) / (2.0 * ds), std::sin(mid.kappa), 1e-6);
        EXPECT_NEAR(mid.radius * (high.lag - low.lag) / (2.0 * ds), std::tan(mid.inclination),
                    1e-5);
        EXPECT_NEAR(mid.stretch, 1.0 / std::cos(mid.inclination), 1e-12);
        EXPECT_NEAR(envelope.length_to(mid.z), s, 1e-9);
      }
    }
  }
}

TEST(Envelope, AgreesWithRadiusAndAngleByHeight) {
  for (const CutterShape shape : kShapes) {
    const Cutter cutter = of(shape);
    const Envelope envelope(cutter);
    for (double z = 0.01e-3; z < 15e-3; z += 0.31e-3) {
      const ProfilePoint point = envelope.at(envelope.length_to(z));
      EXPECT_NEAR(point.z, z, 1e-12);
      EXPECT_NEAR(point.radius, radius_at(cutter, z), 1e-12);
      EXPECT_NEAR(point.kappa, axial_position_angle(cutter, z), 1e-6);
      EXPECT_NEAR(point.lag, lag_angle(cutter, z), 1e-12);
    }
  }
}

TEST(Envelope, OfAConstantAngleHasThatAngleOnEveryStraightPart) {
  Cutter cutter = of(CutterShape::profile);
  cutter.lead = Lead::constant_angle;
  const Envelope envelope(cutter);
  for (const double z : {0.5e-3, 2e-3, 4.2e-3, 9e-3}) {
    EXPECT_NEAR(envelope.at(envelope.length_to(z)).inclination, cutter.helix_angle, 1e-12);
  }
}

TEST(Envelope, OfALimitingCaseIsTheSimplerShape) {
  Cutter bull = of(CutterShape::bull);
  bull.corner_radius = bull.radius;
  Cutter taper = of(CutterShape::tapered);
  taper.corner_radius = taper.radius;
  taper.taper_angle = 0.0;
  const Envelope ball(of(CutterShape::ball));
  for (double s = 0.0; s < 10e-3; s += 0.5e-3) {
    for (const Cutter& cutter : {bull, taper}) {
      const ProfilePoint point = Envelope(cutter).at(s);
      EXPECT_NEAR(point.radius, ball.at(s).radius, 1e-12);
      EXPECT_NEAR(point.kappa, ball.at(s).kappa, 1e-12);
      EXPECT_NEAR(point.lag, ball.at(s).lag, 1e-12);
    }
  }
  const auto is_as = [](const Cutter& one, const Cutter& other) {
    check(one);
    for (double s = 0.0; s < 18e-3; s += 0.5e-3) {
      const ProfilePoint a = Envelope(one).at(s), b = Envelope(other).at(s);
      EXPECT_NEAR(a.radius, b.radius, 1e-12) << s;
      EXPECT_NEAR(a.z, b.z, 1e-12);
      EXPECT_NEAR(a.kappa, b.kappa, 1e-7);  // the root of a rounded zero in the tangent's chord
      EXPECT_NEAR(a.lag, b.lag, 1e-9);
    }
  };
  Cutter apt = of(CutterShape::cylindrical);
  apt.shape = CutterShape::apt;
  apt.corner_radius = 0.0;
  apt.apt = {8e-3, 4e-3, 0.0, 0.0, 0.0};
  is_as(apt, of(CutterShape::cylindrical));
  apt.corner_radius = 4e-3;
  apt.apt = {8e-3, 0.0, 4e-3, 0.0, 0.0};
  is_as(apt, of(CutterShape::ball));
  apt.corner_radius = 1.5e-3;
  apt.apt = {8e-3, 2.5e-3, 1.5e-3, 0.0, 0.0};
  is_as(apt, of(CutterShape::bull));
  EXPECT_NEAR(Envelope(of(CutterShape::tapered)).at(1.5e-3 * (kPi / 2.0 - 7.0 * units::deg)).kappa,
              83.0 * units::deg, 1e-12);
}

TEST(Envelope, KnowsWhereARadiusAndAnAngleAre) {
  for (const CutterShape shape : kShapes) {
    const Envelope envelope(of(shape));
    for (const double s : {0.4e-3, 1.3e-3, 2.9e-3}) {
      const ProfilePoint point = envelope.at(s);
      bool found_radius = envelope.is_cylinder(s), found_kappa = false;
      for (const double at : envelope.where_radius_is(point.radius)) {
        EXPECT_NEAR(envelope.at(at).radius, point.radius, 1e-15);
        found_radius = found_radius || std::abs(at - s) < 1e-9;
      }
      for (const double at : envelope.where_kappa_is(point.kappa)) {
        EXPECT_NEAR(envelope.at(at).kappa, point.kappa, 1e-12);
        found_kappa = found_kappa || std::abs(at - s) < 1e-9;
      }
      EXPECT_TRUE(found_radius) << static_cast<int>(shape) << " " << s;
      EXPECT_EQ(found_kappa, envelope.at(s + 1e-6).kappa != point.kappa) << s;
    }
  }
}

}  // namespace
}  // namespace osteomill::cutting
