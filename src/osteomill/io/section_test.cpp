// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/section.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"

namespace osteomill::io {
namespace {

using Json = nlohmann::ordered_json;
using testing::ElementsAre;
using testing::HasSubstr;

enum class Immersion { slot, up, down };

struct Cut {
  double axial_depth = 0.0;
  std::optional<double> feed_rate;
  std::optional<double> feed_per_tooth;
  int flutes = 2;
  Immersion immersion = Immersion::slot;
  std::vector<double> lengths;
};

void bind_cut(Section& section, Cut& cut) {
  section.table("cut", "cut", Need::required, [&](Section& s) {
    s.number("axial_depth_mm", cut.axial_depth, {units::mm, "mm"}, positive(), "axial depth");
    s.number("feed_rate_mm_per_min", cut.feed_rate, {units::mm_per_min, "mm/min"}, positive(),
             "feed rate");
    s.number("feed_per_tooth_mm", cut.feed_per_tooth, {units::mm, "mm"}, positive(), "feed");
    s.exactly_one_of({"feed_rate_mm_per_min", "feed_per_tooth_mm"});
    s.integer("flutes", cut.flutes, between(1, 64), "number of flutes", Need::optional);
    s.choice<Immersion>(
        "immersion", cut.immersion,
        {{"slot", Immersion::slot}, {"up", Immersion::up}, {"down", Immersion::down}}, "immersion",
        Need::optional);
    s.tables("parts", "parts of the shaft", Need::optional, [&](Section& part, std::size_t) {
      part.number("length_mm", cut.lengths.emplace_back(), {units::mm, "mm"}, positive(), "length");
    });
  });
}

CaseRun run_of(const char* text) {
  CaseRun run;
  run.tree = parse_toml(text, "case.toml");
  return run;
}

std::vector<std::string> faults_of(const char* text) {
  Cut cut;
  try {
    Section::read(run_of(text), [&](Section& s) { bind_cut(s, cut); });
  } catch (const InvalidInput& error) {
    std::vector<std::string> texts;
    for (const Fault& fault : error.faults()) texts.push_back(describe(fault));
    return texts;
  }
  return {};
}

TEST(Section, ReadsIntoSiAndFillsDefaultsIntoTheExpandedCase) {
  Cut cut;
  const Json expanded = Section::read(
      run_of(
          "[cut]\naxial_depth_mm = 8\nfeed_rate_mm_per_min = 120\n[[cut.parts]]\nlength_mm = 3\n"),
      [&](Section& s) { bind_cut(s, cut); });
  EXPECT_DOUBLE_EQ(cut.axial_depth, 8e-3);
  EXPECT_DOUBLE_EQ(cut.feed_rate.value(), 2e-3);
  EXPECT_THAT(cut.lengths, ElementsAre(3e-3));
  EXPECT_EQ(expanded.dump(), R"({"cut":{"axial_depth_mm":8,"feed_rate_mm_per_min":120,"flutes":2,)"
                             R"("immersion":"slot","parts":[{"length_mm":3}]}})");
}

TEST(Section, ReportsEveryFaultOfACaseAtOnceWithItsLine) {
  EXPECT_THAT(
      faults_of("[cut]\n"
                "axial_depth_mm = -3\n"
                "feed_rate_mm_per_min = 1\n"
                "feed_per_tooth_mm = \"x\"\n"
                "flutes = 2.5\n"
                "imersion = \"slot\"\n"
                "[[cut.parts]]\n"
                "[cutter]\n"),
      ElementsAre("case.toml:2: cut.axial_depth_mm = -3: must be > 0 mm",
                  "case.toml:4: cut.feed_per_tooth_mm = \"x\": must be a number of mm",
                  "case.toml:1: cut: takes only one of feed_rate_mm_per_min, "
                  "feed_per_tooth_mm; remove the others",
                  "case.toml:5: cut.flutes = 2.5: must be a whole number",
                  "case.toml:7: cut.parts.0.length_mm: is missing; set it (length)",
                  "case.toml:6: cut.imersion = \"slot\": is no known key here; did you mean "
                  "immersion?",
                  "case.toml:8: cutter: is no known key here; known: cut"));
}

TEST(Section, RefusesWhatIsNoFiniteNumberOrNoSuchChoice) {
  EXPECT_THAT(faults_of("[cut]\naxial_depth_mm = nan\nfeed_per_tooth_mm = inf\n"
                        "immersion = \"both\"\n"),
              ElementsAre(HasSubstr("axial_depth_mm"), HasSubstr("feed_per_tooth_mm"),
                          HasSubstr("must be one of slot | up | down")));
  EXPECT_THAT(faults_of("cut = 3\n"), ElementsAre("case.toml:1: cut = 3: must be a table: [cut]"));
  EXPECT_THAT(faults_of(""), ElementsAre("cut: is missing; set it (cut)"));
}

TEST(Section, TheExpandedCaseReadsToTheSameValues) {
  Cut first;
  const Json expanded =
      Section::read(run_of("[cut]\naxial_depth_mm = 0.1\nfeed_per_tooth_mm = 0.0333\n"),
                    [&](Section& s) { bind_cut(s, first); });
  CaseRun again;
  again.tree.values = expanded;
  Cut second;
  EXPECT_EQ(Section::read(again, [&](Section& s) { bind_cut(s, second); }), expanded);
  EXPECT_EQ(first.axial_depth, second.axial_depth);
  EXPECT_EQ(first.feed_per_tooth, second.feed_per_tooth);
}

TEST(Section, SchemaListsEveryKeyOnceWithUnitRangeAndDefault) {
  Cut cut;
  const auto keys = Section::schema([&](Section& s) { bind_cut(s, cut); });
  ASSERT_EQ(keys.size(), 8u);
  EXPECT_EQ(keys[1].path, "cut.axial_depth_mm");
  EXPECT_EQ(keys[1].unit, "mm");
  EXPECT_EQ(keys[1].allowed, "> 0");
  EXPECT_EQ(keys[4].default_value, "2");
  EXPECT_EQ(keys[5].allowed, "slot | up | down");
  EXPECT_EQ(keys[7].path, "cut.parts[].length_mm");
}

}  // namespace
}  // namespace osteomill::io
