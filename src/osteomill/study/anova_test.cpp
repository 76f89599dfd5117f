// SPDX-License-Identifier: BSD-3-Clause
// The published analyses are in io/study_published_test.cpp; here are the laws.
#include "osteomill/study/anova.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"

namespace osteomill::study {
namespace {

Factor make_factor(const char* name, std::vector<int> level) {
  Factor factor{name, {}, std::move(level)};
  int most = 0;
  for (const int l : factor.level) most = std::max(most, l);
  for (int l = 0; l <= most; ++l) factor.levels.push_back(std::to_string(l));
  return factor;
}

RepeatedMeasures random_study(std::uint64_t seed) {
  // 7 subjects in two unequal groups, 2 x 3 cells.
  Random random(seed);
  RepeatedMeasures data;
  data.y.resize(7, 6);
  for (Eigen::Index i = 0; i < 7; ++i) {
    const double own = random.normal();
    for (Eigen::Index k = 0; k < 6; ++k) data.y(i, k) = own + random.normal();
  }
  data.between = {make_factor("g", {0, 0, 0, 0, 1, 1, 1})};
  data.within = {make_factor("a", {0, 0, 0, 1, 1, 1}), make_factor("b", {0, 1, 2, 0, 1, 2})};
  return data;
}

double f_of(const Anova& anova, const std::string& term) {
  for (const AnovaRow& row : anova.rows) {
    if (row.term == term) return row.f;
  }
  ADD_FAILURE() << term;
  return 0.0;
}

TEST(Anova, IsUnchangedByShiftAndScale) {
  const RepeatedMeasures data = random_study(1);
  RepeatedMeasures moved = data;
  moved.y = (1e4 + 3.0 * data.y.array()).matrix();
  const Anova a = analyse_variance(data), b = analyse_variance(moved);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  // 1e4 on values of size 1 costs four of sixteen digits.
  for (size_t r = 0; r < a.rows.size(); ++r) EXPECT_NEAR(a.rows[r].f, b.rows[r].f, 1e-9);
}

TEST(Anova, HasEveryTermWithItsDegreesOfFreedom) {
  const Anova anova = analyse_variance(random_study(2));
  ASSERT_EQ(anova.rows.size(), 7u);  // g, a, g:a, b, g:b, a:b, g:a:b
  double total = 0.0;
  for (const AnovaRow& row : anova.rows) total += row.df1;
  EXPECT_EQ(total, 1 + 1 + 1 + 2 + 2 + 2 + 2);
  for (const AnovaRow& row : anova.rows) EXPECT_EQ(row.df2, row.df1 * 5.0) << row.term;
}

TEST(Anova, OfTwoLevelsWithinIsThePairedTTestSquared) {
  RepeatedMeasures data;
  data.y.resize(5, 2);
  data.y << 1.0, 1.4, 0.2, 1.1, -0.4, 0.3, 0.8, 0.7, 1.5, 2.5;
  data.within = {make_factor("a", {0, 1})};
  std::vector<double> difference;
  for (Eigen::Index i = 0; i < 5; ++i) difference.push_back(data.y(i, 0) - data.y(i, 1));
  const double t = one_sample_t_test(moments(difference)).statistic;
  EXPECT_NEAR(f_of(analyse_variance(data), "a"), t * t, 1e-12);
}

TEST(Anova, TypesAgreeWhenBalancedAndDifferWhenNot) {
  RepeatedMeasures data = random_study(3);
  data.within.clear();
  const Eigen::VectorXd y = data.y.reshaped();
  RepeatedMeasures units{y, {make_factor("a", {}), make_factor("b", {})}, {}};
  std::vector<int> a, b;
  for (int i = 0; i < 42; ++i) {
    a.push_back(i % 2);
    b.push_back(i % 3);
  }
  units.between = {make_factor("a", a), make_factor("b", b)};
  for (const char* term : {"a", "b", "a:b"}) {
    const double first = f_of(analyse_variance(units, SumOfSquares::kI), term);
    EXPECT_NEAR(f_of(analyse_variance(units, SumOfSquares::kII), term), first, 1e-10);
    EXPECT_NEAR(f_of(analyse_variance(units, SumOfSquares::kIII), term), first, 1e-10);
  }
  units.y.conservativeResize(41, 1);
  for (Factor& factor : units.between) factor.level.pop_back();
  EXPECT_GT(std::abs(f_of(analyse_variance(units, SumOfSquares::kI), "a") -
                     f_of(analyse_variance(units, SumOfSquares::kIII), "a")),
            1e-4);
}

TEST(Sphericity, HoldsExactlyForOneVarianceOfAllDifferences) {
  // Residuals made orthonormal: the covariance of the contrasts is a multiple of one.
  RepeatedMeasures data;
  data.y.resize(4, 3);
  data.y << 1, 1, -1, 1, -1, 1, -1, 1, 1, -1, -1, -1;
  data.within = {make_factor("a", {0, 1, 2})};
  data.y.col(1).array() += 0.5;
  const Anova anova = analyse_variance(data);
  ASSERT_EQ(anova.sphericity.size(), 1u);
  EXPECT_NEAR(anova.sphericity[0].w, 1.0, 1e-12);
  EXPECT_NEAR(anova.sphericity[0].greenhouse_geisser, 1.0, 1e-12);
  EXPECT_NEAR(anova.rows[0].corrections[0].p, anova.rows[0].p, 1e-12);
}

// As where a bootstrap draws the same two subjects over and over.
TEST(Sphericity, IsRefusedWhereAContrastHasNoErrorOfItsOwn) {
  RepeatedMeasures data;
  data.y.resize(6, 3);
  for (Eigen::Index i = 0; i < 6; ++i) data.y.row(i) << 0.0, i % 2 == 0 ? 1.0 : 3.0, 0.0;
  data.within = {make_factor("technique", {0, 1, 2})};
  const Anova anova = analyse_variance(data);
  ASSERT_EQ(anova.sphericity.size(), 1u);
  EXPECT_NEAR(anova.sphericity[0].w, 0.0, 1e-12);
  EXPECT_NEAR(anova.sphericity[0].p, 0.0, 1e-12);
}

TEST(Sphericity, IsNotTestedWithTooFewSubjects) {
  RepeatedMeasures data = random_study(4);
  data.y.conservativeResize(3, 6);
  data.between.clear();
  const Anova anova = analyse_variance(data);
  EXPECT_TRUE(anova.sphericity[0].tested);  // b: 2 contrasts, 2 degrees of freedom
  data.within = {make_factor("c", {0, 1, 2, 3, 4, 5})};
  EXPECT_FALSE(analyse_variance(data).sphericity[0].tested);
}

TEST(Blocks, NameWhatTheyHide) {
  // A factor that is constant in each block cannot be told from the blocks.
  Eigen::VectorXd y(8);
  y << 1, 2, 1.5, 2.5, 4, 5, 3.5, 5.1;
  const Anova anova = analyse_blocks(
      y, {make_factor("block", {0, 0, 1, 1, 2, 2, 3, 3})},
      {make_factor("a", {0, 1, 0, 1, 0, 1, 0, 1}), make_factor("b", {0, 0, 0, 0, 1, 1, 1, 1})});
  ASSERT_EQ(anova.aliased.size(), 1u);
  EXPECT_EQ(anova.aliased[0], "b");
}

TEST(Anova, RefusesAStudyWithoutErrorToTestAgainst) {
  RepeatedMeasures data = random_study(5);
  data.between = {make_factor("s", {0, 1, 2, 3, 4, 5, 6})};
  EXPECT_THROW(analyse_variance(data), InvalidInput);
  data = random_study(5);
  data.y.setConstant(2.0);
  EXPECT_THROW(analyse_variance(data), InvalidInput);
}

TEST(Ancova, FindsTheSlopeAndRefusesAConstantCovariate) {
  Random random(6);
  Eigen::VectorXd y(20), x(20);
  std::vector<int> g;
  for (Eigen::Index i = 0; i < 20; ++i) {
    g.push_back(static_cast<int>(i % 2));
    x(i) = random.normal();
    y(i) = 2.0 * static_cast<double>(i % 2) + 0.7 * x(i) + 0.01 * random.normal();
  }
  const Ancova ancova = analyse_covariance(y, {make_factor("g", g)}, {{"x", x}});
  ASSERT_EQ(ancova.adjusted_means.size(), 2u);
  // Noise of 0.01 on ten cuts a group.
  EXPECT_NEAR(ancova.adjusted_means[1].mean - ancova.adjusted_means[0].mean, 2.0, 0.02);
  EXPECT_GT(ancova.slopes.at(0).p, 0.001);
  EXPECT_THROW(analyse_covariance(y, {}, {{"x", Eigen::VectorXd::Ones(20)}}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::study
