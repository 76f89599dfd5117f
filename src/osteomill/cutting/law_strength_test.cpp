// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/cutting/law_strength.hpp"

#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"

namespace osteomill::cutting {
namespace {

TEST(LawStrength, MultipliesEveryForceOfEveryLaw) {
  const std::vector<EdgeForce> laws{LogLaw{0.42, 0.58, -0.066, {}}, PowerLaw{60e3, 0.6, 2e3, {}},
                                    LinearLaw{50e6, 3e3, {}},
                                    PolynomialLaw{{50e6, -3e6}, {2e3, 1e2}, {}}};
  for (const EdgeForce& law : laws) {
    const CuttingLaw one{.tangential = {law, law}, .radial = {law, {}}, .lateral = {{law, {}}}};
    const CuttingLaw more = scaled(one, 1.7);
    for (const double h : {1e-6, 40e-6}) {
      const double expected = 1.7 * force_per_width(law, h);
      EXPECT_NEAR(force_per_width(more.tangential.at_0, h), expected, 1e-9 * expected);
      EXPECT_NEAR(force_per_width(*more.tangential.at_90, h), expected, 1e-9 * expected);
      EXPECT_NEAR(force_per_width(more.radial.at_0, h), expected, 1e-9 * expected);
      EXPECT_NEAR(force_per_width(more.lateral->at_0, h), expected, 1e-9 * expected);
    }
  }
  EXPECT_THROW(scaled({}, 0.0), InvalidInput);
}

}  // namespace
}  // namespace osteomill::cutting
