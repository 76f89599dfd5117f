// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/robot/size_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"

namespace osteomill::robot {
namespace {

using units::mm;

SizeStudyOptions coarse() {
  SizeStudyOptions options;
  options.step = 7.0 * mm;
  options.refine = false;
  return options;
}

TEST(ErrorMargin, IsRayleighsQuantileWithoutTilt) {
  const PlacementErrors errors{
      .position = 2.0 * mm, .varus_valgus = 0.0, .internal_external = 0.0, .samples = 20000};
  // The 95th percentile of 20 000 Rayleigh values is known to 1 % (three sigma).
  EXPECT_NEAR(error_margin(errors, 0.95), 2.0 * mm * std::sqrt(-2.0 * std::log(0.05)), 0.06 * mm);
  PlacementErrors tilted = errors;
  tilted.varus_valgus = tilted.internal_external = 1.0 * units::deg;
  EXPECT_GT(error_margin(tilted, 0.95), error_margin(errors, 0.95));
}

TEST(SizeErrors, KeepTheShareThatWasAskedFor) {
  const std::vector<ImplantFamily> families = {generic_family()};
  const SizeStudyOptions options = coarse();
  const PlacementErrors errors{.position = 1.0 * mm, .samples = 2000, .seed = 5};
  const SizeStudy nominal = study_sizes(families, options);
  const SizeErrorStudy study = study_size_errors(families, options, nominal, errors, 0.95);
  ASSERT_TRUE(study.largest.exists);
  // The same draws made the margin: no more than the other twentieth can be out of bounds.
  EXPECT_LE(study.largest.worst_share, 0.05);
  EXPECT_LE(study.mean.worst_share, 0.05);
  // [plaskos2006] 4.4.3: the optimum without a margin is a dangerous target, and the gap grows by
  // about 1 mm for each millimetre; to keep a circle clear of both sides of the allowed region's
  // tip its middle has to go farther than its radius.
  EXPECT_GT(study.nominal.share_forbidden, 0.4);
  EXPECT_GT(study.added_per_margin, 1.0);
  EXPECT_GT(study.with_margin.best_largest.value, nominal.best_largest.value);
  EXPECT_GT(study.largest.gap_95, study.largest.mean_gap);
}

TEST(SizeErrors, AreNothingWhereThereIsNoError) {
  const std::vector<ImplantFamily> families = {generic_family()};
  const SizeStudyOptions options = coarse();
  const PlacementErrors none{
      .position = 0.0, .varus_valgus = 0.0, .internal_external = 0.0, .samples = 100};
  const SizeStudy nominal = study_sizes(families, options);
  const SizeErrorStudy study = study_size_errors(families, options, nominal, none, 0.95);
  EXPECT_EQ(study.margin, 0.0);
  EXPECT_EQ(study.largest.share_forbidden, 0.0);
  EXPECT_EQ(study.with_margin.best_largest.value, nominal.best_largest.value);
  EXPECT_NEAR(study.largest.gap_95, nominal.best_largest.value, 1.1e-5);  // the grid's precision
}

TEST(SizeErrors, AreTheSameForTheSameSeed) {
  const PlacementErrors one{.seed = 3}, same{.seed = 3}, other{.seed = 4};
  EXPECT_EQ(error_margin(one, 0.9), error_margin(same, 0.9));
  EXPECT_NE(error_margin(one, 0.9), error_margin(other, 0.9));
  EXPECT_THROW(error_margin(one, 1.5), InvalidInput);
}

}  // namespace
}  // namespace osteomill::robot
