// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/control_case.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/paced_plant.hpp"
#include "osteomill/io/simulate_result.hpp"

namespace osteomill::io {
namespace {

const std::filesystem::path kCase = OSTEOMILL_SOURCE_DIR "/examples/model_adaptive.toml";

std::vector<SimulatedRun> run_with(const std::vector<std::string>& overrides) {
  return run_simulations(read_control_cases(read_case(kCase, overrides)));
}

struct Sum {
  double time = 0.0;
  double above = 0.0;
  double peak = 0.0;
  int count = 0;
};
Sum sum_of(const std::vector<SimulatedRun>& runs, const std::string& name) {
  Sum sum;
  for (const SimulatedRun& run : runs) {
    if (run.input.variant_of != name) continue;
    EXPECT_EQ(run.summary.status, simulate::Status::finished) << run.input.name;
    sum.time += run.summary.cutting_time;
    sum.above += run.summary.time_above_limit;
    ++sum.count;
  }
  return sum;
}

TEST(Control, OnSixteenVariantsTheModelAdaptiveLawIsFasterAndAboveTheLimitATwentiethOfTheTime) {
  // The tibia without its fixed hard zone: every variant has one of its own on each line.
  const auto runs = run_with({"variants.count=16", "stock.zones.4.gain_n_per_mm_per_s=3.25"});
  const Sum published = sum_of(runs, "hard-zone-published");
  const Sum adaptive = sum_of(runs, "hard-zone-model-adaptive");
  ASSERT_EQ(published.count, 16);
  ASSERT_EQ(adaptive.count, 16);
  EXPECT_LE(adaptive.time / 16.0, 40.0);
  EXPECT_LT(adaptive.time, published.time);
  EXPECT_LE(adaptive.above, published.above / 20.0);
}

TEST(Control, EntryIntoCorticalBoneAtFullFeedKeepsTheSetForceForEveryErrorOfTheMap) {
  Random random(3);
  std::vector<double> offsets = {-1.0, 0.0, 1.0};
  for (int i = 0; i < 3; ++i) offsets.push_back(random.uniform(-1.0, 1.0));
  const double ripple = 1.48;  // peak over mean
  for (const double offset : offsets) {
    const auto runs = run_simulations(
        read_control_cases(read_case(OSTEOMILL_SOURCE_DIR "/examples/bone_entry.toml",
                                     {fmt::format("map.offset_mm={:.6f}", offset)})));
    ASSERT_EQ(runs.size(), 5u);
    // Nothing slows the first one: it shows what an entry takes.
    EXPECT_GT(runs[0].summary.peak_force, 1.15 * 12.0 * ripple);
    EXPECT_LE(runs[2].summary.peak_force, 1.15 * 12.0 * ripple) << offset;  // held, 12 N
    EXPECT_LE(runs[3].summary.peak_force, 1.15 * 0.92 * 30.0) << offset;    // model-adaptive
    EXPECT_LE(runs[4].summary.peak_force, 1.15 * 0.92 * 30.0) << offset;    // model-predictive
    EXPECT_LT(runs[4].summary.cutting_time, runs[3].summary.cutting_time);
  }
  // Released before the cutter is fully engaged, the benefit is lost where the bone comes late.
  const auto early = run_simulations(read_control_cases(
      read_case(OSTEOMILL_SOURCE_DIR "/examples/bone_entry.toml", {"map.offset_mm=-1"})));
  EXPECT_GT(early[1].summary.peak_force, 1.15 * 12.0 * ripple);
}

TEST(Control, TheModelPredictiveLawKeepsVariantsBelowTheLimitWithAMapThatIsWrongByUpToAMillimetre) {
  std::vector<CaseRun> all =
      read_case(OSTEOMILL_SOURCE_DIR "/examples/model_predictive.toml",
                {"variants.count=6", "stock.zones.4.gain_n_per_mm_per_s=3.25"});
  std::erase_if(all, [](const CaseRun& run) { return run.name != "model-predictive"; });
  const auto runs = run_simulations(read_control_cases(all));
  const Sum sum = sum_of(runs, "model-predictive");
  ASSERT_EQ(sum.count, 6);
  EXPECT_LE(sum.time / 6.0, 40.0);
  EXPECT_EQ(sum.above, 0.0);
  bool moved = false;
  for (const SimulatedRun& run : runs) moved |= run.input.machine.map_offset != 0.0;
  EXPECT_TRUE(moved);
}

TEST(Control, VariantsRunAgainFromTheExpandedCase) {
  const auto runs = run_with({"variants.count=2", "variants.noise_n=2"});
  ASSERT_EQ(runs.size(), 6u);
  EXPECT_EQ(case_of(runs).at("run").size(), 3u);
  CaseRun again{"hard-zone-published", {}, {}};
  again.tree.values = case_of(runs).at("run")[1];
  again.tree.values.erase("name");
  const auto repeated = run_simulations(read_control_cases({again}));
  ASSERT_EQ(repeated.size(), 2u);
  EXPECT_EQ(repeated[1].summary.cutting_time, runs[3].summary.cutting_time);
  EXPECT_EQ(repeated[1].summary.peak_force, runs[3].summary.peak_force);
}

TEST(Control, DocumentHasTheKeysThatScriptsRelyOn) {
  const nlohmann::ordered_json document = control_document_of(run_with({}), 1.0, -1.0);
  EXPECT_EQ(document.at("runs").size(), 3u);
  EXPECT_TRUE(document.at("events").empty());
  EXPECT_TRUE(document.at("stopped_by").is_null());
  for (const char* key :
       {"period_ms", "compute_us_p50", "compute_us_p999", "wake_up_jitter_us_max", "overruns"}) {
    EXPECT_TRUE(document.at("timing").contains(key)) << key;
  }
}

TEST(Control, TheSupervisorStopsARunAndSaysWhy) {
  const auto runs = run_with({"supervisor.force_n=40"});
  // At constant feed the hard zone takes 50 N.
  EXPECT_EQ(runs[0].summary.status, simulate::Status::supervisor);
  EXPECT_LT(runs[0].steps.back().feed, 0.1e-3);
  const nlohmann::ordered_json document = control_document_of(runs, 1.0, -1.0);
  EXPECT_EQ(document.at("stopped_by"), "force-overload");
  EXPECT_EQ(document.at("events")[0].at("limit"), 40.0);
  EXPECT_EQ(runs[2].summary.status, simulate::Status::finished);
}

TEST(Control, RefusesVariantsThatAreNone) {
  const auto refusal = [](const std::vector<std::string>& changes) -> std::string {
    try {
      read_control_cases(read_case(kCase, changes));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal({"variants.count=-1"}), testing::HasSubstr("variants.count"));
  EXPECT_THAT(refusal({"variants.delay_updates=[3, 1]"}), testing::HasSubstr("smaller first"));
  EXPECT_THAT(refusal({"variants.gain_sigma=2"}), testing::HasSubstr("0 ... 1"));
  EXPECT_THAT(refusal({"supervisor.force_n=0"}), testing::HasSubstr("supervisor.force_n"));
}

TEST(PacedPlant, TakesAsLongAsItsPeriods) {
  class Still final : public control::Plant {
   public:
    control::Observation start() override { return {}; }
    control::Observation advance(const control::FeedCommand&) override { return {}; }
  };
  Still still;
  PacedPlant paced(still, 1e-3);
  paced.start();
  for (int i = 0; i < 5; ++i) paced.advance({});
  EXPECT_GE(paced.largest_lateness(), 0.0);
}

}  // namespace
}  // namespace osteomill::io
