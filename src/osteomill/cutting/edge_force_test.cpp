// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/edge_force.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::cutting {
namespace {

using testing::HasSubstr;

TEST(EdgeForce, FollowsItsFormula) {
  // At 10 um L = 1: the exponents of the log law add.
  EXPECT_NEAR(force_per_width(LogLaw{0.42083, 0.58122, -0.06584}, 10e-6),
              std::pow(10.0, 0.42083 + 0.58122 - 0.06584) * 1e3, 1e-9);
  EXPECT_NEAR(force_per_width(PowerLaw{60e3, 0.6, 2e3}, 8e-6), 60e3 * std::pow(8e-3, 0.6) + 2e3,
              1e-9);
  EXPECT_NEAR(force_per_width(LinearLaw{200e6, 3e3}, 8e-6), 200e6 * 8e-6 + 3e3, 1e-9);
  EXPECT_NEAR(force_per_width(kienzle(100e6, 0.25), 8e-6), 100e6 * std::pow(8e-3, -0.25) * 8e-6,
              1e-9);
  const EdgePlace place{0.7, 1.2};
  EXPECT_NEAR(force_per_width(PolynomialLaw{{500e6, -200e6}, {3e3, 1e3}}, 8e-6, place),
              (500e6 - 200e6 * 0.7) * 8e-6 + 1.2 * (3e3 + 1e3 * 0.7), 1e-9);
}

TEST(EdgeForce, HasASpecificEnergyOfForceOverChip) {
  for (const EdgeForce& law :
       {EdgeForce(LogLaw{0.42, 0.58, -0.066}), EdgeForce(PowerLaw{60e3, 0.6, 2e3}),
        EdgeForce(LinearLaw{200e6, 3e3}), EdgeForce(kienzle(100e6, 0.25)),
        EdgeForce(PolynomialLaw{{500e6, -200e6}, {3e3}})}) {
    EXPECT_NEAR(specific_energy(law, 8e-6), force_per_width(law, 8e-6) / 8e-6, 1e-3);
    // The size effect of [plaskos2002] 4: thin chips take more energy.
    EXPECT_GT(specific_energy(law, 4e-6), specific_energy(law, 8e-6)) << name_of(law);
    EXPECT_THROW(specific_energy(law, 0.0), InvalidInput);
  }
  EXPECT_NEAR(specific_energy(LinearLaw{200e6, 0.0}, 4e-6), 200e6, 1e-6);
}

TEST(EdgeForce, AtNoChipIsTheEdgeForce) {
  EXPECT_EQ(force_per_width(LogLaw{0.42, 0.58, -0.066}, 0.0), 0.0);
  EXPECT_EQ(force_per_width(PowerLaw{60e3, 0.6, 2e3}, 0.0), 2e3);
  EXPECT_EQ(force_per_width(LinearLaw{200e6, 3e3}, 0.0), 3e3);
  // A log law that would grow without limit keeps its value at the least chip of its range.
  const LogLaw rising{0.4, -0.2, 0.1, {2e-6, 50e-6}};
  EXPECT_DOUBLE_EQ(force_per_width(rising, 0.0), force_per_width(rising, 2e-6));
}

TEST(EdgeForce, RefusesWhatIsNoLawAndNamesTheParameter) {
  const double nan = std::nan("");
  struct Bad {
    EdgeForce law;
    const char* named;
  };
  const Bad table[] = {
      {LogLaw{nan, 0.5, -0.1}, "k1"},
      {LogLaw{0.4, std::numeric_limits<double>::infinity(), -0.1}, "k2"},
      {LogLaw{0.4, 0.5, nan}, "k3"},
      {LogLaw{0.4, 0.5, 0.1}, "k3"},  // grows as the chip vanishes, and states no least chip
      {LogLaw{0.4, 0.5, -0.1, {50e-6, 2e-6}}, "range_um"},
      {LogLaw{0.4, 0.5, -0.1, {-1e-6, 2e-6}}, "range_um"},
      {PowerLaw{-1e3, 0.6, 0.0}, "k"},
      {PowerLaw{60e3, 0.0, 0.0}, "n"},
      {PowerLaw{60e3, -0.3, 0.0}, "n"},
      {PowerLaw{60e3, 2.5, 0.0}, "n"},
      {PowerLaw{60e3, nan, 0.0}, "n"},
      {PowerLaw{60e3, 0.6, nan}, "edge"},
      {kienzle(-100e6, 0.2), "k"},
      {kienzle(100e6, 1.1), "n"},
      {LinearLaw{nan, 0.0}, "k"},
      {LinearLaw{200e6, nan}, "edge"},
      {PolynomialLaw{{}, {}}, "shear"},
      {PolynomialLaw{{500e6, nan}, {}}, "shear"},
      {PolynomialLaw{{500e6}, {nan}}, "edge"},
  };
  for (const Bad& bad : table) {
    try {
      check(bad.law, "bone.radial");
      ADD_FAILURE() << bad.named;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr(std::string("bone.radial.") + bad.named));
    }
  }
}

}  // namespace
}  // namespace osteomill::cutting
