// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_case.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "osteomill/base/error.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/simulate_report.hpp"
#include "osteomill/io/simulate_result.hpp"
#include "osteomill/io/simulated_run.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

const std::filesystem::path kSugita = OSTEOMILL_SOURCE_DIR "/examples/sugita_tibia.toml";

std::vector<SimulatedRun> run_file(const std::filesystem::path& file,
                                   const std::vector<std::string>& overrides = {}) {
  return run_simulations(read_simulate_cases(read_case(file, overrides)));
}

const SimulatedRun& named(const std::vector<SimulatedRun>& runs, const std::string& name) {
  for (const SimulatedRun& run : runs) {
    if (run.input.name == name) return run;
  }
  throw std::out_of_range(name);
}

/// Mean force on line 1 while the whole arc of contact is in bone.
double engaged_mean_on_line_1(const SimulatedRun& run) {
  double sum = 0.0;
  long samples = 0;
  for (const simulate::Step& step : run.steps) {
    if (step.line != 0 || step.tip_W.x() < 0.0 || step.tip_W.x() > 66e-3 - 2.646e-3) continue;
    sum += step.sum_force;
    samples += step.samples_in_contact;
  }
  return sum / static_cast<double>(samples);
}

class SugitaTibia : public testing::Test {
 protected:
  static void SetUpTestSuite() { runs_ = new std::vector<SimulatedRun>(run_file(kSugita)); }
  static void TearDownTestSuite() {
    delete runs_;
    runs_ = nullptr;
  }
  static const simulate::Summary& summary(const std::string& name) {
    return named(*runs_, name).summary;
  }
  static std::vector<SimulatedRun>* runs_;
};
std::vector<SimulatedRun>* SugitaTibia::runs_ = nullptr;

// The numbers below are those of an independent simulation, given to a tenth
// (docs/theory/control.md).
constexpr double kTenth = 0.05;

TEST_F(SugitaTibia, UniformBoneTakesTheTimesThatTheSourceReports) {
  EXPECT_NEAR(summary("uniform-constant").cutting_time, 80.9, kTenth);
  EXPECT_NEAR(summary("uniform-constant").peak_force, 22.8, kTenth);
  EXPECT_NEAR(summary("uniform-adaptive").cutting_time, 41.2, kTenth);
  EXPECT_NEAR(engaged_mean_on_line_1(named(*runs_, "uniform-adaptive")), 12.0, kTenth);
  const auto& saturated = summary("uniform-adaptive").saturated_intervals;
  ASSERT_EQ(saturated.size(), 2u);
  EXPECT_NEAR(saturated[0][0], 25.0, kTenth);
  // The ends fall between two periods of 10 ms: one of them beside the tenth.
  EXPECT_NEAR(saturated[0][1], 29.4, kTenth + 0.01);
  EXPECT_NEAR(saturated[1][0], 35.0, kTenth);
  EXPECT_NEAR(saturated[1][1], 39.4, kTenth + 0.01);
}

TEST_F(SugitaTibia, AHardZoneExplainsFiftyNewtonAtConstantFeed) {
  EXPECT_NEAR(summary("hard-zone-constant").cutting_time, 80.9, kTenth);
  EXPECT_NEAR(summary("hard-zone-constant").peak_force, 50.0, kTenth);
  EXPECT_NEAR(summary("hard-zone-adaptive").cutting_time, 41.8, kTenth);
  EXPECT_NEAR(summary("hard-zone-adaptive").peak_force, 31.1, kTenth);
  const auto& saturated = summary("hard-zone-adaptive").saturated_intervals;
  ASSERT_EQ(saturated.size(), 2u);
  EXPECT_NEAR(saturated[0][0], 23.5, kTenth);
  EXPECT_NEAR(saturated[1][0], 34.7, kTenth);
  // The reference's ends are 27.6 and 38.8 s; ours, at the last period with the command at
  // 12 mm/s, are 27.54 and 38.74 s.
  EXPECT_NEAR(saturated[0][1], 27.6, kTenth + 0.02);
  EXPECT_NEAR(saturated[1][1], 38.8, kTenth + 0.02);
}

