// SPDX-License-Identifier: BSD-3-Clause
// Analyses of published data against certified or published results. The tables and their designs
// lie in examples/study/published; sources in its README.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "osteomill/io/study_case.hpp"

namespace osteomill::io {
namespace {

using namespace study;

StudyReport analyse(const std::string& name) {
  const std::filesystem::path folder =
      std::filesystem::path(OSTEOMILL_SOURCE_DIR) / "examples/study/published";
  return analyse_study(read_study_table(folder / (name + ".csv")),
                       read_study_design(folder / (name + ".toml"), {}).design);
}

const TestRecord& find(const StudyReport& report, const std::string& name,
                       const std::string& term) {
  for (const TestRecord& test : report.tests) {
    if (test.name == name && test.term == term) return test;
  }
  throw std::runtime_error(name + ": " + term);
}

// Half a unit of the last digit that the source prints.
void expect_digits(double value, double printed, int decimals) {
  EXPECT_NEAR(value, printed, 0.5000001 * std::pow(10.0, -decimals));
}

TEST(PublishedStudy, SiRstvMeetsNistsCertifiedValues) {
  const StudyReport report = analyse("sirstv");
  const TestRecord& f = find(report, "ANOVA", "instrument");
  // The data have seven digits of which four are alike: as binary numbers they are off by 1.4e-14,
  // that is 1.4e-13 of the residual SD. The fifteen certified digits suppose exact decimals.
  EXPECT_NEAR(f.statistic / 1.18046237440255, 1.0, 1e-12);
  EXPECT_NEAR(report.variability.front().sd / 0.104076068334656, 1.0, 1e-12);
  EXPECT_EQ(f.df1, 4.0);
  EXPECT_EQ(*f.df2, 20.0);
}

TEST(PublishedStudy, SleepstudyMeetsRsRepeatedMeasures) {
  const StudyReport report = analyse("sleepstudy");
  const TestRecord& f = find(report, "repeated-measures ANOVA", "Days");
  expect_digits(f.statistic, 18.7027, 4);
  EXPECT_EQ(f.df1, 9.0);
  EXPECT_EQ(*f.df2, 153.0);
  ASSERT_GE(f.corrections.size(), 2u);
  expect_digits(f.corrections[0].epsilon, 0.3690, 4);
  expect_digits(f.corrections[1].epsilon, 0.4694, 4);
  // R prints 13 digits: anova(mlm, X = ~1, test = "Spherical") and mauchly.test.
  EXPECT_NEAR(f.corrections[0].p / 5.463091767581e-09, 1.0, 1e-10);
  EXPECT_NEAR(f.corrections[1].p / 7.076551753372e-11, 1.0, 1e-10);
  for (const AssumptionRecord& a : report.assumptions) {
    if (a.name != "sphericity (Mauchly)") continue;
    EXPECT_FALSE(a.holds);
    EXPECT_NEAR(a.statistic / 0.0002190204033943, 1.0, 1e-9);
    // Anderson's second-order term has 3 d with d = 9 contrasts; R 4.2 puts the 10 columns there
    // and prints 5.15488e-08.
    EXPECT_NEAR(a.p / 5.1500007099511e-08, 1.0, 1e-9);
  }
  // lme4: Reaction ~ factor(Days) + (1 | Subject), to the optimiser's digits.
  EXPECT_NEAR(report.components[0].component.sd, 37.08726644, 1e-4);
  EXPECT_NEAR(report.components[1].component.sd, 31.42592062, 1e-4);
}

TEST(PublishedStudy, OrthodontMeetsTheSplitPlot) {
  const StudyReport report = analyse("orthodont");
  expect_digits(find(report, "repeated-measures ANOVA", "Sex").statistic, 9.2921, 4);
  expect_digits(find(report, "repeated-measures ANOVA", "age").statistic, 40.03166, 5);
  expect_digits(find(report, "repeated-measures ANOVA", "Sex:age").statistic, 2.36156, 5);
}

TEST(PublishedStudy, NpkMeetsTheBlockedFactorialAndNamesWhatTheBlocksHide) {
  const StudyReport report = analyse("npk");
  expect_digits(find(report, "ANOVA in blocks", "N").statistic, 12.25873, 5);
  expect_digits(find(report, "ANOVA in blocks", "K").statistic, 6.16569, 5);
  expect_digits(find(report, "ANOVA in blocks", "P:K").statistic, 0.03119, 5);
  EXPECT_EQ(*find(report, "ANOVA in blocks", "N").df2, 12.0);
  // Between blocks, R's aov with Error(block): F(1, 4) = 0.48322.
  expect_digits(find(report, "mixed model", "N:P:K").statistic, 0.48322, 5);
  bool named = false;
  for (const Finding& finding : report.findings) {
    named = named || finding.what.find("N:P:K cannot be told") != std::string::npos;
  }
  EXPECT_TRUE(named);
}

TEST(PublishedStudy, ToothGrowthMeetsTheFactorial) {
  const StudyReport report = analyse("toothgrowth");
  expect_digits(find(report, "ANOVA", "supp").statistic, 15.57198, 5);
  expect_digits(find(report, "ANOVA", "dose").statistic, 91.99996, 5);
  expect_digits(find(report, "ANOVA", "supp:dose").statistic, 4.10699, 5);
}

TEST(PublishedStudy, AnorexiaMeetsTheCovarianceAndFailsItsAssumption) {
  const StudyReport report = analyse("anorexia");
  expect_digits(find(report, "ANCOVA", "Prewt").statistic, 7.26552, 5);
  expect_digits(find(report, "ANCOVA", "Treat").statistic, 7.86808, 5);
  expect_digits(find(report, "ANCOVA, equal slopes", "Prewt:Treat").statistic, 5.41123, 5);
  const std::pair<const char*, double> adjusted[] = {
      {"CBT", 85.57433}, {"Cont", 81.47726}, {"FT", 90.13739}};
  for (const auto& [level, mean] : adjusted) {
    bool found = false;
    for (const AdjustedMeanRecord& a : report.adjusted_means) {
      if (a.adjusted.level != level) continue;
      expect_digits(a.adjusted.mean, mean, 5);
      found = true;
    }
    EXPECT_TRUE(found) << level;
  }
  bool failed = false;
  for (const AssumptionRecord& a : report.assumptions) {
    if (a.name == "equal slopes") {
      failed = !a.holds;
      expect_digits(a.statistic, 5.41123, 5);
      EXPECT_FALSE(a.consequence.empty());
    }
  }
  EXPECT_TRUE(failed);
}

}  // namespace
}  // namespace osteomill::io
