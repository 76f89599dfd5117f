// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/flutes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

constexpr double kPi = std::numbers::pi;

ProfilePoint upright() { return {1e-3, 3e-3, kPi / 2.0, 0.2, 0.0, 1.0}; }

TEST(Flutes, OfUnequalPitchCutInProportionToIt) {
  Cutter cutter{CutterShape::cylindrical, 3e-3, 3, 0.0, 0.0, 10e-3};
  cutter.pitch = {100.0 * units::deg, 120.0 * units::deg, 140.0 * units::deg};
  const Flutes flutes(cutter);
  EXPECT_FALSE(flutes.equal());
  // Flute 1 follows flute 0 by 100 degrees, flute 0 follows flute 2 by 140.
  EXPECT_NEAR(flutes.chip(1, upright(), 10e-6, 1.0), 30e-6 * 100.0 / 360.0, 1e-18);
  EXPECT_NEAR(flutes.chip(0, upright(), 10e-6, 1.0), 30e-6 * 140.0 / 360.0, 1e-18);
}

TEST(Flutes, ShareOneTurnsFeedWhateverTheRunOut) {
  Cutter cutter{CutterShape::cylindrical, 3e-3, 4, 0.0, 0.0, 10e-3};
  for (const double offset : {0.5e-6, 4e-6, 50e-6}) {
    cutter.run_out = {offset, 0.3, 1e-4, 1.0};
    const Flutes flutes(cutter);
    double sum = 0.0;
    for (int j = 0; j < 4; ++j) sum += std::max(0.0, flutes.chip(j, upright(), 5e-6, 0.8));
    // What one flute leaves another takes: a turn's feed in all.
    EXPECT_NEAR(sum, 4.0 * 5e-6 * 0.8, 1e-15) << offset;
  }
  cutter.run_out = {50e-6, 0.0, 0.0, 0.0};  // far more than the feed: one flute does it all
  ProfilePoint tip = upright();
  tip.lag = 0.0;
  const Flutes flutes(cutter);
  EXPECT_NEAR(flutes.chip(0, tip, 5e-6, 1.0), 20e-6, 1e-15);
  EXPECT_LE(flutes.chip(1, tip, 5e-6, 1.0), 0.0);
}

TEST(Flutes, OfATwoFlutedCutterWithRunOutDifferByTwiceTheOffset) {
  Cutter cutter{CutterShape::cylindrical, 3e-3, 2, 0.0, 0.0, 10e-3};
  cutter.run_out.offset = 2e-6;
  const Flutes flutes(cutter);
  ProfilePoint tip = upright();
  tip.lag = 0.0;
  EXPECT_NEAR(flutes.chip(0, tip, 10e-6, 1.0), 14e-6, 1e-15);
  EXPECT_NEAR(flutes.chip(1, tip, 10e-6, 1.0), 6e-6, 1e-15);
}

TEST(Flutes, HaveTheirChipInPiecesToo) {
  Cutter cutter{CutterShape::cylindrical, 3e-3, 4, 0.0, 0.0, 10e-3};
  cutter.radius_error = {0.0, 2e-6, -3e-6, 1e-6};
  cutter.pitch = {80.0 * units::deg, 95.0 * units::deg, 85.0 * units::deg, 100.0 * units::deg};
  for (const double offset : {0.0, 1e-6, 6e-6}) {
    cutter.run_out = {offset, 0.3, 1e-4, 1.0};
    const Flutes flutes(cutter);
    std::vector<double> deviations;
    for (int j = 0; j < 4; ++j) deviations.push_back(flutes.deviation(j, upright()));
    for (int j = 0; j < 4; ++j) {
      std::vector<Flutes::ChipPiece> pieces;
      flutes.chip_pieces(j, deviations, 1.0, 5e-6, pieces);
      for (double into = 0.005; into < 1.0; into += 0.01) {
        double h = 0.0;
        for (const auto& piece : pieces) {
          if (into >= piece.from) h = piece.rise * into + piece.start;
        }
        EXPECT_NEAR(h, std::max(0.0, flutes.chip(j, upright(), 5e-6, into)), 1e-18) << j;
      }
    }
  }
}

TEST(TrochoidalChip, SatisfiesItsOwnGeometry) {
  const double r = 3e-3;
  const double c = 0.3e-3;
  for (const double theta : {0.3, 1.2, 2.0, 2.9}) {
    const double h = trochoidal_chip(r, c, 2, theta);
    // The point at r - h on the ray lies on the path of the earlier tooth: find it by scanning the
    // tooth's own angle finely.
    const double a = c * 2.0 / (2.0 * kPi);
    double nearest = 1.0;
    for (double d = -0.2; d < 0.2; d += 1e-6) {
      const double x = -c + a * d + r * std::sin(theta + d);
      const double y = r * std::cos(theta + d);
      nearest = std::min(nearest,
                         std::hypot(x - (r - h) * std::sin(theta), y - (r - h) * std::cos(theta)));
    }
    EXPECT_LT(nearest, 1e-6 * r) << theta;  // step of the scan
  }
}

TEST(TrochoidalChip, TendsToMartellottisForSmallFeeds) {
  for (const double theta : {0.5, 1.5, 2.5}) {
    // The difference is of second order in c/r.
    EXPECT_NEAR(trochoidal_chip(3e-3, 1e-6, 2, theta) / (1e-6 * std::sin(theta)), 1.0, 1e-3);
  }
}

}  // namespace
}  // namespace osteomill::cutting
