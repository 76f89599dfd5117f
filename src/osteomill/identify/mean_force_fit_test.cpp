// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/mean_force_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/identify/experiments_for_test.hpp"

namespace osteomill::identify {
namespace {

using namespace for_test;
using Eigen::VectorXd;
using testing::HasSubstr;

// Altintas' closed form for a slot with N flutes, helix without meaning for the mean:
// Fx = -N a (Krc c / 4 + Kre / pi), Fy = N a (Ktc c / 4 + Kte / pi), Fz = N a (Kac c / pi + Kae /
// 2).
TEST(MeanForceFit, HasTheClosedFormOfASlotAsItsDesignMatrix) {
  const Experiment one = cut(end_mill(), 2.0, 0.01);
  const Eigen::MatrixXd columns = sensitivities(ForceModel{}, {}, {one});
  const double na = 4.0 * 2.0 * units::mm, c = 0.01 * units::mm, pi = std::numbers::pi;
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(3, 6);
  expected(0, 1) = -na * c / 4.0;
  expected(0, 4) = -na / pi;
  expected(1, 0) = na * c / 4.0;
  expected(1, 3) = na / pi;
  expected(2, 2) = na * c / pi;
  expected(2, 5) = na / 2.0;
  // mean_load promises 1e-5 relative.
  for (Eigen::Index i = 0; i < 6; ++i) {
    EXPECT_LT((columns.col(i) - expected.col(i)).norm(), 1e-5 * expected.col(i).norm()) << i;
  }
}

TEST(MeanForceFit, GivesBackTheCoefficientsOfForcesWithoutNoise) {
  struct Case {
    ForceModel model;
    cutting::Cutter cutter;
    VectorXd values;
  };
  const double p = units::n_per_mm2, f = units::n_per_mm;
  const std::vector<Case> cases = {
      {{}, end_mill(), bone()},
      {{.form = LawForm::polynomial, .shear_order = 1, .edge_order = 0},
       ball(),
       VectorXd{{180.0 * p, 90.0 * p, 40.0 * p, 60.0 * p, -20.0 * p, 10.0 * p, 3.0 * f, 4.0 * f,
                 -1.0 * f}}},
      {{.form = LawForm::log},
       end_mill(),
       VectorXd{{0.35, 0.62, -0.08, 0.64, 0.30, -0.10, -0.19, 0.62, -0.07}}},
      {{.form = LawForm::power, .edge_force = true},
       end_mill(),
       VectorXd{{80.0 * f, 0.7, 1.0 * f, 40.0 * f, 0.5, 2.0 * f, 20.0 * f, 0.8, 0.5 * f}}}};
  for (const Case& one : cases) {
    std::vector<Experiment> cuts = plan(one.cutter);
    measure(cuts, law_of(one.model, one.values), 0.0, 1);
    const MeanForceFit fit = fit_mean_forces(cuts, one.model);
    EXPECT_EQ(fit.status, "fitted") << name_of(one.model);
    for (Eigen::Index i = 0; i < one.values.size(); ++i) {
      // Conditions up to 1e4 on sums that are exact to 1e-13.
      EXPECT_NEAR(fit.values(i), one.values(i), 1e-6 * std::abs(one.values(i)))
          << name_of(one.model) << " " << fit.coefficients[static_cast<std::size_t>(i)].name;
    }
  }
}

TEST(MeanForceFit, StatesErrorsThatTheTruthKeeps) {
  std::vector<Experiment> cuts = plan(end_mill());
  int inside = 0, within_three = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    measure(cuts, law_of({}, bone()), 0.5, seed);
    const MeanForceFit fit = fit_mean_forces(cuts, {});
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Coefficient& one = fit.coefficients[static_cast<std::size_t>(i)];
      const double truth = bone()(i);
      inside += one.low <= truth && truth <= one.high ? 1 : 0;
      within_three += std::abs(one.value - truth) <= 3.0 * one.standard_error ? 1 : 0;
      ++count;
    }
  }
  // 1800 intervals: the standard deviation of the share is 0.5 %, four of them 2 %.
  EXPECT_NEAR(static_cast<double>(inside) / count, 0.95, 0.02);
  EXPECT_GT(static_cast<double>(within_three) / count, 0.99);
}

