// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/study_json.hpp"

#include <gmock/gmock.h>

#include <filesystem>

#include "osteomill/base/error.hpp"
#include "osteomill/io/run_record.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/study_case.hpp"

namespace osteomill::io {
namespace {

using ::testing::HasSubstr;

// What scripts rely on.
TEST(StudyDocument, HasTheKeysThatScriptsUse) {
  const std::filesystem::path folder =
      std::filesystem::path(OSTEOMILL_SOURCE_DIR) / "examples/study";
  const auto document = study_document(
      study::analyse_study(read_study_table(folder / "milling_and_sawing.csv"),
                           read_study_design(folder / "milling_and_sawing.toml",
                                             {"component_draws=19", "bootstrap_draws=199"})
                               .design));
  for (const auto& test : document["tests"]) {
    for (const char* key : {"name", "term", "statistic", "df1", "df2", "p", "corrections"}) {
      EXPECT_TRUE(test.contains(key)) << key;
    }
  }
  for (const auto& v : document["variability"]) {
    if (v["response"] != "varus_valgus_deg") continue;
    EXPECT_LT(v["ci95_deg"][0], v["sd_deg"]);
    EXPECT_LT(v["sd_deg"], v["ci95_deg"][1]);
    EXPECT_GE(v["degrees_of_freedom"], 1);
  }
  for (const auto& a : document["assumptions"]) {
    EXPECT_TRUE(a["holds"].is_boolean());
    EXPECT_NE(a["holds"].get<bool>(), !a["consequence"].get<std::string>().empty());
  }
  bool named = false;
  for (const auto& finding : document["findings"]) {
    named = named || finding["what"].get<std::string>().find("operator H") != std::string::npos;
  }
  EXPECT_TRUE(named);
}

TEST(StudyDocument, NamesIntervalsByTheirConfidence) {
  const std::filesystem::path folder =
      std::filesystem::path(OSTEOMILL_SOURCE_DIR) / "examples/study";
  const auto document = study_document(study::analyse_study(
      read_study_table(folder / "published/sirstv.csv"),
      read_study_design(folder / "published/sirstv.toml", {"confidence=0.9"}).design));
  EXPECT_TRUE(document["variability"][0].contains("ci90"));
}

TEST(StudyDesign, NamesUnknownKeysAndBadValuesTogether) {
  try {
    read_study_design("", {"betwen=[\"group\"]", "confidence=1.5", "sum_of_squares=IV"});
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("betwen"));
    EXPECT_THAT(error.what(), HasSubstr("confidence = 1.5"));
    EXPECT_THAT(error.what(), HasSubstr("sum_of_squares"));
  }
  EXPECT_THROW(read_study_design("", {"confidence"}), InvalidInput);
}

TEST(StudyPlan, IsReadInTheUnitsOfItsKeys) {
  const StudyPlanCase c = read_study_plan("", {"question=sd-ratio", "within_operator_sd_deg=0.8",
                                               "sd_ratio=0.5", "cuts_per_operator=6"});
  EXPECT_EQ(c.options.within_operator_sd, 0.8);
  EXPECT_EQ(plan_document(study::plan_study(c.options))["feasible"], true);
  EXPECT_THROW(read_study_plan("", {"question=power"}), InvalidInput);
}

TEST(StudyDesign, NamesItsTableAndRunsAgainFromTheRecordOfARun) {
  const std::filesystem::path table =
      std::filesystem::path(OSTEOMILL_SOURCE_DIR) / "examples/study/milling_and_sawing.csv";
  const StudyDesign first = read_study_design({}, {"seed=7", "alpha=0.01"});
  EXPECT_TRUE(first.table.empty());
  nlohmann::ordered_json input = first.expanded;
  input["table"] = table.string();
  write_run_json(scratch("run.json"), {"osteomill", "study", input, {}, 0.0});
  const StudyDesign again = read_study_design(scratch("run.json"), {});
  EXPECT_EQ(again.table, table);
  EXPECT_EQ(again.design.seed, 7u);
  EXPECT_EQ(again.design.alpha, 0.01);
  EXPECT_THROW(read_study_design({}, {"table=\"none.csv\""}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::io
