// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/tune_case.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/io/case_file.hpp"

namespace osteomill::io {
namespace {

const std::filesystem::path kCase = OSTEOMILL_SOURCE_DIR "/examples/tune.toml";

TuneCase read(const std::vector<std::string>& overrides) {
  return read_tune_case(read_case(kCase, overrides).front());
}

TEST(Tune, ItsProposalKeepsTheHardZoneBelowTheLimitAndItsMarginsAtEveryCorner) {
  const TuneCase input = read({"tune.delay_updates=[1, 1]"});
  const Tuning tuning = tune(input);
  EXPECT_NEAR(tuning.bare_critical_loop_gain, 2.0 * std::pow(std::sin(std::numbers::pi / 10.0), 2),
              1e-9);
  for (const TunedCorner& corner : tuning.corners) {
    EXPECT_GE(corner.proposed_down.gain_margin, input.goal.gain_margin);
    EXPECT_GE(corner.proposed_down.phase_margin, input.goal.phase_margin);
    EXPECT_GT(corner.proposed_up.gain_margin, corner.proposed_down.gain_margin);
  }
  ASSERT_EQ(tuning.runs.size(), 2u);
  EXPECT_GT(tuning.runs[0].summary.peak_force, 30.0);  // as published: 31.1 N
  EXPECT_LT(tuning.runs[1].summary.peak_force, 30.0);
  EXPECT_GT(tuning.proposed.reference_force, 5.0);
}

TEST(Tune, SaysWhereTheBoneIsNoneOfTheRange) {
  const Tuning tuning = tune(read({"tune.delay_updates=[1, 1]"}));
  ASSERT_EQ(tuning.warnings.size(), 1u);
  EXPECT_THAT(tuning.warnings[0], testing::HasSubstr("14.3 N/(mm/s), above tune.largest_gain"));
  EXPECT_THAT(tuning.warnings[0], testing::HasSubstr("on 1.2 mm"));
  const Tuning soft = tune(read({"tune.delay_updates=[1, 1]", "tune.least_gain_n_per_mm_per_s=1",
                                 "tune.largest_gain_n_per_mm_per_s=15"}));
  ASSERT_EQ(soft.warnings.size(), 1u);
  EXPECT_THAT(soft.warnings[0], testing::HasSubstr("0.62 N/(mm/s), below tune.least_gain"));
}

TEST(Tune, RefusesWhatItCannotTune) {
  const auto refusal = [](const std::vector<std::string>& changes) -> std::string {
    try {
      read(changes);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal({"controller.kind=constant"}), testing::HasSubstr("controller"));
  EXPECT_THAT(refusal({"tune.delay_updates=[3, 1]"}), testing::HasSubstr("smaller first"));
  EXPECT_THAT(refusal({"tune.least_gain_n_per_mm_per_s=9"}),
              testing::HasSubstr("must not be less than least_gain"));
  EXPECT_THAT(refusal({"tune.gain_margin=0.5"}), testing::HasSubstr("tune.gain_margin"));
}

}  // namespace
}  // namespace osteomill::io
