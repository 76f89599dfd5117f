// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/finished_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::study {
namespace {

using units::mm;
constexpr double kCell = 0.2 * mm;

/// A surface z = height(x, y) of 40 x 40 mm over the plan z = 0, feed along x.
std::vector<SurfaceSample> surface(const std::function<double(double, double)>& height) {
  std::vector<SurfaceSample> samples;
  constexpr double e = 1e-7;
  for (double y = -20 * mm; y < 20 * mm; y += kCell)
    for (double x = -20 * mm; x < 20 * mm; x += kCell) {
      const Vector3 n(-(height(x + e, y) - height(x - e, y)) / (2 * e),
                      -(height(x, y + e) - height(x, y - e)) / (2 * e), 1.0);
      samples.push_back({{x, y, height(x, y)}, n.normalized(), height(x, y), Vector3::UnitZ()});
    }
  return samples;
}
FinishedSurfaceOptions options() {
  FinishedSurfaceOptions o;
  o.cell = kCell;
  return o;
}

TEST(FinishedSurface, OfALevelPlaneIsItsHeight) {
  const FinishedSurface s =
      measure_surface(surface([](double, double) { return 0.03 * mm; }), options());
  EXPECT_NEAR(s.mean, 0.03 * mm, 1e-12);
  EXPECT_NEAR(s.highest - s.lowest, 0.0, 1e-12);
  EXPECT_NEAR(s.area, 1600 * mm * mm, 0.02 * 1600 * mm * mm);  // a row of cells on each side
  EXPECT_NEAR(s.fit->flatness, 0.0, 1e-12);
  EXPECT_NEAR(s.along.ra + s.across.rz, 0.0, 1e-12);
  EXPECT_EQ(s.scallops.count, 0U);
}

TEST(FinishedSurface, FindsTheTwoAnglesOfATiltedPlane) {
  const double a = 0.7 * units::deg, b = -1.1 * units::deg;
  const FinishedSurface s = measure_surface(
      surface([&](double x, double y) { return x * std::tan(a) + y * std::tan(b); }), options());
  // Entry along +y as on a tibia with y forwards: F/E lifts the far edge, V/V one side.
  const Eigen::Matrix3d R = guide_frame(Vector3::UnitZ(), Vector3::UnitY());
  const CutError error = cut_error(R, s.fit->normal, {true});
  // Height falls by tan(b) a metre of y: it rises away from the entry.
  EXPECT_NEAR(error.flexion_extension, -b, 2e-4 * units::deg);
  EXPECT_NEAR(std::abs(error.varus_valgus), a, 2e-4 * units::deg);
  EXPECT_NEAR(s.fit->flatness, 0.0, 1e-9);
  // The mean line takes the tilt away.
  EXPECT_NEAR(s.along.rz, 0.0, 1e-9);
}

TEST(FinishedSurface, OfAWaveHasTheRoughnessOfAWaveAcrossAndNoneAlong) {
  const double amplitude = 20e-6, period = 2 * mm;
  const FinishedSurface s =
      measure_surface(surface([&](double, double y) {
                        return amplitude * std::sin(2 * std::numbers::pi * y / period);
                      }),
                      options());
  // Ten places a period: the crest is missed by 18° at most, 5 %. The line through m whole periods
  // of a sine falls by 3/(pi m) of the amplitude from its middle to its end, and by (1 - 3/2m) of
  // that to the second crest from the end, which so stands higher.
  const double periods = 4;
  const double rise = 3 / (std::numbers::pi * periods) * (1 - 1.5 / periods);
  EXPECT_NEAR(s.across.ra, 2 / std::numbers::pi * amplitude, 0.05 * amplitude);
  EXPECT_NEAR(s.across.rz, 2 * amplitude * (1 + rise), 0.05 * 2.3 * amplitude);
  EXPECT_GT(s.across.lengths, 500U);
  EXPECT_NEAR(s.along.rz, 0.0, 1e-12);
  EXPECT_NEAR(s.scallops.spacing, period, 1e-9);
  EXPECT_NEAR(s.scallops.mean, 2 * amplitude, 0.1 * amplitude);
}

TEST(FinishedSurface, FindsTheScallopsOfABall) {
  const double r = 4 * mm;
  for (const double s : {1.4 * mm, 2.0 * mm, 3.1 * mm}) {
    const FinishedSurface found = measure_surface(surface([&](double, double y) {
                                                    const double off = y - s * std::round(y / s);
                                                    return r - std::sqrt(r * r - off * off);
                                                  }),
                                                  options());
    const double expected = ball_scallop(r, s);
    // Continued parabolas instead of circles over half a cell: 1 %; valleys by the lowest cell lie
    // (cell/2)²/2r = 1.3 µm too high at most.
    EXPECT_NEAR(found.scallops.mean, expected, 0.01 * expected + 1.3e-6) << s / mm;
    EXPECT_NEAR(found.scallops.spacing, s, kCell) << s / mm;
  }
}

TEST(FinishedSurface, LeavesOutLedgesWallsAndCountsThem) {
  std::vector<SurfaceSample> samples =
      surface([](double x, double) { return x > 15 * mm ? 4 * mm : 0.0; });
  const FinishedSurface s = measure_surface(samples, options());
  EXPECT_NEAR(s.area, 1400 * mm * mm, 20 * mm * mm);
  EXPECT_NEAR(s.beyond_area, 200 * mm * mm, 20 * mm * mm);
  EXPECT_LT(s.highest, 1e-9);
}

TEST(FinishedSurface, RefusesASurfaceThatIsNowhereNearThePlan) {
  EXPECT_THROW(measure_surface(surface([](double, double) { return 5 * mm; }), options()),
               InvalidInput);
  FinishedSurfaceOptions o = options();
  o.feed = o.normal;
  EXPECT_THROW(measure_surface(surface([](double, double) { return 0.0; }), o), InvalidInput);
}

TEST(FinishedSurface, TheRidgeOfABallIsTheKnownFormula) {
  EXPECT_NEAR(ball_scallop(4 * mm, 2 * mm), (4 - std::sqrt(15.0)) * mm, 1e-15);
  EXPECT_NEAR(ball_scallop(4 * mm, 20 * mm), 4 * mm, 1e-15);  // passes that do not meet
}

}  // namespace
}  // namespace osteomill::study
