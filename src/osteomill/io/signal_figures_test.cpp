// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/signal_figures.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "osteomill/base/units.hpp"
#include "osteomill/io/experiments.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/signal_export.hpp"

namespace osteomill::io {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const std::filesystem::path kExamples = OSTEOMILL_SOURCE_DIR "/examples/records";

ExperimentsCase example_case() {
  ExperimentsCase from;
  from.table = kExamples / "table.csv";
  from.format.axes = {"-x", "y", "-z"};
  from.format.on_workpiece = true;
  from.signals.chain.baseline = identify::BaselineKind::drift;
  from.signals.chain.filter_order = 4;
  from.signals.chain.cutoff_over_tooth_passing = 8.0;
  from.signals.chain.envelope = true;
  from.signals.chain.average_flutes = true;
  return from;
}

const ExperimentDefaults kDefaults{
    .cutter = {.radius = 3e-3,
               .flutes = 2,
               .helix_angle = 30 * units::deg,
               .cutting_length = 10e-3},
};

// The means of osteomill force for the coefficients that the records were made with, N.
const std::vector<geometry::Vector3> kTruth{{-4.306, 4.241, -1.805},   {-5.844, 7.023, -3.034},
                                            {-8.247, 11.543, -4.992},  {-8.612, 8.481, -3.609},
                                            {-11.687, 14.045, -6.067}, {-16.494, 23.087, -9.983}};

TEST(ExampleRecords, GiveTheirMeansBackWithinThreeStandardErrors) {
  const auto loaded = load_experiments(example_case(), kDefaults);
  ASSERT_THAT(loaded, SizeIs(6));
  for (std::size_t i = 0; i < 6; ++i) {
    const identify::Experiment& one = loaded[i].experiment;
    EXPECT_THAT(loaded[i].warnings, IsEmpty()) << one.name;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LT(std::abs(one.mean_force[axis] - kTruth[i][axis]), 3.0 * one.standard_error[axis])
          << one.name << " axis " << axis;
    }
    EXPECT_NEAR(loaded[i].processed->rotation->spindle_speed / units::rpm, 3012.0, 0.5);
  }
}

TEST(SignalFigures, DrawEveryStepThatWasDone) {
  int number = 0;
  load_experiments(example_case(), kDefaults,
                   [&](const identify::ForceRecord& raw, const LoadedExperiment& one) {
                     if (++number > 1) return;
                     const auto figures = figures_of(raw, *one.processed, 2, one.experiment.name);
                     std::vector<std::string> names;
                     for (const SignalFigure& figure : figures) {
                       names.push_back(figure.name);
                       EXPECT_FALSE(figure.caption.empty());
                       draw(figure.plot, scratch(figure.name + ".png"));
                       EXPECT_GT(std::filesystem::file_size(scratch(figure.name + ".png")), 10000u);
                     }
                     EXPECT_THAT(names, ElementsAre("record", "close", "spectrum", "mean",
                                                    "revolution", "harmonics"));
                   });
}

TEST(SignalExport, KeepsWhatWasReadAndWhatCameOut) {
  ExperimentsCase from = example_case();
  load_experiments(from, kDefaults, [&](const identify::ForceRecord& raw, const auto& one) {
    if (one.experiment.name != "slot 3") return;
    const identify::CutOfRecord cut{one.experiment.condition.spindle_speed, 2};
    write_signals({.runs = {signals_of(raw, *one.processed, from.signals.chain, cut, "slot/3")}},
                  scratch("signals.h5"));
    const SignalRun run = read_signals(scratch("signals.h5")).runs.at(0);
    EXPECT_EQ(run.name, "slot_3");
    EXPECT_EQ(std::get<double>(run.attributes.at("cutoff_hz")), 800.0);
    EXPECT_THAT(run.signals, SizeIs(22));
    // Read again as a record, it is the one that it came from.
    const LoadedRecord again = read_force_record(scratch("signals.h5"));
    EXPECT_EQ(again.record.force, raw.force);
    EXPECT_EQ(again.record.tacho, raw.tacho);
  });
}

TEST(SignalFigures, ThinLongSignalsWithoutLosingAPeak) {
  identify::ForceRecord raw{.rate = 1e4, .force = Eigen::MatrixX3d::Random(100000, 3)};
  raw.force(54321, 1) = 77.0;
  identify::ProcessedRecord done;
  done.record = raw;
  done.segments.plateau = {0, 100000};
  for (auto& mean : done.mean) mean.standard_error = 0.1;
  const auto figures = figures_of(raw, done, 2, "noise");
  EXPECT_THAT(figures, SizeIs(4));
  const Series& y = figures[0].plot.panels[1].series[0];
  EXPECT_LE(y.x.size(), 2100u);
  EXPECT_EQ(*std::max_element(y.y.begin(), y.y.end()), 77.0);
}

}  // namespace
}  // namespace osteomill::io
