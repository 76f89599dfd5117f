// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/simulate_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "osteomill/geometry/mesh_check.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/simulate_picture.hpp"
#include "osteomill/io/simulate_result.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using testing::HasSubstr;

const char* const kTitle = "Sugita tibia";
const char* const kProgram = "osteomill test";

std::vector<SimulatedRun> sugita(const std::vector<std::string>& overrides = {}) {
  return run_simulations(read_simulate_cases(
      read_case(OSTEOMILL_SOURCE_DIR "/examples/sugita_tibia.toml", overrides)));
}

const ReportSignal& signal(const ReportRun& run, const std::string& panel,
                           const std::string& name) {
  return *std::find_if(run.signals.begin(), run.signals.end(),
                       [&](const ReportSignal& s) { return s.panel == panel && s.name == name; });
}

TEST(SimulateReport, ShowsWhatTheSummaryOfEachRunSays) {
  const auto runs = sugita();
  const ReportData data = report_of(runs, kTitle, kProgram);
  ASSERT_EQ(data.runs.size(), runs.size());
  ASSERT_EQ(data.summary.rows.size(), runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const ReportRun& shown = data.runs[i];
    const simulate::Summary& summary = runs[i].summary;
    EXPECT_EQ(std::get<std::string>(data.summary.rows[i][0]), shown.name);
    EXPECT_EQ(std::get<double>(data.summary.rows[i][2]), summary.cutting_time);
    const auto& peak = signal(shown, "force", "peak force").values;
    EXPECT_EQ(*std::max_element(peak.begin(), peak.end()), summary.peak_force);
    // A sum over the same steps, in mm³.
    EXPECT_NEAR(signal(shown, "", "removed volume").values.back(), 1e9 * summary.removed_volume,
                1e-6);
    EXPECT_EQ(shown.events.back().time_s, summary.cutting_time);
  }
  EXPECT_EQ(data.headline, comparisons_of(runs));
}

TEST(SimulateReport, TimesCountFromFirstContactAsInTheSummary) {
  const ReportRun run = report_of(sugita(), kTitle, kProgram).runs[1];
  EXPECT_LT(run.time_s.front(), 0.0);
  const auto air = run.strips[0].intervals.front();
  EXPECT_EQ(air.label, "air");
  EXPECT_NEAR(air.to_s, 0.0, 0.0101);  // to a control period of 10 ms
}

TEST(SimulateReport, StripsCoverTheRunWithoutGapOrOverlap) {
  for (const ReportRun& run : report_of(sugita(), kTitle, kProgram).runs) {
    for (const ReportStrip& strip : run.strips) {
      if (strip.within_charts) continue;
      for (std::size_t i = 1; i < strip.intervals.size(); ++i) {
        EXPECT_EQ(strip.intervals[i].from_s, strip.intervals[i - 1].to_s);
        EXPECT_NE(strip.intervals[i].label, strip.intervals[i - 1].label);
      }
      EXPECT_NEAR(strip.intervals.front().from_s, run.time_s.front(), 0.0101);  // a control period
      EXPECT_EQ(strip.intervals.back().to_s, run.time_s.back());
    }
  }
}

TEST(SimulateReport, NoPathLeadsFromTheEndOfALineToTheStartOfTheNextOne) {
  const ReportRun run = report_of(sugita(), kTitle, kProgram).runs[0];
  const auto jumps = std::count_if(run.path.value.begin(), run.path.value.end(),
                                   [](double value) { return std::isnan(value); });
  EXPECT_EQ(jumps, 2);  // three lines
}

TEST(SimulateReport, TheStocksBeforeAndAfterDifferByWhatWasRemoved) {
  const auto file = scratch("block.toml");
  write_text_file(file, R"(
[stock]
kind = "block"
lower_mm = [0, 0, -4]
upper_mm = [16, 10, 0]
spacing_mm = 0.25
density_kg_per_m3 = 1900
[path]
kind = "points"
points = [{ x_mm = -3, y_mm = 5, z_mm = -2 }, { x_mm = 19, y_mm = 5, z_mm = -2 }]
feed_mm_per_s = 6
spindle_speed_rpm = 20000
[cutter]
use = "craniotomy-3mm"
[bone]
use = "bovine-cortical-high-speed"
[controller]
kind = "constant"
)");
  const auto runs = run_simulations(read_simulate_cases(read_case(file, {})));
  ReportData data = report_of(runs, kTitle, kProgram);
  add_scene(data, runs, surfaces_of(runs));
  ASSERT_TRUE(data.scene && data.scene->cutter);
  const double shown = geometry::volume(data.scene->before) - geometry::volume(data.runs[0].after);
  // The surface crosses voxels where half of one is bone; each of the slot's edges, 16 mm long, may
  // be off by a fraction of a voxel's section: 4 x 16 x 0.25^2 / 2 = 2 mm³ of 96 mm³.
  EXPECT_NEAR(shown, runs[0].summary.removed_volume, 2e-9);
  EXPECT_NEAR(runs[0].summary.removed_volume, 96e-9, 1e-9);
}

TEST(SimulateReport, IsAcceptedByTheWriter) {
  EXPECT_THAT(report_html(report_of(sugita(), kTitle, kProgram)), HasSubstr("hard-zone-adaptive"));
  EXPECT_THAT(report_html(report_of({}, kTitle, kProgram)), HasSubstr(kTitle));
}

}  // namespace
}  // namespace osteomill::io
