// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/cross_validation.hpp"

#include <gtest/gtest.h>

#include "osteomill/identify/experiments_for_test.hpp"

namespace osteomill::identify {
namespace {

using namespace for_test;

TEST(CrossValidation, ByTheHatMatrixEqualsFittingAgain) {
  for (const double ridge : {0.0, 1e-3}) {
    std::vector<Experiment> cuts = plan(ball());
    const ForceModel model{.form = LawForm::polynomial, .shear_order = 2, .edge_order = 1};
    measure(cuts, law_of({}, bone()), 0.5, 4);
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      cuts[i].standard_error.setConstant(0.1 + 0.01 * static_cast<double>(i));
    }
    const FitOptions options{.ridge = ridge, .bounds = {}};
    const MeanForceFit fit = fit_mean_forces(cuts, model, options);
    for (const auto& folds : {leave_one_out(cuts), leave_one_group_out(cuts)}) {
      ASSERT_GT(folds.size(), 1U);
      const CrossValidation fast = cross_validate(cuts, fit, options, folds);
      const CrossValidation slow = cross_validate_by_refit(cuts, fit, options, folds);
      ASSERT_TRUE(fast.complete);
      ASSERT_TRUE(slow.complete);
      for (std::size_t i = 0; i < cuts.size(); ++i) {
        EXPECT_LT((*fast.error[i] - *slow.error[i]).norm(), 1e-10 * fast.rms);
      }
      EXPECT_NEAR(fast.rms, slow.rms, 1e-10 * slow.rms);
    }
  }
}

TEST(CrossValidation, IsTheErrorOfAPredictionOfTheCutThatWasLeftOut) {
  std::vector<Experiment> cuts = plan(end_mill());
  const ForceModel model{.form = LawForm::power};
  measure(cuts, law_of({}, bone()), 0.2, 4);
  const CrossValidation result =
      cross_validate(cuts, fit_mean_forces(cuts, model), {}, leave_one_out(cuts));
  std::vector<Experiment> rest(cuts.begin() + 1, cuts.end());
  const MeanForceFit without = fit_mean_forces(rest, model);
  const Eigen::Vector3d error =
      cuts[0].mean_force - mean_forces(law_of(model, without.values), {cuts[0]});
  // Both searches end within 1e-11 of their minimum in each coefficient.
  EXPECT_LT((*result.error[0] - error).norm(), 1e-6);
}

TEST(CrossValidation, SaysWhichCutTheOthersDoNotDetermine) {
  // One feed but for one cut: without it shear and edge cannot be told apart.
  std::vector<Experiment> cuts;
  for (const double depth : {0.5, 1.0, 1.5, 2.0}) cuts.push_back(cut(end_mill(), depth, 0.01));
  cuts.push_back(cut(end_mill(), 1.0, 0.03));
  for (std::size_t i = 0; i < cuts.size(); ++i) cuts[i].name = "cut " + std::to_string(i);
  measure(cuts, law_of({}, bone()), 0.1, 1);
  const MeanForceFit fit = fit_mean_forces(cuts, {});
  for (const CrossValidation& result :
       {cross_validate(cuts, fit, {}, leave_one_out(cuts)),
        cross_validate_by_refit(cuts, fit, {}, leave_one_out(cuts))}) {
    EXPECT_FALSE(result.complete);
    ASSERT_EQ(result.undetermined.size(), 1U);
    EXPECT_EQ(result.undetermined[0], "cut 4");
  }
  EXPECT_TRUE(leave_one_group_out(cuts).empty());
}

}  // namespace
}  // namespace osteomill::identify
