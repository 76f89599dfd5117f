// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/study/analysis.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"

namespace osteomill::study {
namespace {

using ::testing::HasSubstr;

/// As few draws as make intervals at all: none of these tests is about their ends.
Design quick() {
  Design design;
  design.bootstrap_draws = 199;
  design.forecast_draws = 199;
  design.component_draws = 19;
  return design;
}

/// Six operators in two groups, two techniques, four cuts of each: guide movement makes half of it.
Table study_table(std::uint64_t seed = 3) {
  Table table{"cuts.csv",
              {"operator", "group", "technique", "cut", "specimen", "varus_valgus_deg",
               "flexion_extension_deg", "guide_movement_varus_valgus_deg", "time_s"},
              {}};
  Random random(seed);
  int line = 2;
  for (int o = 0; o < 6; ++o) {
    const double own = random.normal(0.0, 0.3);
    for (const char* technique : {"sawing", "milling"}) {
      const bool saw = technique[0] == 's';
      for (int c = 0; c < 6; ++c) {
        const double movement = random.normal(0.0, 0.4);
        table.rows.push_back(
            {line++,
             {std::string(1, static_cast<char>('A' + o)), o < 2 ? "expert" : "novice", technique,
              c % 2 == 0 ? "PT" : "DF", std::to_string(o * 3 + c % 3),
              fmt::format("{}", own + movement + (saw ? 0.9 : 0.3) * random.normal()),
              fmt::format("{}", (saw ? 1.3 : 0.0) + (saw ? 1.2 : 0.7) * random.normal()),
              fmt::format("{}", movement),
              fmt::format("{}", random.normal(saw ? 100.0 : 200.0, 20.0))}});
      }
    }
  }
  return table;
}

const TestRecord& find(const StudyReport& report, const std::string& name,
                       const std::string& response, const std::string& term) {
  const auto found = std::find_if(report.tests.begin(), report.tests.end(), [&](const auto& t) {
    return t.name == name && t.response == response && t.term == term;
  });
  if (found == report.tests.end()) throw std::runtime_error(name + " of " + term);
  return *found;
}

std::string findings_text(const StudyReport& report) {
  std::string text;
  for (const Finding& f : report.findings) text += f.what + "; " + f.still + "\n";
  return text;
}

TEST(StudyAnalysis, FindsWhatWasPutIn) {
  const StudyReport report = analyse_study(study_table(), quick());
  EXPECT_EQ(report.design.between, std::vector<std::string>{"group"});
  EXPECT_EQ(report.design.within, std::vector<std::string>{"technique"});
  EXPECT_LT(find(report, "repeated-measures ANOVA", "flexion_extension_deg", "technique").p, 0.01);
  EXPECT_LT(find(report, "repeated-measures ANOVA", "time_s", "technique").p, 0.001);
  EXPECT_LT(
      find(report, "F-test of variances", "varus_valgus_deg", "technique: milling / sawing").p,
      0.01);
  // 72 cuts less 24 cells of operator x technique x cut, three cuts each.
  const auto all = std::find_if(report.variability.begin(), report.variability.end(),
                                [](const auto& v) { return v.factor == "all"; });
  EXPECT_EQ(all->degrees_of_freedom, 48.0);
  EXPECT_NEAR(all->combined_sd, std::sqrt(2.0) * all->sd, 1e-12);
  const auto slope =
      std::find_if(report.regressions.begin(), report.regressions.end(),
                   [](const auto& r) { return r.factor == "technique" && r.group == "milling"; });
  EXPECT_LT(slope->slope_interval.low, 1.0);
  EXPECT_GT(slope->slope_interval.high, 1.0);
  EXPECT_EQ(slope->response, "varus_valgus_deg");
}

TEST(StudyAnalysis, SharesOfContributionsSumToOne) {
  const StudyReport report = analyse_study(study_table(), quick());
  for (const char* response : {"varus_valgus_deg", "flexion_extension_deg", "time_s"}) {
    double sum = 0.0;
    for (const auto& part : report.contributions)
      sum += part.response == response ? part.share : 0.0;
    EXPECT_NEAR(sum, 1.0, 1e-12) << response;
  }
}

TEST(StudyAnalysis, IsUnchangedByTheOrderOfRowsAndByNamesOfLevels) {
  Table table = study_table();
  const StudyReport a = analyse_study(table, quick());
  std::reverse(table.rows.begin(), table.rows.end());
  const StudyReport b = analyse_study(table, quick());
  ASSERT_EQ(a.tests.size(), b.tests.size());
  // Sums taken in another order, and the optimiser's last digits.
  for (size_t i = 0; i < a.tests.size(); ++i) {
    EXPECT_EQ(a.tests[i].term, b.tests[i].term);
    EXPECT_NEAR(a.tests[i].statistic, b.tests[i].statistic,
                1e-4 * (1.0 + std::abs(a.tests[i].statistic)));
  }
}

struct Spoiled {
  const char* what;
  std::function<void(Table&)> spoil;
  std::vector<const char*> says;
  const char* still;  ///< test that is there all the same
};

size_t column(const Table& table, const char* name) { return *table.find(name); }

// Bad data that leave something: named, with what was computed all the same.
TEST(StudyAnalysis, NamesWhatIsWrongAndComputesWhatItCan) {
  const std::vector<Spoiled> table = {
      {"missing values",
       [](Table& t) {
         t.rows[3].cells[column(t, "varus_valgus_deg")] = "";
         t.rows[9].cells[column(t, "varus_valgus_deg")] = "NA";
       },
       {"varus_valgus_deg is empty", "left out of this response alone"},
       "repeated-measures ANOVA"},
      {"a missing covariate",
       [](Table& t) { t.rows[5].cells[column(t, "guide_movement_varus_valgus_deg")] = ""; },
       {"guide_movement_varus_valgus_deg is missing", "left out of the regressions"},
       "repeated-measures ANOVA"},
      {"an operator without one technique",
       [](Table& t) {
         std::erase_if(t.rows,
                       [](const auto& r) { return r.cells[0] == "C" && r.cells[2] == "milling"; });
       },
       {"missing cells: operator C", "5 complete ones", "mixed model uses all rows"},
       "mixed model"},
      {"one operator only",
       [](Table& t) { std::erase_if(t.rows, [](const auto& r) { return r.cells[0] != "D"; }); },
       {"one operator only (D)", "its own means, SDs, intervals"},
       "F-test of variances"},
      {"rows twice",
       [](Table& t) { t.rows.push_back(t.rows[7]); },
       {"possible duplicate cuts: 1 row", "a column cut_id would settle it"},
       "repeated-measures ANOVA"},
      {"cuts twice",
       [](Table& t) {
         t.columns.push_back("cut_id");
         for (size_t i = 0; i < t.rows.size(); ++i) t.rows[i].cells.push_back(std::to_string(i));
         t.rows.push_back(t.rows[7]);
       },
       {"duplicate cuts: 1 row", "counted once"},
       "repeated-measures ANOVA"},
      {"radians of one operator",
       [](Table& t) {
         for (auto& row : t.rows) {
           std::string& cell = row.cells[column(t, "flexion_extension_deg")];
           if (row.cells[0] == "B") cell = fmt::format("{}", std::stod(cell) / 57.3);
         }
       },
       {"mixed units: flexion_extension_deg of operator B", "radians among degrees?"},
       "repeated-measures ANOVA"},
      {"two units of one quantity",
       [](Table& t) {
         t.columns.push_back("varus_valgus_rad");
         for (auto& row : t.rows) row.cells.push_back("0");
       },
       {"mixed units: varus_valgus_rad stands beside varus_valgus_deg"},
       "repeated-measures ANOVA"},
      {"an angle that cannot be",
       [](Table& t) { t.rows[2].cells[column(t, "varus_valgus_deg")] = "178"; },
       {"varus_valgus_deg = 178 deg is no cutting error", "check the unit and the frame"},
       "repeated-measures ANOVA"},
      {"a mirrored side",
       [](Table& t) {
         t.columns.push_back("side");
         for (size_t i = 0; i < t.rows.size(); ++i) {
           t.rows[i].cells.push_back(i % 2 == 0 ? "left" : "right");
           std::string& cell = t.rows[i].cells[column(t, "varus_valgus_deg")];
           cell = fmt::format("{}", std::stod(cell) + (i % 2 == 0 ? 1.5 : -1.5));
         }
       },
       {"mirrored frames", "change the sign of one side"},
       "repeated-measures ANOVA"},
      {"a factor of one level",
       [](Table& t) {
         std::erase_if(t.rows, [](const auto& r) { return r.cells[1] != "novice"; });
       },
       {},
       "repeated-measures ANOVA"},
      {"long tails",
       [](Table& t) {
         for (size_t i = 0; i < t.rows.size(); i += 9) {
           t.rows[i].cells[column(t, "varus_valgus_deg")] = i % 2 == 0 ? "7" : "-6.5";
         }
       },
       {},
       "repeated-measures ANOVA"},
  };
  for (const Spoiled& row : table) {
    SCOPED_TRACE(row.what);
    Table spoiled = study_table();
    row.spoil(spoiled);
    const StudyReport report = analyse_study(spoiled, quick());
    const std::string text = findings_text(report);
    for (const char* part : row.says) EXPECT_THAT(text, HasSubstr(part));
    EXPECT_TRUE(std::any_of(report.tests.begin(), report.tests.end(),
                            [&](const auto& t) { return t.name == row.still; }));
    EXPECT_FALSE(report.variability.empty());
  }
}

TEST(StudyAnalysis, SaysPlainlyThatResidualsAreNotNormalAndBootstraps) {
  Table table = study_table();
  for (size_t i = 0; i < table.rows.size(); i += 9) {
    table.rows[i].cells[column(table, "varus_valgus_deg")] = i % 2 == 0 ? "7" : "-6.5";
  }
  const StudyReport report = analyse_study(table, quick());
  const auto failed =
      std::find_if(report.assumptions.begin(), report.assumptions.end(), [](const auto& a) {
        return a.response == "varus_valgus_deg" && a.name == "normal residuals (Shapiro-Wilk)";
      });
  EXPECT_FALSE(failed->holds);
  EXPECT_THAT(failed->consequence, HasSubstr("read the intervals without normality"));
  EXPECT_THAT(failed->consequence, HasSubstr("held the truth in 69-100 %"));
  const auto& test = find(report, "repeated-measures ANOVA", "varus_valgus_deg", "technique");
  EXPECT_EQ(test.corrections.back().name, "residual bootstrap");
}

struct Refused {
  const char* what;
  std::function<void(Table&, Design&)> spoil;
  std::vector<const char*> says;
};

TEST(StudyAnalysis, RefusesWhatCannotBeRead) {
  const std::vector<Refused> table = {
      {"decimal commas and units in cells",
       [](Table& t, Design&) {
         t.rows[0].cells[5] = "1,25";
         t.rows[1].cells[5] = "0.4 deg";
         t.rows[2].cells[5] = "varus";
       },
       {"cuts.csv:2: varus_valgus_deg = 1,25: must be a number; write a decimal point: 1.25",
        "cuts.csv:3: varus_valgus_deg = 0.4 deg: must be a number; write the number alone",
        "cuts.csv:4: varus_valgus_deg = varus: must be a number"}},
      {"unknown columns",
       [](Table&, Design& d) {
         d.between = {"grp"};
         d.covariates = {"x"};
       },
       {"between = grp: no such column; cuts.csv has: operator, group", "covariates = x"}},
      {"no responses",
       [](Table& t, Design&) {
         for (auto& name : t.columns) name += "_";
       },
       {"name the measured columns"}},
      {"one cut_id, two cuts",
       [](Table& t, Design&) {
         t.columns.push_back("cut_id");
         for (auto& row : t.rows) row.cells.push_back("7");
       },
       {"duplicate cut: line 2 has the same cut_id and other values"}},
      {"no rows", [](Table& t, Design&) { t.rows.clear(); }, {"no rows"}},
  };
  for (const Refused& row : table) {
    SCOPED_TRACE(row.what);
    Table spoiled = study_table();
    Design design = quick();
    row.spoil(spoiled, design);
    try {
      analyse_study(spoiled, design);
      ADD_FAILURE() << "was taken";
    } catch (const InvalidInput& error) {
      for (const char* part : row.says) EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }
}

TEST(StudyDesign, MovesAFactorThatStandsOnTheWrongSide) {
  Design design = quick();
  design.between = {"technique"};
  design.within = {"group"};
  const StudyReport report = analyse_study(study_table(), design);
  EXPECT_EQ(report.design.between, std::vector<std::string>{"group"});
  EXPECT_EQ(report.design.within, std::vector<std::string>{"technique"});
  EXPECT_THAT(findings_text(report), HasSubstr("technique varies within operator"));
  EXPECT_THAT(findings_text(report), HasSubstr("group is constant within operator"));
}

TEST(Units, StandInTheNameOfTheColumn) {
  EXPECT_EQ(unit_of("varus_valgus_deg"), "deg");
  EXPECT_EQ(unit_of("removal_rate_mm3_per_s"), "mm3_per_s");
  EXPECT_EQ(unit_of("time_s"), "s");
  EXPECT_EQ(unit_of("yield"), "");
  EXPECT_EQ(unit_of("deg"), "");
}

}  // namespace
}  // namespace osteomill::study
