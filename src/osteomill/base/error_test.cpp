// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/base/error.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace osteomill {
namespace {

TEST(InvalidInput, NamesPlaceFieldValueRuleAndRemedyOfEveryFault) {
  const InvalidInput error({Fault{"cut.feed_rate_mm_per_min", "-3", "must be > 0", "", "a.toml:4"},
                            Fault{"path.file", "x.ngc", "no such file", "check the name"}});
  EXPECT_STREQ(error.what(),
               "a.toml:4: cut.feed_rate_mm_per_min = -3: must be > 0\n"
               "path.file = x.ngc: no such file; check the name");
  EXPECT_EQ(error.faults().size(), 2u);
}

TEST(Require, PassesGoodValuesThroughAndRefusesTheRest) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(require_positive("radius", 2.0, "mm"), 2.0);
  EXPECT_EQ(require_non_negative("radius", 0.0, "mm"), 0.0);
  EXPECT_EQ(require_within("rake", 10.0, -45.0, 45.0, "deg"), 10.0);
  EXPECT_THROW(require_positive("radius", 0.0, "mm"), InvalidInput);
  EXPECT_THROW(require_positive("radius", nan, "mm"), InvalidInput);
  EXPECT_THROW(require_non_negative("radius", -1e-300, "mm"), InvalidInput);
  EXPECT_THROW(require_within("rake", 46.0, -45.0, 45.0, "deg"), InvalidInput);
  EXPECT_THROW(require_within("rake", nan, -45.0, 45.0, "deg"), InvalidInput);
}

}  // namespace
}  // namespace osteomill