TEST_F(SugitaTibia, EveryRunRemovesTheSameBone) {
  for (const SimulatedRun& run : *runs_) {
    EXPECT_NEAR(run.summary.removed_volume / 557.02e-9, 1.0, 1e-4) << run.input.name;
    EXPECT_EQ(run.summary.status, simulate::Status::finished);
  }
}

TEST_F(SugitaTibia, IsComparedWithConstantFeedOnTheSameBone) {
  EXPECT_THAT(
      comparisons_of(*runs_),
      testing::ElementsAre(testing::HasSubstr("uniform-adaptive: 41.2 s against 80.9 s"),
                           testing::HasSubstr("hard-zone-adaptive: 41.8 s against 80.9 s")));
}

TEST_F(SugitaTibia, TheExpandedCaseRunsAgainToTheSameResult) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / "sugita_again.json";
  write_text_file(file, nlohmann::ordered_json{{"case", case_of(*runs_)}}.dump());
  const std::vector<SimulatedRun> again = run_file(file);
  std::filesystem::remove(file);
  EXPECT_EQ(document_of(again, 0.0).dump(), document_of(*runs_, 0.0).dump());
}

TEST_F(SugitaTibia, DocumentHasTheKeysThatScriptsRelyOn) {
  const nlohmann::ordered_json document = document_of(*runs_, 1.0);
  EXPECT_TRUE(document.contains("wall_time_s"));
  EXPECT_TRUE(document.contains("steps"));
  for (const auto& run : document.at("runs")) {
    for (const char* key :
         {"name", "cutting_time_s", "mean_force_n", "peak_force_n", "time_above_limit_s",
          "removed_volume_mm3", "max_feed_mm_per_s", "saturated_intervals_s", "line_times_s"}) {
      EXPECT_TRUE(run.contains(key)) << key;
    }
  }
}

TEST_F(SugitaTibia, SignalsCarryTheWorkThatTheSummaryReports) {
  const SignalsFile file = signals_of(*runs_);
  ASSERT_EQ(file.runs.size(), runs_->size());
  for (std::size_t i = 0; i < file.runs.size(); ++i) {
    double work = 0.0;
    for (const Signal& signal : file.runs[i].signals) {
      ASSERT_EQ(signal.values.size(), (*runs_)[i].steps.size()) << signal.name;
      if (signal.name != "feed_work") continue;
      for (const double value : signal.values) work += value;
    }
    EXPECT_NEAR(work, (*runs_)[i].summary.feed_work, 1e-9);
  }
}

TEST_F(SugitaTibia, MakesAReportThatHoldsTogether) {
  const std::string page = report_html(report_of(*runs_, "tibia", "osteomill test"));
  EXPECT_THAT(page, testing::HasSubstr("hard-zone-adaptive"));
}

TEST(SimulateCase, TheLiteralSumLimitCyclesInTheTibia) {
  const auto runs = run_file(kSugita, {"controller.reading=sum", "controller.kind=sugita"});
  // In cortical bone on line 1 the feed swings between its limits for ever.
  const SimulatedRun& run = named(runs, "uniform-adaptive");
  double low = 1.0;
  double high = 0.0;
  for (const simulate::Step& step : run.steps) {
    if (step.line != 0 || step.tip_W.x() < 40e-3 || step.tip_W.x() > 50e-3) continue;
    low = std::min(low, step.command);
    high = std::max(high, step.command);
  }
  EXPECT_GT(high - low, 2e-3);
}

TEST(SimulateCase, CellsOfHeatThatAreWiderThanTheHotLayerAreSaid) {
  const auto said = [](const char* spacing) {
    const auto runs = run_file(OSTEOMILL_SOURCE_DIR "/examples/leaning_ball.toml",
                               {spacing, "stock.spacing_mm=0.5"});
    return std::any_of(runs[0].warnings.begin(), runs[0].warnings.end(), [](const auto& warning) {
      return warning.find("heat.spacing_mm = 0.5 or less") != std::string::npos;
    });
  };
  EXPECT_TRUE(said("heat.spacing_mm=1"));
  EXPECT_FALSE(said("heat.spacing_mm=0.5"));
}

TEST(SimulateCase, StopsWhereItIsAndKeepsWhatIsDone) {
  const auto cases = read_simulate_cases(read_case(kSugita, {}));
  const auto runs =
      run_simulations(cases, [](std::string_view, double share) { return share < 0.3; });
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].summary.status, simulate::Status::finished);
  EXPECT_EQ(runs[1].summary.status, simulate::Status::stopped);
  EXPECT_GT(runs[1].steps.size(), 100u);
}

