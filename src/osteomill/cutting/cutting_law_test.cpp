// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/cutting_law.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

CuttingLaw power() {
  CuttingLaw law;
  law.tangential = {PowerLaw{71e3, 0.684, 1e3}, PowerLaw{63e3, 0.569, 2e3}};
  law.radial = {PowerLaw{32e3, 0.479, 0.0}, PowerLaw{18e3, 0.341, 0.5e3}};
  return law;
}

TEST(Hankinson, MeetsItsTwoLawsAndLiesBetween) {
  for (const double n : {1.0, 2.0, 3.0}) {
    EXPECT_DOUBLE_EQ(hankinson(3.0, 5.0, 1.0, n), 3.0);
    EXPECT_DOUBLE_EQ(hankinson(3.0, 5.0, 0.0, n), 5.0);
    if (n > 1.0) {
      EXPECT_GT(hankinson(3.0, 5.0, std::sqrt(0.5), n), 3.0);
      EXPECT_LT(hankinson(3.0, 5.0, std::sqrt(0.5), 2.0), 5.0);
    }
  }
  EXPECT_NEAR(hankinson(3.0, 5.0, std::sqrt(0.5), 2.0), 2.0 * 15.0 / 8.0, 1e-12);
  EXPECT_EQ(hankinson(0.0, 0.0, 0.3, 2.0), 0.0);
}

// [plaskos2002] eq. 5 has the specific cutting pressure F/h, [plaskos2006] eq. 3.2 the force.
TEST(Hankinson, OnThePressureIsTheSameAsOnTheForce) {
  const CuttingLaw law = power();
  for (const double h : {1e-6, 12e-6, 80e-6}) {
    for (const double cosine : {0.0, 0.2, 0.6, 0.9, 1.0}) {
      for (const double n : {1.0, 2.0, 2.7}) {
        const double force = hankinson(force_per_width(law.tangential.at_0, h),
                                       force_per_width(*law.tangential.at_90, h), cosine, n);
        const double pressure = hankinson(specific_energy(law.tangential.at_0, h),
                                          specific_energy(*law.tangential.at_90, h), cosine, n);
        EXPECT_NEAR(pressure * h, force, 1e-12 * force);
      }
    }
  }
}

TEST(EdgePart, IsTheForceAtNoChip) {
  CuttingLaw law = power();
  law.lateral = DirectionalLaw{PolynomialLaw{{40e6}, {1e3, 0.5e3}}, {}};
  const EdgePlace place{0.8, 1.1};
  for (const double cosine : {0.0, 0.4, 1.0}) {
    const EdgeComponents edge = components(edge_part(law), Chip(30e-6), cosine, place, 0.3);
    const EdgeComponents at_none = components(law, Chip(0.0), cosine, place, 0.3);
    EXPECT_NEAR(edge.tangential, at_none.tangential, 1e-9);
    EXPECT_NEAR(edge.radial, at_none.radial, 1e-9);
    EXPECT_NEAR(edge.lateral, at_none.lateral, 1e-9);
  }
  EXPECT_TRUE(has_edge_force(law));
  CuttingLaw log;
  log.tangential = {LogLaw{0.4, 0.6, -0.07}, {}};
  log.radial = {LogLaw{0.6, 0.4, -0.2}, {}};
  EXPECT_FALSE(has_edge_force(log));
  EXPECT_EQ(components(edge_part(log), Chip(30e-6), 1.0, {}, 0.0).tangential, 0.0);
}

TEST(CuttingLaw, RefusesParametersOfNoMeaning) {
  EXPECT_NO_THROW(check(power()));
  const auto refused = [](auto change) {
    CuttingLaw law = power();
    change(law);
    EXPECT_THROW(check(law), InvalidInput);
  };
  refused([](CuttingLaw& law) { law.orientation_exponent = 0.0; });
  refused([](CuttingLaw& law) { law.orientation_exponent = std::nan(""); });
  refused([](CuttingLaw& law) { law.minimum_chip = -1e-6; });
  refused([](CuttingLaw& law) { law.minimum_chip = 1e-3; });         // a millimetre for micrometres
  refused([](CuttingLaw& law) { law.lateral_inclination = 30.0; });  // degrees for radians
  refused([](CuttingLaw& law) { law.radial.at_90 = PowerLaw{18e3, 9.0, 0.0}; });
}

}  // namespace
}  // namespace osteomill::cutting
