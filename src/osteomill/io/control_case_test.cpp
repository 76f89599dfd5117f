// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/control_case.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/paced_plant.hpp"
#include "osteomill/io/recording.hpp"
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

TEST(Control, VariantsAreOneRowOfATableForPeopleAndOneEachInTheWholeTable) {
  const auto runs = run_with({"variants.count=3"});
  ASSERT_EQ(runs.size(), 9u);
  const std::vector<RunRow> rows = rows_of(runs, true);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[1].name, "hard-zone-published, 3 variants");
  double peak = 0.0, above = 0.0, time = 0.0;
  for (int i = 3; i < 6; ++i) {
    peak = std::max(peak, runs[i].summary.peak_force);
    above += runs[i].summary.time_above_limit;
    time += runs[i].summary.cutting_time / 3.0;
  }
  EXPECT_EQ(rows[1].summary.peak_force, peak);
  EXPECT_DOUBLE_EQ(rows[1].summary.time_above_limit, above);
  EXPECT_DOUBLE_EQ(rows[1].summary.cutting_time, time);
  EXPECT_EQ(rows_of(runs, false).size(), 9u);
}

std::vector<SimulatedRun> one_of(const std::string& example, const std::string& name,
                                 const std::vector<std::string>& changes = {},
                                 const RunOptions& options = {}) {
  std::vector<CaseRun> all = read_case(OSTEOMILL_SOURCE_DIR "/examples/" + example, changes);
  std::erase_if(all, [&](const CaseRun& run) { return run.name != name; });
  return run_simulations(read_control_cases(all), {}, options);
}

/// Seconds in contact that the feed was limited by this.
double limited(const SimulatedRun& run, const char* by) {
  const nlohmann::ordered_json document = document_of({run}, 0.0).at("runs")[0];
  return document.at("limited_by_s").value(by, 0.0);
}

double hottest_that_stays(const SimulatedRun& run) {
  double hottest = 0.0;
  for (const simulate::Step& step : run.steps) hottest = std::max(hottest, step.temperature);
  return hottest - 273.15;
}

TEST(Control, EveryLimitOfTheFeedBindsInItsRunOnAVoxelStockAndHolds) {
  // The first line of the example: half the time, the same limits.
  const auto run = [](const std::string& name) {
    return one_of("feed_limits.toml", name, {"path.count=1"}).at(0);
  };
  const SimulatedRun force = run("force");
  EXPECT_GT(limited(force, "force"), 2.0);
  EXPECT_LE(force.summary.peak_force, 38.0);
  const SimulatedRun cool = run("temperature");
  EXPECT_GT(limited(cool, "temperature"), 0.1);  // at the end of the first line
  EXPECT_GT(hottest_that_stays(force), 80.0);
  EXPECT_LE(hottest_that_stays(cool), 80.0);
  EXPECT_LE(cool.summary.peak_force, 38.0);
  EXPECT_LT(cool.summary.cutting_time, force.summary.cutting_time);
  const SimulatedRun stiff = run("deflection");
  EXPECT_GT(limited(stiff, "deflection"), 2.0);
  EXPECT_LE(stiff.summary.peak_force, 600.0 * 0.05);
  const SimulatedRun thin = run("feed-per-tooth");
  EXPECT_GT(limited(thin, "feed per tooth"), 2.0);
  EXPECT_LE(thin.summary.max_feed,
            1.01 * 0.015e-3 * 2.0 * 10000.0 / 60.0);  // the servo's overshoot
  const SimulatedRun free = run("free-spindle");
  const SimulatedRun quiet = run("chatter");
  EXPECT_GT(limited(quiet, "chatter"), 1.0);
  EXPECT_GT(quiet.summary.cutting_time, free.summary.cutting_time);
  const auto fastest = [](const SimulatedRun& one) {
    double speed = 0.0;
    for (const simulate::Step& step : one.steps) {
      // Once the drive has answered.
      if (step.samples_in_contact > 0 && step.time > 1.5)
        speed = std::max(speed, step.spindle_speed);
    }
    return speed * 60.0 / 6.283185307179586;
  };
  EXPECT_GT(fastest(free), 12500.0);
  EXPECT_LT(fastest(quiet), 12500.0);
}

TEST(Control, ATemperatureThatNoFeedKeepsIsSaidAndStoppedByTheSupervisor) {
  const SimulatedRun run =
      one_of("feed_limits.toml", "temperature",
             {"path.count=1", "supervisor.temperature_c=70", "run.1.limits.temperature_c=60"})
          .at(0);
  EXPECT_EQ(run.summary.status, simulate::Status::supervisor);
  ASSERT_FALSE(run.loop.events.empty());
  EXPECT_EQ(run.loop.events[0].cause, control::Cause::temperature);
  EXPECT_THAT(run.warnings, testing::Contains(testing::HasSubstr("no feed within the other")));
}

TEST(Control, AChatterMarginThatNoFeedChangesIsRefusedWithItsPlace) {
  try {
    one_of("feed_limits.toml", "chatter",
           {"path.count=1", "run.5.chatter.stable_depths_mm=[2, 2, 1, 1]"});
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("mm along the path"));
  }
}

TEST(Control, AReplayOfALawThatLooksAheadInAVoxelStockGivesEveryCommandBitForBit) {
  class Kept final : public control::Plant {
   public:
    Kept(control::Plant& plant, std::vector<RecordedPeriod>& periods)
        : plant_(plant), periods_(periods) {}
    control::Observation start() override { return seen_ = plant_.start(); }
    control::Observation advance(const control::FeedCommand& command) override {
      periods_.push_back({seen_, command});
      return seen_ = plant_.advance(command);
    }

   private:
    control::Plant& plant_;
    std::vector<RecordedPeriod>& periods_;
    control::Observation seen_;
  };
  std::vector<RecordedPeriod> periods;
  std::unique_ptr<Kept> kept;
  RunOptions options;
  options.wrap = [&](control::Plant& plant, const SimulatedRun&, double) -> control::Plant& {
    kept = std::make_unique<Kept>(plant, periods);
    return *kept;
  };
  std::vector<CaseRun> all =
      read_case(OSTEOMILL_SOURCE_DIR "/examples/feed_limits.toml", {"path.count=1"});
  std::erase_if(all, [](const CaseRun& run) { return run.name != "chatter"; });
  std::vector<SimulateCase> cases = read_control_cases(all);
  run_simulations(cases, {}, options);
  settle_law(cases[0]);
  const Replay done = replay(periods, cases[0].controller, cases[0].machine.start_feed);
  EXPECT_GT(done.periods, 400u);
  EXPECT_EQ(done.different, 0u);
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
