// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/case_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "osteomill/base/error.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CaseFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = fs::temp_directory_path() / "osteomill-case-XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    fs::create_directories(folder_ / "cutters");
    write_text_file(folder_ / "cutters/small.toml", "diameter_mm = 3\nflutes = 2\n");
    ::setenv("OSTEOMILL_DATA", folder_.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("OSTEOMILL_DATA");
    fs::remove_all(folder_);
  }
  std::vector<CaseRun> read(const std::string& text, const std::vector<std::string>& sets = {},
                            const char* name = "a.toml") {
    write_text_file(folder_ / name, text);
    return read_case(folder_ / name, sets);
  }
  std::string refusal(const std::string& text, const std::vector<std::string>& sets = {},
                      const char* name = "a.toml") {
    try {
      read(text, sets, name);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "none";
  }
  fs::path folder_;
};

constexpr const char* kTwoRuns =
    "[cutter]\nuse = \"small\"\nflutes = 4\n"
    "[controller]\nkind = \"constant\"\nfeed = 3\n"
    "[[run]]\nname = \"a\"\n"
    "[[run]]\nname = \"b\"\ncontroller.kind = \"adaptive\"\n";

TEST_F(CaseFile, MergesRunsOverTheRestAndTheCatalogueUnderIt) {
  const auto runs = read(kTwoRuns);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[1].name, "b");
  EXPECT_EQ(runs[0].tree.values.dump(),
            R"({"controller":{"feed":3,"kind":"constant"},"cutter":{"diameter_mm":3,"flutes":4}})");
  EXPECT_EQ(runs[1].tree.values["controller"].dump(), R"({"feed":3,"kind":"adaptive"})");
  EXPECT_EQ(runs[1].tree.places.at("controller.kind"), "a.toml:11");
  EXPECT_EQ(runs[1].tree.places.at("controller.feed"), "a.toml:6");
  EXPECT_EQ(runs[1].tree.places.at("cutter.diameter_mm"), "cutters/small.toml:1");
}

TEST_F(CaseFile, OverridesWinOverTheFileAndItsRuns) {
  const auto runs =
      read(kTwoRuns, {"controller.kind=predictive", "cutter.flutes=6", "new.key=[1, 2]"});
  for (const CaseRun& run : runs) {
    EXPECT_EQ(run.tree.values["controller"]["kind"], "predictive");
    EXPECT_EQ(run.tree.values["cutter"]["flutes"], 6);
    EXPECT_EQ(run.tree.values["new"]["key"].dump(), "[1,2]");
    EXPECT_EQ(run.tree.places.at("cutter.flutes"), "--set");
  }
}

TEST_F(CaseFile, ARunDirectorysRecordIsACaseToo) {
  const auto runs = read(R"({"version": "0.1", "case": {"run": [{"name": "a", "x": {"y": 1}}]}})",
                         {}, "run.json");
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].name, "a");
  EXPECT_EQ(runs[0].tree.values.dump(), R"({"x":{"y":1}})");
}

TEST_F(CaseFile, NamesWhatIsWrongAndWhere) {
  EXPECT_THAT(refusal("a = \n"), HasSubstr("a.toml:1"));
  EXPECT_THAT(refusal("[(\n"), HasSubstr("a.toml:1"));
  EXPECT_THAT(refusal("a = 2020-01-01\n"), HasSubstr("date"));
  EXPECT_THAT(
      refusal("[cutter]\nuse = \"big\"\n"),
      HasSubstr(
          "a.toml:2: cutter.use = \"big\": is not in the catalogue of cutters; known: small"));
  EXPECT_THAT(refusal("[cutter]\nuse = 3\n"), HasSubstr("a.toml:2: cutter.use = 3"));
  EXPECT_THAT(refusal("[[run]]\nx = 1\n"), HasSubstr("run.0.name: is missing"));
  EXPECT_THAT(refusal("[[run]]\nname = \"a\"\n[[run]]\nname = \"a\"\n"), HasSubstr("stands twice"));
  EXPECT_THAT(refusal("[[run]]\nname = \"../a\"\n"), HasSubstr("slash"));
  EXPECT_THAT(refusal("run = 3\n"), HasSubstr("must be a list of tables"));
  EXPECT_THAT(refusal("", {"cut"}), HasSubstr("must read section.key=value"));
  EXPECT_THAT(refusal("", {".cut=3"}), HasSubstr("empty key"));
  EXPECT_THAT(refusal("cut = 3\n", {"cut.x=3"}), HasSubstr("is a value, not a table"));
  EXPECT_THAT(refusal("cut = [1]\n", {"cut.1=3"}), HasSubstr("the array has 1 elements"));
  EXPECT_THAT(refusal("[1", {}, "a.json"), HasSubstr("run.json"));
  EXPECT_THAT(refusal("3", {}, "a.json"), HasSubstr("holds no case"));
  EXPECT_THROW(read_case(folder_ / "none.toml", {}), InvalidInput);
  EXPECT_THROW(read_case(folder_, {}), InvalidInput);
}

}  // namespace
}  // namespace osteomill::io
