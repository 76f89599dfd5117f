// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/axes_check.hpp"

#include <gtest/gtest.h>

#include "osteomill/identify/experiments_for_test.hpp"

namespace osteomill::identify {
namespace {

using namespace for_test;

std::vector<Experiment> measured() {
  std::vector<Experiment> cuts = plan(end_mill());
  measure(cuts, law_of({}, bone()), 0.2, 5);
  return cuts;
}

TEST(AxesCheck, LeavesRightAxesAlone) {
  const AxesCheck check = check_axes(measured());
  EXPECT_FALSE(check.suspicious);
  EXPECT_LT(check.misfit_as_given, 0.1);
  EXPECT_EQ(names_of(check.best.front()), (std::array<std::string, 3>{"x", "y", "z"}));
}

TEST(AxesCheck, FindsSwappedAndReversedAxes) {
  struct Case {
    AxisMapping mounting;               ///< what the sensor shows
    std::array<std::string, 3> remedy;  ///< how to read it
  };
  const std::vector<Case> cases = {{{{1, 0, 2}, {1, 1, 1}}, {"y", "x", "z"}},
                                   {{{1, 0, 2}, {1, -1, 1}}, {"-y", "x", "z"}},
                                   {{{0, 1, 2}, {-1, -1, 1}}, {"-x", "-y", "z"}},
                                   {{{2, 1, 0}, {1, 1, 1}}, {"z", "y", "x"}}};
  for (const Case& one : cases) {
    std::vector<Experiment> cuts = measured();
    for (Experiment& cut : cuts) cut.mean_force = mapped(one.mounting, cut.mean_force);
    const AxesCheck check = check_axes(cuts);
    EXPECT_TRUE(check.suspicious);
    EXPECT_EQ(names_of(check.best.front()), one.remedy);
  }
}

}  // namespace
}  // namespace osteomill::identify
