// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/segments.hpp"

#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/identify/baseline.hpp"
#include "osteomill/identify/record_for_test.hpp"

namespace osteomill::identify {
namespace {

double seconds(Eigen::Index i) { return static_cast<double>(i) / 8000.0; }

TEST(Segments, FindEntryAndExitOfACut) {
  for (const double noise : {0.0, 0.5, 2.0}) {
    RecordForTest truth;
    truth.noise = noise;
    const Segmentation found = segment(truth.make());
    ASSERT_EQ(found.cuts.size(), 1u) << noise;
    // The force begins within one tooth period of the entry, 6 ms.
    EXPECT_NEAR(seconds(found.cuts[0].begin), 0.5, 0.006) << noise;
    EXPECT_NEAR(seconds(found.cuts[0].end), 2.5, 0.006) << noise;
    ASSERT_EQ(found.idle.size(), 2u) << noise;
    EXPECT_LT(seconds(found.idle[0].end), 0.5) << noise;
    EXPECT_GT(seconds(found.idle[1].begin), 2.5) << noise;
    EXPECT_GT(found.plateau.begin, found.cuts[0].begin - 1) << noise;
    EXPECT_GT(found.plateau.size(), 0.9 * 16000) << noise;
    EXPECT_FALSE(found.whole);
    EXPECT_GT(found.steady, 0.99);
  }
}

TEST(Segments, DoNotMindOffsetAndDrift) {
  RecordForTest truth;
  truth.noise = 0.3;
  truth.offset = {40.0, -15.0, 120.0};
  truth.drift = {1.0, -2.0, 0.5};
  const Segmentation found = segment(truth.make());
  ASSERT_EQ(found.cuts.size(), 1u);
  EXPECT_NEAR(seconds(found.cuts[0].begin), 0.5, 0.006);
  EXPECT_NEAR(seconds(found.cuts[0].end), 2.5, 0.006);
  // Noise of 0.3 N in three axes.
  EXPECT_NEAR(found.idle_level, 0.3 * std::sqrt(3.0), 0.05);
}

TEST(Segments, LeaveTheRampOfTheEntryOutOfThePlateau) {
  RecordForTest truth;
  truth.noise = 0.2;
  ForceRecord record = truth.make();
  // The cutter takes half a second to come in.
  for (Eigen::Index i = 4000; i < 8000; ++i)
    record.force.row(i) *= static_cast<double>(i - 4000) / 4000.0;
  const Segmentation found = segment(record);
  EXPECT_LT(seconds(found.cuts[0].begin), 0.6);
  // The level is within 15 % of its median from 85 % of the ramp on, a window of 50 ms smears it.
  EXPECT_NEAR(seconds(found.plateau.begin), 0.5 + 0.85 * 0.5, 0.03);
}

TEST(Segments, TellALightCutBesideAHeavyOne) {
  RecordForTest heavy, light;
  heavy.noise = light.noise = 0.3;
  light.mean /= 6.0;
  light.ripple /= 6.0;
  const ForceRecord one = heavy.make(), two = light.make();
  ForceRecord both = one;
  both.force.resize(one.force.rows() + two.force.rows(), 3);
  both.force << one.force, two.force;
  const Segmentation found = segment(both);
  ASSERT_EQ(found.cuts.size(), 2u);
  EXPECT_NEAR(seconds(found.cuts[1].begin), 4.5 - 0.5, 0.51);
  EXPECT_EQ(found.idle.size(), 3u);
}

TEST(Segments, TakeARecordWithoutIdleTimeWhole) {
  RecordForTest truth;
  truth.idle = 0.0;
  truth.noise = 0.5;
  const Segmentation found = segment(truth.make());
  EXPECT_TRUE(found.whole);
  EXPECT_TRUE(found.idle.empty());
  EXPECT_EQ(found.cuts.size(), 1u);
  EXPECT_GT(found.plateau.size(), 0.95 * 16000);
}

TEST(Segments, ThePlateauCanBeGivenAndGuarded) {
  RecordForTest truth;
  const ForceRecord record = truth.make();
  SegmentOptions options;
  options.plateau = {{1.0, 1.25}};
  EXPECT_EQ(segment(record, options).plateau.begin, 8000);
  EXPECT_EQ(segment(record, options).plateau.size(), 2000);
  const Segmentation free = segment(record);
  const Segmentation guarded = segment(record, {.guard = 0.1, .plateau = {}});
  EXPECT_EQ(guarded.plateau.begin, free.plateau.begin + 800);
  EXPECT_EQ(guarded.plateau.end, free.plateau.end - 800);
}

TEST(Segments, RefuseWhatLeavesNothing) {
  RecordForTest truth;
  truth.cut = 0.3;
  const ForceRecord record = truth.make();
  EXPECT_THROW(segment(record, {.window = 0.0, .plateau = {}}), InvalidInput);
  EXPECT_THROW(segment(record, {.window = 10.0, .plateau = {}}), InvalidInput);
  EXPECT_THROW(segment(record, {.guard = 0.2, .plateau = {}}), InvalidInput);
  EXPECT_THROW(segment(record, {.plateau = {{1.0, 9.0}}}), InvalidInput);
  EXPECT_THROW(segment(record, {.plateau = {{0.8, 0.6}}}), InvalidInput);
}

TEST(CutOut, KeepsEveryChannel) {
  RecordForTest truth;
  truth.tacho = true;
  ForceRecord record = truth.make();
  record.torque = Eigen::VectorXd::LinSpaced(record.force.rows(), 0.0, 1.0);
  const ForceRecord part = cut_out(record, {100, 300});
  EXPECT_EQ(part.force.rows(), 200);
  EXPECT_EQ(part.tacho[0], record.tacho[100]);
  EXPECT_EQ(part.torque[199], record.torque[299]);
}

TEST(Baseline, TareAndDriftLeaveTheCut) {
  RecordForTest truth;
  const Eigen::Vector3d mean = truth.mean;
  truth.offset = {3.0, -5.0, 12.0};
  ForceRecord record = truth.make();
  const auto idle = segment(record).idle;
  const Baseline tare = remove_baseline(record, idle, BaselineKind::tare);
  EXPECT_LT((tare.first - truth.offset).norm(), 1e-9);
  const auto plateau = record.force.middleRows(8000, 9600);  // whole revolutions: 96 samples
  EXPECT_LT((plateau.colwise().mean().transpose() - mean).norm(), 1e-9);

  truth.drift = {2.0, 1.0, -3.0};
  record = truth.make();
  const auto drifting_idle = segment(record).idle;
  remove_baseline(record, drifting_idle, BaselineKind::drift);
  // The idle parts' middles lie on the line, so between them it is met exactly.
  EXPECT_LT((record.force.middleRows(8000, 9600).colwise().mean().transpose() - mean).norm(), 1e-9);
}

TEST(Baseline, NeedsIdleParts) {
  ForceRecord record = RecordForTest{}.make();
  EXPECT_THROW(remove_baseline(record, {}, BaselineKind::tare), InvalidInput);
  EXPECT_THROW(remove_baseline(record, {{0, 100}}, BaselineKind::drift), InvalidInput);
  EXPECT_NO_THROW(remove_baseline(record, {}, BaselineKind::none));
}

TEST(Gravity, IsTakenAwayAlsoWhileTheSensorTurns) {
  const double mass = 0.8, weight = 0.8 * 9.80665;
  const Eigen::Index n = 500;
  const Eigen::VectorXd angle = Eigen::VectorXd::LinSpaced(n, 0.0, 5.0);
  Eigen::MatrixX3d force(n, 3);
  // A sensor that turns about its z, held level: the weight turns backwards in its axes.
  for (Eigen::Index i = 0; i < n; ++i)
    force.row(i) << weight * std::cos(angle[i]) + 1.0, -weight * std::sin(angle[i]) + 2.0, 3.0;
  remove_gravity(force, mass,
                 turned_down(Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), angle));
  EXPECT_LT((force.rowwise() - Eigen::RowVector3d(1.0, 2.0, 3.0)).cwiseAbs().maxCoeff(), 1e-12);

  Eigen::MatrixX3d still = Eigen::MatrixX3d::Zero(4, 3);
  remove_gravity(still, mass, Eigen::RowVector3d(0.0, 0.0, -1.0));
  EXPECT_NEAR(still(3, 2), weight, 1e-12);
  EXPECT_THROW(remove_gravity(still, mass, Eigen::MatrixX3d::Zero(3, 3)), InvalidInput);
}

}  // namespace
}  // namespace osteomill::identify