TEST(MeanForceFit, IsTheSameInAnotherOrderOfTheCutsAndScalesWithTheForces) {
  std::vector<Experiment> cuts = plan(ball());
  const ForceModel model{.form = LawForm::polynomial, .shear_order = 1, .edge_order = 1};
  measure(cuts, law_of({}, bone()), 0.5, 3);
  const MeanForceFit fit = fit_mean_forces(cuts, model);
  std::vector<Experiment> turned(cuts.rbegin(), cuts.rend());
  for (Experiment& one : turned) one.mean_force *= 7.0;
  const MeanForceFit other = fit_mean_forces(turned, model);
  for (Eigen::Index i = 0; i < fit.values.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double error = fit.coefficients[k].standard_error;
    EXPECT_NEAR(other.values(i), 7.0 * fit.values(i), 1e-8 * error);
    EXPECT_NEAR(other.coefficients[k].standard_error, 7.0 * error, 1e-8 * error);
  }
  EXPECT_NEAR(other.condition_number, fit.condition_number, 1e-8 * fit.condition_number);
}

TEST(MeanForceFit, WeighsEachMeanByItsStandardError) {
  std::vector<Experiment> cuts = plan(end_mill());
  measure(cuts, law_of({}, bone()), 0.1, 5);
  for (Experiment& one : cuts) one.standard_error.setConstant(0.1);
  // A bad cut that says so does not matter; one that does not, does. This one is deep and fast.
  cuts[33].mean_force.y() += 50.0;
  const double unsaid = fit_mean_forces(cuts, {}).values(0) - bone()(0);
  cuts[33].standard_error.setConstant(1000.0);
  const MeanForceFit fit = fit_mean_forces(cuts, {});
  EXPECT_TRUE(fit.weighted);
  EXPECT_LT(std::abs(fit.values(0) - bone()(0)), 3.0 * fit.coefficients[0].standard_error);
  EXPECT_GT(std::abs(unsaid), 10.0 * fit.coefficients[0].standard_error);
  // 0.1 N of noise under standard errors of 0.1 N.
  EXPECT_NEAR(fit.residual_deviation, 1.0, 0.3);
}

TEST(MeanForceFit, RobustLossesAreNotMovedFarByAnOutlier) {
  std::vector<Experiment> cuts = plan(end_mill());
  measure(cuts, law_of({}, bone()), 0.2, 6);
  const MeanForceFit clean = fit_mean_forces(cuts, {});
  cuts[10].mean_force.y() += 40.0;
  const auto shift = [&](Loss loss) {
    const MeanForceFit fit = fit_mean_forces(cuts, {}, {.loss = loss, .bounds = {}});
    EXPECT_EQ(fit.status, "fitted");
    if (loss != Loss::squares) {
      EXPECT_LT(fit.robust_weight(10, 1), 0.1);
    }
    return (fit.values - clean.values)
        .cwiseQuotient(clean.covariance.diagonal().cwiseSqrt())
        .cwiseAbs()
        .maxCoeff();
  };
  EXPECT_GT(shift(Loss::squares), 5.0);
  EXPECT_LT(shift(Loss::huber), 1.0);
  EXPECT_LT(shift(Loss::tukey), 0.5);
}

TEST(MeanForceFit, AnOutlierHasTheLargestCookDistance) {
  std::vector<Experiment> cuts = plan(end_mill());
  measure(cuts, law_of({}, bone()), 0.2, 6);
  cuts[10].mean_force.y() += 40.0;
  const MeanForceFit fit = fit_mean_forces(cuts, {});
  Eigen::Index worst = 0;
  fit.cook_distance.maxCoeff(&worst);
  EXPECT_EQ(worst, 10);
  // The trace of a projection is its rank.
  EXPECT_NEAR(fit.leverage.sum(), 6.0, 1e-9);
}

TEST(MeanForceFit, CookDistanceIsTheShiftOfAllPredictionsWithoutTheCut) {
  std::vector<Experiment> cuts = plan(end_mill());
  measure(cuts, law_of({}, bone()), 0.5, 8);
  const MeanForceFit fit = fit_mean_forces(cuts, {});
  std::vector<Experiment> rest = cuts;
  rest.erase(rest.begin() + 5);
  const VectorXd shift = fit.sensitivity * (fit.values - fit_mean_forces(rest, {}).values);
  const double expected = shift.squaredNorm() / (6.0 * std::pow(fit.residual_deviation, 2.0));
  EXPECT_NEAR(fit.cook_distance(5), expected, 1e-9 * expected);
}

