// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/calibrate/error_budget.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::calibrate {
namespace {

using units::deg;

TEST(ErrorBudget, SourcesAddUpInSquaresAndFallInOrder) {
  BudgetOptions options;
  options.trials = 200;
  const auto lines = error_budget(options);
  ASSERT_EQ(lines.size(), 8u);
  double squares = 0.0;
  for (std::size_t i = 0; i < 6; ++i) {
    squares += lines[i].flexion_rms * lines[i].flexion_rms;
    if (i > 0) {
      EXPECT_GE(lines[i - 1].flexion_rms, lines[i].flexion_rms);
    }
  }
  // Independent small errors; 200 trials of five cuts that share a calibration leave some 10 %.
  EXPECT_NEAR(lines[6].flexion_rms, std::sqrt(squares), 0.15 * std::sqrt(squares));
  EXPECT_GT(lines[7].flexion_rms, lines[6].flexion_rms);
  // The published range of the automated positioning: 0.1 to 0.2 deg for four of the five cuts.
  EXPECT_LT(lines[6].mean_absolute, 0.4 * deg);
}

TEST(ErrorBudget, DoesNotDependOnTheNumberOfThreads) {
  BudgetOptions options;
  options.trials = 20;
  const auto many = error_budget(options);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const auto one = error_budget(options);
  for (std::size_t i = 0; i < many.size(); ++i) {
    EXPECT_EQ(many[i].source, one[i].source);
    EXPECT_EQ(many[i].flexion_rms, one[i].flexion_rms);
  }
}

TEST(ErrorBudget, RefusesNonsense) {
  BudgetOptions options;
  options.trials = 0;
  EXPECT_THROW(error_budget(options), InvalidInput);
  options = {};
  options.cone_spacing = 0.0;
  EXPECT_THROW(error_budget(options), InvalidInput);
}

}  // namespace
}  // namespace osteomill::calibrate