TEST(SimulateCase, AnEdgeForceAboveTheReferenceStallsThePublishedLoopAndTheRunSaysSo) {
  const auto runs = run_file(kSugita, {"stock.edge_force_n=14"});
  const SimulatedRun& run = named(runs, "uniform-adaptive");
  EXPECT_EQ(run.summary.status, simulate::Status::stalled);
  ASSERT_EQ(run.warnings.size(), 1u);
  EXPECT_THAT(run.warnings[0], testing::HasSubstr("min_feed_mm_per_s"));
  const auto with_floor =
      run_file(kSugita, {"stock.edge_force_n=14", "limits.min_feed_mm_per_s=0.5"});
  EXPECT_EQ(named(with_floor, "uniform-adaptive").summary.status, simulate::Status::finished);
}

TEST(SimulateCase, TheModelAdaptiveLawIsFasterThanTheSourceAndStaysBelowTheLimit) {
  const auto runs = run_simulations(
      read_simulate_cases(read_case(kSugita.parent_path() / "model_adaptive.toml", {})));
  const simulate::Summary& summary = named(runs, "hard-zone-model-adaptive").summary;
  EXPECT_LE(summary.cutting_time, 36.0);
  EXPECT_LT(summary.peak_force, 30.0);
  EXPECT_EQ(summary.time_above_limit, 0.0);
  EXPECT_LE(summary.max_feed, 12.1e-3);
}

/// The message when one key of the Sugita case is replaced.
std::string refusal(const std::string& change) {
  try {
    run_file(kSugita, {change});
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SimulateCase, RefusesBadInputWithTheKeyAndTheRule) {
  EXPECT_THAT(refusal("path.feed_mm_per_s=-3"), testing::HasSubstr("path.feed_mm_per_s = -3"));
  EXPECT_THAT(refusal("path.spindle_speed_rpm=0"), testing::HasSubstr("spindle_speed_rpm"));
  EXPECT_THAT(refusal("path.radial_depth_mm=4.5"), testing::HasSubstr("radial_depth_mm"));
  EXPECT_THAT(refusal("stock.kind=cheese"), testing::HasSubstr("line-profile | block"));
  EXPECT_THAT(refusal("stock.zones=[]"), testing::HasSubstr("stock.zones"));
  EXPECT_THAT(refusal("stock.peak_to_mean=3"), testing::HasSubstr("1 ... 2"));
  EXPECT_THAT(refusal("limits.min_feed_mm_per_s=13"), testing::HasSubstr("max_feed_mm_per_s"));
  EXPECT_THAT(refusal("limits.force_n=0"), testing::HasSubstr("limits.force_n"));
  EXPECT_THAT(refusal("machine.sample_rate_hz=8050"), testing::HasSubstr("whole number"));
  EXPECT_THAT(refusal("controller.period_ms=0"), testing::HasSubstr("controller.period_ms"));
  EXPECT_THAT(refusal("stock.colour=7"), testing::HasSubstr("no known key"));
}

TEST(SimulateCase, HeatIsReadInCelsiusAndAbsentWhenNotAskedFor) {
  const std::filesystem::path cranium = OSTEOMILL_SOURCE_DIR "/examples/cranium_ct.toml";
  for (const SimulateCase& run : read_simulate_cases(read_case(cranium, {})))
    EXPECT_FALSE(run.heat.has_value());
  for (const SimulateCase& run : read_simulate_cases(
           read_case(cranium, {"heat.coolant_temperature_c=20", "heat.spacing_mm=0.5"}))) {
    ASSERT_TRUE(run.heat.has_value());
    EXPECT_DOUBLE_EQ(run.heat->field.coolant_temperature, 293.15);
    EXPECT_DOUBLE_EQ(run.heat->field.initial_temperature, 310.15);
    EXPECT_DOUBLE_EQ(run.heat->spacing, 0.5e-3);
  }
  EXPECT_THROW(read_simulate_cases(read_case(cranium, {"heat.spacing_mm=-1"})), InvalidInput);
}

}  // namespace
}  // namespace osteomill::io