TEST(MeanForceFit, BoundsHoldAndTheRestIsTheLeastSquaresOfWhatIsFree) {
  std::vector<Experiment> cuts = plan(end_mill());
  VectorXd values = bone();
  values(3) = -2.0 * units::n_per_mm;
  measure(cuts, law_of({}, values), 0.2, 9);
  FitOptions options;
  options.bounds = {{.coefficient = "Kte", .low = 0.0}};
  const MeanForceFit fit = fit_mean_forces(cuts, {}, options);
  EXPECT_TRUE(fit.coefficients[3].at_bound);
  EXPECT_EQ(fit.values(3), 0.0);
  Eigen::MatrixXd others(fit.sensitivity.rows(), 5);
  others << fit.sensitivity.leftCols(3), fit.sensitivity.rightCols(2);
  // Normal equations of the free columns.
  const VectorXd slope =
      others.transpose() * (measured_forces(cuts) - fit.sensitivity * fit.values);
  const VectorXd size = others.colwise().norm() * measured_forces(cuts).norm();
  EXPECT_LT(slope.cwiseQuotient(size).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(MeanForceFit, ARidgePullsTheCoefficientsTogetherAndLowersTheirErrors) {
  std::vector<Experiment> cuts = plan(ball());
  const ForceModel model{.form = LawForm::polynomial, .shear_order = 3, .edge_order = 1};
  measure(cuts, law_of({}, bone()), 1.0, 2);
  const MeanForceFit loose = fit_mean_forces(cuts, model);
  const MeanForceFit tight = fit_mean_forces(cuts, model, {.ridge = 1e-3, .bounds = {}});
  EXPECT_LT(tight.coefficients[0].standard_error, loose.coefficients[0].standard_error);
  EXPECT_GT(tight.degrees_of_freedom, loose.degrees_of_freedom);
  EXPECT_GE(tight.residual_rms_all, loose.residual_rms_all);
}

TEST(MeanForceFit, NamesWhatItCannotUse) {
  std::vector<Experiment> cuts = plan(end_mill());
  measure(cuts, law_of({}, bone()), 0.2, 1);
  const auto message = [](const std::vector<Experiment>& with, const ForceModel& model,
                          const FitOptions& options = {}) -> std::string {
    try {
      fit_mean_forces(with, model, options);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(message({}, {}), HasSubstr("at least one cut"));
  EXPECT_THAT(message({cuts[0], cuts[1]}, {}), HasSubstr("must give more than the 6 unknowns"));
  EXPECT_THAT(message({cuts[0], cuts[1]}, {}), HasSubstr("cut at least 3 times"));
  std::vector<Experiment> one_feed;
  for (const Experiment& one : cuts) {
    if (one.condition.feed_per_tooth == cuts[0].condition.feed_per_tooth &&
        one.immersion.kind == cutting::ImmersionKind::slot) {
      one_feed.push_back(one);
    }
  }
  EXPECT_THAT(message(one_feed, {}), HasSubstr("do not tell apart"));
  EXPECT_THAT(message(one_feed, {}), HasSubstr("Ktc"));
  EXPECT_THAT(message(cuts, {.form = LawForm::polynomial, .shear_order = 2}),
              HasSubstr("a cylinder has one kappa"));
  std::vector<Experiment> broken = cuts;
  broken[3].mean_force.x() = std::nan("");
  EXPECT_THAT(message(broken, {}), HasSubstr("experiments." + broken[3].name));
  EXPECT_THAT(message(cuts, {}, {.weighting = Weighting::standard_errors, .bounds = {}}),
              HasSubstr("standard errors > 0"));
  EXPECT_THAT(message(cuts, {}, {.bounds = {{.coefficient = "Kxx"}}}), HasSubstr("known: Ktc"));
  EXPECT_THAT(message(cuts, {}, {.bounds = {{.coefficient = "Ktc", .low = 2.0, .high = 1.0}}}),
              HasSubstr("must leave room"));
}

}  // namespace
}  // namespace osteomill::identify
