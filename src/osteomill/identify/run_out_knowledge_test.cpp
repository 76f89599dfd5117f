// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/run_out_knowledge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/random.hpp"
#include "osteomill/identify/experiments_for_test.hpp"
#include "osteomill/identify/mean_force_identification.hpp"

namespace osteomill::identify {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr double kOffset = 3e-6;
constexpr double kAngle = 0.8;

/// Slots of a two-flute cutter with run-out; the cutter that stands in the table runs true.
std::vector<Experiment> cuts(double noise, double offset = kOffset, std::uint64_t seed = 1) {
  cutting::Cutter cutter = for_test::end_mill();
  cutter.flutes = 2;
  cutter.run_out = {offset, kAngle, 0.0, 0.0};
  std::vector<Experiment> made;
  for (const double feed : {0.015, 0.03, 0.06, 0.12}) {
    made.push_back(for_test::cut(cutter, 2.0, feed));
    made.back().name = std::to_string(made.size());
    made.push_back(for_test::cut(cutter, 2.0, feed, cutting::ImmersionKind::down));
    made.back().name = std::to_string(made.size());
  }
  for_test::measure(made, law_of(ForceModel{}, for_test::bone()), noise, seed);
  for (Experiment& one : made) one.cutter.run_out = {};
  return made;
}

InstantaneousFit found(double x, double y, double error) {
  InstantaneousFit fit;
  fit.covariance = Eigen::Matrix2d::Identity() * error * error;
  for (const auto& [name, value] : {std::pair{"run_out_x", x}, {"run_out_y", y}}) {
    Estimate one;
    one.name = name;
    one.value = value;
    fit.estimates.push_back(one);
  }
  return fit;
}

const Eigen::Vector2d kRunOut = kOffset * Eigen::Vector2d(std::cos(kAngle), std::sin(kAngle));

TEST(RunOutKnowledge, OfOneClampingIsCombinedWhicheverFluteItWasCountedFrom) {
  std::vector<Experiment> made = cuts(0.0);
  // The second record counts from the other flute.
  const auto known = run_out_of_records(
      {found(kRunOut.x(), kRunOut.y(), 1e-7), found(-kRunOut.x() + 1e-7, -kRunOut.y(), 1e-7)},
      {0, 3}, made);
  EXPECT_EQ(known.source, RunOutSource::records);
  EXPECT_TRUE(known.one_clamping);
  // Their mean, with the error of a mean of two.
  EXPECT_NEAR(known.offset, (kRunOut - Eigen::Vector2d(0.5e-7, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(known.standard_error, 1e-7 / std::numbers::sqrt2, 1e-12);
  for (const Experiment& one : made) EXPECT_EQ(one.cutter.run_out.offset, known.offset);
  const MeanForceFit fit = fit_mean_forces(made, {});
  const MeanForceFit blind = without_run_out(made, {}, {});
  // Half a tenth of a micron of the three is missing; ignoring them all costs many times as much.
  for (Eigen::Index i = 3; i < 5; ++i) {
    const double truth = for_test::bone()(i);
    EXPECT_GT(std::abs(blind.values(i) - truth), 10.0 * std::abs(fit.values(i) - truth));
  }
}

TEST(RunOutKnowledge, ThatDiffersByMoreThanItsErrorsStaysWithItsCut) {
  std::vector<Experiment> made = cuts(0.0);
  const auto known =
      run_out_of_records({found(2e-6, 0.0, 1e-7), found(4e-6, 0.0, 1e-7)}, {0, 1}, made);
  EXPECT_FALSE(known.one_clamping);
  EXPECT_EQ(made[0].cutter.run_out.offset, 2e-6);
  EXPECT_EQ(made[1].cutter.run_out.offset, 4e-6);
  EXPECT_EQ(made[2].cutter.run_out.offset, 0.0);
  EXPECT_EQ(known.errors.size(), 4U);
}

TEST(RunOutKnowledge, OfRecordsThatDoNotTellItIsUnknown) {
  std::vector<Experiment> made = cuts(0.0);
  InstantaneousFit open = found(0.0, 0.0, 1e-7);
  for (Estimate& one : open.estimates) one.determined = false;
  const auto known = run_out_of_records({open}, {2}, made);
  EXPECT_EQ(known.source, RunOutSource::unknown);
  EXPECT_THAT(known.left_out, testing::ElementsAre("3"));
}

TEST(RunOutKnowledge, PutsItsErrorIntoTheCovariance) {
  // Coefficients scatter as their errors say when the run-out that they were told does.
  constexpr double kError = 0.5e-6;
  constexpr int kTrials = 150;
  double square = 0.0;
  double stated = 0.0;
  double without = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<Experiment> made = cuts(0.02, kOffset, static_cast<std::uint64_t>(trial));
    Random random(7, static_cast<std::uint64_t>(trial));
    const auto known = run_out_of_records({found(kRunOut.x() + kError * random.normal(),
                                                 kRunOut.y() + kError * random.normal(), kError)},
                                          {0}, made);
    MeanForceFit fit = fit_mean_forces(made, {});
    without += std::pow(fit.coefficients[3].standard_error, 2) / kTrials;
    allow_for_run_out(made, {}, known, fit);
    square += std::pow(fit.values(3) - for_test::bone()(3), 2) / kTrials;
    stated += std::pow(fit.coefficients[3].standard_error, 2) / kTrials;
  }
  // A variance of 150 trials is good to 12 %, twice that for two standard deviations.
  EXPECT_NEAR(square / stated, 1.0, 0.23);
  // It is what the errors consist of here.
  EXPECT_GT(stated, 2.0 * without);
}

TEST(RunOutKnowledge, ThatIsOnlyABoundGoesIntoTheIntervalsAndIntoWords) {
  const std::vector<Experiment> made = cuts(0.02);
  SelectionOptions options;
  options.run_out = stated_run_out(made, 0.0, 0.0);
  const auto blind = identify_mean_forces(made, {{}}, options);
  EXPECT_THAT(blind.verdict, Contains(HasSubstr("hold only for a cutter that runs true")));
  options.run_out = stated_run_out(made, 0.0, kOffset);
  const auto wide = identify_mean_forces(made, {{}}, options);
  EXPECT_THAT(wide.verdict, Contains(HasSubstr("Run-out of 3 um would change")));
  int missed = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    const double truth = for_test::bone()(static_cast<Eigen::Index>(i));
    const Coefficient& narrow = blind.best().fit->coefficients[i];
    const Coefficient& one = wide.best().fit->coefficients[i];
    missed += truth < narrow.low || truth > narrow.high ? 1 : 0;
    EXPECT_LE(one.low, truth) << one.name;
    EXPECT_GE(one.high, truth) << one.name;
    EXPECT_EQ(one.standard_error, narrow.standard_error);
  }
  EXPECT_GT(missed, 1);
}

TEST(RunOutKnowledge, MattersToNoCutterOfOneFlute) {
  std::vector<Experiment> made = cuts(0.02);
  for (Experiment& one : made) one.cutter.flutes = 1;
  EXPECT_EQ(stated_run_out(made, 0.0, 0.0).source, RunOutSource::stated);
}

}  // namespace
}  // namespace osteomill::identify
