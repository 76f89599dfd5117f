// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/size_study.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::robot {
namespace {

using units::mm;

ImplantFamily family(double half, double anterior, double posterior) {
  ImplantFamily one = generic_family();
  one.distal_half_length = half;
  one.anterior = anterior;
  one.posterior = posterior;
  return one;
}

const std::vector<ImplantFamily> kFamilies = {generic_family(), family(0.22, 0.50, 0.45),
                                              family(0.27, 0.55, 0.47)};

TEST(SizeStudy, FindsTheBestLengthsThatThePlainLoopFinds) {
  SizeStudyOptions options;
  options.step = 5.0 * mm;
  options.refine = false;
  const SizeStudy study = study_sizes(kFamilies, options);
  ASSERT_EQ(study.l1.size(), 8u);
  ASSERT_EQ(study.l2.size(), 8u);
  double best = 1.0;
  for (const double l1 : study.l1) {
    for (const double l2 : study.l2) {
      double worst = 0.0;
      for (const ImplantFamily& one : kFamilies) {
        for (int size = 1; size <= 7; ++size) {
          const Placement placement =
              place({.link1 = l1, .link2 = l2}, cut_lines(profile_of(one, size)));
          worst = std::max(worst, placement.feasible ? placement.largest_gap : 1.0);
        }
      }
      best = std::min(best, worst);
    }
  }
  // The grid of the study is placed to 1e-5 m.
  EXPECT_NEAR(study.best_largest.value, best, 1.1e-5);
  EXPECT_EQ(study.placements, 8 * 8 * 3 * 7);
}

TEST(SizeStudy, FollowsThePublishedTrends) {
  SizeStudyOptions options;
  options.step = 2.5 * mm;
  const SizeStudy study = study_sizes(kFamilies, options);
  // [plaskos2006] Table 4.6: L1 at its upper bound for every shape, smallest gaps of 3.7 to 10.7
  // mm.
  for (const LinkChoice& best : study.best_per_family) {
    ASSERT_TRUE(best.exists);
    EXPECT_NEAR(best.l1, 75.0 * mm, 1e-6);
    EXPECT_LE(best.slope_l1, 0.0);
  }
  // Table 4.7 against 4.3: the mean is smaller at [75, 20] than at [60, 30].
  const auto mean_at = [](double l1, double l2) {
    double sum = 0.0;
    for (const ImplantFamily& one : kFamilies) {
      std::vector<PerCut<CutLine>> sizes;
      for (int size = 1; size <= 7; ++size) sizes.push_back(cut_lines(profile_of(one, size)));
      sum += largest_over_sizes({.link1 = l1 * mm, .link2 = l2 * mm}, sizes, {}).value();
    }
    return sum / 3.0;
  };
  EXPECT_LT(mean_at(75.0, 20.0), mean_at(60.0, 30.0));
  EXPECT_LE(study.best_mean.value, mean_at(75.0, 20.0) + 1e-6);
  EXPECT_LE(study.best_mean.value, study.best_largest.value);
}

TEST(SizeStudy, DoesNotDependOnTheNumberOfThreads) {
  SizeStudyOptions options;
  options.step = 10.0 * mm;
  const SizeStudy many = study_sizes(kFamilies, options);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const SizeStudy one = study_sizes(kFamilies, options);
  EXPECT_EQ(many.largest, one.largest);
  EXPECT_EQ(many.mean, one.mean);
  EXPECT_EQ(many.best_mean.l2, one.best_mean.l2);
  EXPECT_EQ(many.best_largest.slope_l2, one.best_largest.slope_l2);
}

TEST(SizeStudy, WithASlideTheRobotMayBeCompact) {
  SizeStudyOptions options;
  options.step = 5.0 * mm;
  options.slide_stroke = 30.0 * mm;
  options.refine = false;
  const SizeStudy study = study_sizes(kFamilies, options);
  ASSERT_TRUE(study.most_compact.exists);
  EXPECT_LT(study.most_compact.l1, study.best_largest.l1);
  EXPECT_LE(study.most_compact.value, options.slide_stroke);
}

TEST(SizeStudy, StopsWhenAskedAndRefusesNonsense) {
  SizeStudyOptions options;
  options.step = 5.0 * mm;
  EXPECT_TRUE(study_sizes(kFamilies, options, [](auto, double) { return false; }).stopped);
  EXPECT_THROW(study_sizes({}, options), InvalidInput);
  options.step = 0.0;
  EXPECT_THROW(study_sizes(kFamilies, options), InvalidInput);
  options = {};
  options.l1_low = 0.08;
  EXPECT_THROW(study_sizes(kFamilies, options), InvalidInput);
  options = {};
  options.step = 1e-6;
  EXPECT_THROW(study_sizes(kFamilies, options), InvalidInput);
}

}  // namespace
}  // namespace osteomill::robot
