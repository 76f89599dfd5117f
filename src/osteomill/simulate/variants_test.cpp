// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/simulate/variants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "osteomill/base/error.hpp"

namespace osteomill::simulate {
namespace {

LineProfile bone() {
  LineProfile profile;
  profile.zones = {{0.0, 66e-3, 3250.0, {}, {}}};
  return profile;
}

Machine machine() {
  Machine machine;
  machine.spindle_speed = 600.0;
  return machine;
}

TEST(Variants, AreAFunctionOfSeedAndNumber) {
  const Variant once = vary(bone(), machine(), {}, 17);
  const Variant again = vary(bone(), machine(), {}, 17);
  EXPECT_EQ(once.profile.variation, again.profile.variation);
  EXPECT_EQ(once.machine.seed, again.machine.seed);
  EXPECT_NE(once.profile.variation, vary(bone(), machine(), {}, 18).profile.variation);
  VariantOptions other;
  other.seed = 2;
  EXPECT_NE(once.profile.variation, vary(bone(), machine(), other, 17).profile.variation);
}

TEST(Variants, TheFactorHasTheSpreadAndTheCorrelationThatWereAskedFor) {
  VariantOptions options;
  options.hard_zones = false;
  double sum = 0.0;
  double squares = 0.0;
  double products = 0.0;
  long count = 0;
  const std::size_t lag = 30;  // 1.5 mm at 0.05 mm
  for (std::uint64_t number = 0; number < 200; ++number) {
    for (const auto& factors : vary(bone(), machine(), options, number).profile.variation) {
      for (std::size_t i = 0; i + lag < factors.size(); ++i) {
        sum += factors[i] - 1.0;
        squares += (factors[i] - 1.0) * (factors[i] - 1.0);
        products += (factors[i] - 1.0) * (factors[i + lag] - 1.0);
        ++count;
      }
    }
  }
  // 600 lines of 66 mm hold about 13 000 independent pieces: 1 % of the spread.
  EXPECT_NEAR(sum / static_cast<double>(count), 0.0, 0.01);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(count)), 0.25, 0.01);
  EXPECT_NEAR(products / squares, std::exp(-1.0), 0.03);
}

TEST(Variants, EveryLineGetsOneHardZoneOfItsWidth) {
  VariantOptions options;
  options.gain_sigma = 0.0;
  for (std::uint64_t number = 0; number < 20; ++number) {
    const Variant made = vary(bone(), machine(), options, number);
    EXPECT_GE(made.machine.delay_updates, 1);
    EXPECT_LE(made.machine.delay_updates, 3);
    for (const auto& factors : made.profile.variation) {
      const auto hard =
          std::count_if(factors.begin(), factors.end(), [](double factor) { return factor > 4.0; });
      EXPECT_NEAR(static_cast<double>(hard) * 0.05, 1.17, 0.05);
    }
  }
}

TEST(Variants, RefusesOptionsThatMakeNone) {
  const auto broken = [](auto change) {
    VariantOptions options;
    change(options);
    return options;
  };
  using Options = VariantOptions;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(check(broken([&](Options& o) { o.gain_sigma = nan; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.correlation = 0.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.noise = -1.0; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.delay = {3, 1}; })), InvalidInput);
  EXPECT_THROW(check(broken([](Options& o) { o.hard_width = 0.0; })), InvalidInput);
}

}  // namespace
}  // namespace osteomill::simulate
