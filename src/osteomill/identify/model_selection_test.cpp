// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/model_selection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "osteomill/base/error.hpp"
#include "osteomill/identify/experiments_for_test.hpp"

namespace osteomill::identify {
namespace {

using namespace for_test;

std::vector<std::string> names_of(const std::vector<Candidate>& all) {
  std::vector<std::string> names;
  for (const Candidate& one : all) names.push_back(one.name);
  return names;
}

const Candidate& chosen(const std::vector<Candidate>& all) {
  for (const Candidate& one : all) {
    if (one.chosen) return one;
  }
  throw std::logic_error("none chosen");
}

TEST(ModelSelection, ChoosesTheModelThatMadeTheForces) {
  std::vector<Experiment> cuts = plan(ball());
  const ForceModel truth{.form = LawForm::polynomial, .shear_order = 1, .edge_order = 0};
  const double p = units::n_per_mm2, f = units::n_per_mm;
  const Eigen::VectorXd values{
      {180.0 * p, 90.0 * p, 40.0 * p, 150.0 * p, -80.0 * p, 60.0 * p, 3.0 * f, 4.0 * f, -1.0 * f}};
  measure(cuts, law_of(truth, values), 0.02, 12);
  const SelectionOptions options{.fit = {}, .largest_shear_order = 2, .largest_edge_order = 1};
  std::vector<ForceModel> models;
  for (const ForceModel& model : models_to_try(cuts, options)) {
    if (is_linear(model)) models.push_back(model);  // the others take seconds
  }
  EXPECT_EQ(models.size(), 11U);
  EXPECT_EQ(chosen(rank_models(cuts, models, options)).name, "shear order 1, edge order 0");
}

TEST(ModelSelection, TellsPowerFromLinearWhenTheForcesDo) {
  std::vector<Experiment> cuts = plan(end_mill());
  const double f = units::n_per_mm;
  const Eigen::VectorXd values{{60.0 * f, 0.5, 40.0 * f, 0.4, 20.0 * f, 0.6}};
  measure(cuts, law_of({.form = LawForm::power}, values), 0.05, 2);
  const std::vector<ForceModel> models = {
      {}, {.form = LawForm::power}, {.form = LawForm::power, .edge_force = true}};
  EXPECT_EQ(chosen(rank_models(cuts, models, {})).name, "power");
}

TEST(ModelSelection, RankingDoesNotDependOnOrderOfCutsOrModelsNorOnTheSizeOfForces) {
  std::vector<Experiment> cuts = plan(ball());
  measure(cuts, law_of(ForceModel{}, bone()), 0.5, 21);
  const SelectionOptions options{.fit = {}, .largest_shear_order = 2, .largest_edge_order = 1};
  std::vector<ForceModel> models;
  for (const ForceModel& model : models_to_try(cuts, options)) {
    if (is_linear(model)) models.push_back(model);
  }
  const auto first = rank_models(cuts, models, options);
  std::vector<Experiment> turned(cuts.rbegin(), cuts.rend());
  for (Experiment& one : turned) one.mean_force *= 1000.0;
  const std::vector<ForceModel> backwards(models.rbegin(), models.rend());
  const auto second = rank_models(turned, backwards, options);
  EXPECT_EQ(names_of(first), names_of(second));
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].chosen, second[i].chosen);
    EXPECT_EQ(first[i].tied, second[i].tied);
    EXPECT_NEAR(1e6 * first[i].excess, second[i].excess, 1e-6 * 1e6 * first[0].leave_one->rms);
  }
}

TEST(ModelSelection, NamesAsTiesWhatTheDataDoNotTellApart) {
  std::vector<Experiment> cuts = plan(end_mill());
  Eigen::VectorXd values = bone();
  values(3) = values(4) = values(5) = 0.0;
  measure(cuts, law_of(ForceModel{}, values), 1.0, 3);
  const auto all = rank_models(cuts, {{}, {.shear_order = 0, .edge_order = -1}}, {});
  EXPECT_EQ(chosen(all).name, "linear without edge force");
  for (const Candidate& one : all) {
    if (one.tied) {
      EXPECT_LE(one.excess, one.excess_error);
    }
  }
}

TEST(ModelSelection, SaysWhyAModelIsNotRankedAndFailsOnlyWhenNoneIs) {
  std::vector<Experiment> cuts = {cut(end_mill(), 1.0, 0.01), cut(end_mill(), 1.0, 0.02),
                                  cut(end_mill(), 2.0, 0.03)};
  measure(cuts, law_of(ForceModel{}, bone()), 0.1, 3);
  const auto all = rank_models(cuts, {{.form = LawForm::log}, {}}, {});
  EXPECT_EQ(all.front().name, "linear");
  EXPECT_THAT(all.back().not_ranked, testing::HasSubstr("must give more than the 9 unknowns"));
  EXPECT_THROW(rank_models(cuts, {{.form = LawForm::log}}, {}), InvalidInput);
  SelectionOptions grouped;
  grouped.rank_by = RankBy::leave_one_group_out;
  EXPECT_THROW(rank_models(cuts, {{}}, grouped), InvalidInput);
}

}  // namespace
}  // namespace osteomill::identify
