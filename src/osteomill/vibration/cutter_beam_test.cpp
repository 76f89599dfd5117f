// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/vibration/cutter_beam.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/vibration/exact_beam.hpp"

namespace osteomill::vibration {
namespace {

cutting::Cutter mill() {
  cutting::Cutter cutter;
  cutter.radius = 1.55e-3;
  cutter.cutting_length = 35e-3;
  cutter.shank = cutting::Shank{.free_length = 55e-3,
                                .diameter = 3.1e-3,
                                .youngs_modulus = 197e9,
                                .density = 7850.0,
                                .effective_diameter_factor = 0.82};
  return cutter;
}

double tip_compliance(const Beam& beam) { return exact_tip_receptance(beam, 0.0); }

TEST(CutterBeam, BendsAsTwoCantileverPiecesInSeries) {
  // F l³/3EI of a stepped cantilever: the fluted part to 35 mm, the shank from there to 55 mm.
  const auto inertia = [](double d) { return std::numbers::pi / 64.0 * std::pow(d, 4); };
  const double flutes = inertia(0.82 * 3.1e-3);
  const double shank = inertia(3.1e-3);
  const double expected =
      (std::pow(35e-3, 3) / flutes + (std::pow(55e-3, 3) - std::pow(35e-3, 3)) / shank) /
      (3.0 * 197e9);
  EXPECT_NEAR(tip_compliance(beam_of(mill())), expected, 1e-6 * expected);
}

TEST(CutterBeam, GivesWayInItsHolderBySpringsInSeries) {
  cutting::Cutter cutter = mill();
  const double rigid = tip_compliance(beam_of(cutter));
  cutter.shank->holder_stiffness = 2e6;
  cutter.shank->holder_rotational_stiffness = 500.0;
  const double expected = rigid + 1.0 / 2e6 + 55e-3 * 55e-3 / 500.0;
  EXPECT_NEAR(tip_compliance(beam_of(cutter)), expected, 1e-6 * expected);
}

TEST(CutterBeam, HasOnePieceWhenItIsHeldAtTheEndOfItsEdges) {
  cutting::Cutter cutter = mill();
  cutter.shank->free_length = cutter.cutting_length;
  EXPECT_EQ(beam_of(cutter).segments.size(), 1u);
}

TEST(CutterBeam, RefusesWhatIsNoHeldCutter) {
  cutting::Cutter cutter = mill();
  cutter.shank.reset();
  EXPECT_THROW(beam_of(cutter), InvalidInput);
  const auto refused = [&](auto change) {
    cutting::Cutter wrong = mill();
    change(*wrong.shank);
    EXPECT_THROW(beam_of(wrong), InvalidInput);
  };
  refused([](cutting::Shank& s) { s.free_length = 34e-3; });
  refused([](cutting::Shank& s) { s.diameter = 0.0; });
  refused([](cutting::Shank& s) { s.youngs_modulus = 197e3; });  // MPa taken for Pa
  refused([](cutting::Shank& s) { s.density = 7.85; });          // g/cm³
  refused([](cutting::Shank& s) { s.effective_diameter_factor = 1.2; });
  refused([](cutting::Shank& s) { s.holder_stiffness = 1e6; });  // without the other
  refused([](cutting::Shank& s) { s.holder_stiffness = std::nan(""); });
}

}  // namespace
}  // namespace osteomill::vibration
