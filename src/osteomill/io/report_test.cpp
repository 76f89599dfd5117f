// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "osteomill/base/error.hpp"
#include "osteomill/io/scratch_folder.hpp"

namespace osteomill::io {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

const std::string kPng = "\x89PNG\r\n\x1a\nrest";

ReportData small() {
  ReportData data;
  data.title = "Title & <tag>";
  data.headline = {"One sentence."};
  data.summary = {"", {{"run"}, {"force", "N", 1}}, {{std::string("a"), 1.25}}};
  ReportRun run;
  run.name = "a";
  run.time_s = {0, 1, 2};
  run.signals = {{"force", "N", {1, 2, 3}, 2.5}};
  run.strips = {{"material", {{0, 1, "air"}, {1, 2, "cortical"}}}};
  run.path.time_s = {0, 1};
  run.path.tip = {{0, 0, 0}, {1e-3, 0, 0}};
  run.path.axis = {geometry::Vector3::UnitZ()};
  run.path.value = {1, 2};
  run.after = {{{0, 0, 0}, {1e-3f, 0, 0}, {0, 1e-3f, 0}}, {{0, 1, 2}}, {}};
  data.runs = {run};
  data.scene = ReportScene{.before = run.after,
                           .cutter = cutting::Cutter{.radius = 1e-3, .cutting_length = 1e-2}};
  data.expanded_case = R"({"text": "</script><script>alert(1)</script>"})";
  return data;
}

nlohmann::json data_of(const std::string& page) {
  const std::string begin = R"(<script type="application/json" id="data">)";
  const std::size_t from = page.find(begin) + begin.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

TEST(Report, CarriesItsDataAsJsonThatNoTextWithinCanBreakOutOf) {
  const std::string page = report_html(small());
  const nlohmann::json data = data_of(page);
  EXPECT_EQ(data["title"], "Title & <tag>");
  EXPECT_EQ(data["case"], small().expanded_case);
  EXPECT_EQ(data["runs"][0]["signals"][0]["limit"]["value"], 2.5);
  EXPECT_EQ(data["summary"]["rows"][0][1], 1.25);
  EXPECT_THAT(page, HasSubstr("<title>Title &amp; &lt;tag></title>"));
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
}

TEST(Report, RefersToNothingOutsideItself) {
  const std::string page = report_html(small());
  for (const std::string scheme : {"http://", "https://", "ws://", "wss://", "ftp://"})
    for (std::size_t at = page.find(scheme); at != std::string::npos;
         at = page.find(scheme, at + 1)) {
      // Name spaces of SVG and XHTML are names; nobody fetches them.
      const std::string host = page.substr(at + scheme.size(), 16);
      EXPECT_THAT(host, AnyOf("www.w3.org/1999/", "www.w3.org/2000/"));
    }
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
}

TEST(Report, GivesSurfacesInMillimetresAndWhenTheCutterReachedThem) {
  const nlohmann::json data = data_of(report_html(small()));
  const auto& mesh = data["scene"]["before"];
  EXPECT_FLOAT_EQ(mesh["position"][0]["high"], 1.0f);
  EXPECT_EQ(mesh["corners"]["count"], 3);
  EXPECT_EQ(data["runs"][0]["beforeReach"]["count"], 3);
  EXPECT_EQ(data["runs"][0]["afterReach"]["count"], 3);
}

TEST(Report, StaysSmallHoweverLongTheSignalsAndFineTheSurfaces) {
  ReportData data = small();
  ReportRun& run = data.runs[0];
  run.time_s.clear();
  run.signals[0].values.clear();
  for (int i = 0; i < 300'000; ++i) {
    run.time_s.push_back(i);
    run.signals[0].values.push_back((i * 2'654'435'761u) % 1000);  // noise, which deflates badly
  }
  data.runs.resize(4, run);
  for (std::size_t i = 0; i < 4; ++i) data.runs[i].name = std::to_string(i);
  const ReportOptions options{.most_samples = 200'000, .most_triangles = 1000};
  const nlohmann::json page = data_of(report_html(data, options));
  EXPECT_EQ(page["runs"][0]["thinnedFrom"], 300'000);
  std::size_t samples = 0;
  for (const auto& r : page["runs"])
    samples += r["time"]["count"].get<std::size_t>() +
               r["signals"][0]["values"]["count"].get<std::size_t>();
  EXPECT_LE(samples, options.most_samples);
}

TEST(Report, AnEmptyReportOfATitleIsAReport) {
  ReportData data;
  data.title = "Only a title";
  EXPECT_EQ(data_of(report_html(data))["runs"].size(), 0u);
}

TEST(Report, TextThatIsNotUtf8IsShownAsFarAsItGoes) {
  ReportData data;
  data.title = "title";
  data.subtitle = "caf\xe9";
  EXPECT_EQ(data_of(report_html(data))["subtitle"], "caf\xef\xbf\xbd");
}

struct BadData {
  const char* what;
  const char* field;
  std::function<void(ReportData&)> spoil;
};

class BadReport : public testing::TestWithParam<BadData> {};

TEST_P(BadReport, IsRefusedWithTheNameOfTheField) {
  ReportData data = small();
  GetParam().spoil(data);
  try {
    report_html(data);
    FAIL() << "was accepted: " << GetParam().what;
  } catch (const InvalidInput& refused) {
    ASSERT_EQ(refused.faults().size(), 1u) << refused.what();
    EXPECT_THAT(refused.faults()[0].field, HasSubstr(GetParam().field));
  }
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

INSTANTIATE_TEST_SUITE_P(
    Table, BadReport,
    testing::Values(
        BadData{"no title", "title", [](auto& d) { d.title.clear(); }},
        BadData{"a row too short", "summary.rows[0]",
                [](auto& d) { d.summary.rows[0].pop_back(); }},
        BadData{"two runs of one name", "runs[a]", [](auto& d) { d.runs.push_back(d.runs[0]); }},
        BadData{"a signal too short", "signals[force]",
                [](auto& d) { d.runs[0].signals[0].values.pop_back(); }},
        BadData{"an infinite force", "signals[force].values[1]",
                [](auto& d) { d.runs[0].signals[0].values[1] = kInfinity; }},
        BadData{"time stands still", "time_s[2]", [](auto& d) { d.runs[0].time_s[2] = 1.0; }},
        BadData{"time is not a number", "time_s[0]", [](auto& d) { d.runs[0].time_s[0] = kNaN; }},
        BadData{"a material that ends before it starts", "strips[material]",
                [](auto& d) { d.runs[0].strips[0].intervals[0].to_s = -1.0; }},
        BadData{"a path without a place", "path.tip",
                [](auto& d) { d.runs[0].path.tip.pop_back(); }},
        BadData{"an axis of 2 mm", "path.axis", [](auto& d) { d.runs[0].path.axis[0] *= 2e-3; }},
        BadData{"a corner beyond the vertices", "after.triangles",
                [](auto& d) { d.runs[0].after.triangles[0][2] = 3; }},
        BadData{"a vertex nowhere", "scene.before",
                [](auto& d) { d.scene->before.vertices[0].x() = static_cast<float>(kNaN); }},
        BadData{"a picture that is none", "pictures[0]",
                [](auto& d) { d.pictures = {{"caption", "GIF89a"}}; }},
        BadData{"a case that is no JSON", "expanded_case", [](auto& d) { d.expanded_case = "{"; }},
        BadData{"a chart with x longer than y", "series[s].y",
                [](auto& d) {
                  d.sections = {
                      {"s", {ReportChart{.x = {}, .y = {}, .series = {{"s", {1, 2}, {1}}}}}}};
                }}),
    [](const auto& bad) {
      std::string name = bad.param.what;
      name.erase(std::remove_if(name.begin(), name.end(), [](char c) { return !std::isalnum(c); }),
                 name.end());
      return name;
    });

TEST(ReportFile, IsThePageAndNothingBesideIt) {
  ReportData data = small();
  data.pictures = {{"a picture", kPng, true}, {"lines", "<svg xmlns='x'/>"}};
  const auto folder = scratch("report_file");
  std::filesystem::create_directories(folder);
  write_report(folder / "report.html", data);
  std::ostringstream text;
  text << std::ifstream(folder / "report.html", std::ios::binary).rdbuf();
  EXPECT_EQ(text.str(), report_html(data));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
}

TEST(ReportFile, ThatCannotBeWrittenSaysSoAndLeavesTheOldOne) {
  EXPECT_THROW(write_report(scratch("no_such_folder") / "report.html", small()), WorldError);
  const auto file = scratch("old_report.html");
  std::ofstream(file) << "old";
  ReportData bad = small();
  bad.title.clear();
  EXPECT_THROW(write_report(file, bad), InvalidInput);
  std::string old;
  std::ifstream(file) >> old;
  EXPECT_EQ(old, "old");
}

}  // namespace
}  // namespace osteomill::io
