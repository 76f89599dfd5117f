// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/force_case.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/prediction.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/catalogue.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

using testing::Contains;
using testing::HasSubstr;

CaseRun run_of(const std::string& text) {
  CaseRun run;
  run.tree = parse_toml(text, "case.toml");
  return run;
}

const std::string kCutter =
    "[cutter]\nshape = \"cylindrical\"\ndiameter_mm = 6.35\nflutes = 4\nhelix_deg = 30\n"
    "rake_deg = 10\n";
const std::string kCut =
    "[cut]\nspindle_speed_rpm = 5000\nfeed_rate_mm_per_min = 130\naxial_depth_mm = 8.0\n"
    "immersion = \"slot\"\n";
const std::string kLinear =
    "[bone]\nlaw = \"linear\"\ntangential = { any_deg = { k = 200, edge = 3 } }\n"
    "radial = { any_deg = { k = 90, edge = 5 } }\n";

std::vector<std::string> faults_of(const std::string& text) {
  std::vector<std::string> texts;
  try {
    read_force_case(run_of(text));
  } catch (const InvalidInput& error) {
    for (const Fault& fault : error.faults()) texts.push_back(describe(fault));
  }
  return texts;
}

TEST(ForceCase, ReadsIntoSi) {
  const ForceCase force = read_force_case(run_of(kCutter + kLinear + kCut));
  EXPECT_DOUBLE_EQ(force.cutter.radius, 3.175e-3);
  EXPECT_NEAR(force.condition.feed_per_tooth, 6.5e-6, 1e-18);
  const auto& law = std::get<cutting::LinearLaw>(force.bone.law.tangential.at_0);
  EXPECT_DOUBLE_EQ(law.pressure, 200e6);
  EXPECT_DOUBLE_EQ(law.edge, 3e3);
}

TEST(ForceCase, ReadsEveryKindOfLaw) {
  const auto law = [&](const std::string& bone) {
    return read_force_case(run_of(kCutter + bone + kCut)).bone.law;
  };
  const auto power = law(
      "[bone]\nlaw = \"power\"\ntangential = { at_0_deg = { k = 71.1, n = 0.684 }, at_90_deg = { "
      "k = 63.1, n = 0.569, edge = 1 } }\nradial = { any_deg = { k = 18.6, n = 0.3 } }\n");
  // 1 mm of chip: K itself.
  EXPECT_NEAR(cutting::force_per_width(*power.tangential.at_90, 1e-3), 64.1e3, 1e-6);
  EXPECT_NEAR(cutting::force_per_width(power.radial.at_0, 1e-3), 18.6e3, 1e-6);
  const auto kienzle =
      law("[bone]\nlaw = \"kienzle\"\ntangential = { any_deg = { k = 100, m = 0.25 } }\nradial = { "
          "any_deg = { k = 50, m = 0.4 } }\n");
  EXPECT_NEAR(cutting::specific_energy(kienzle.tangential.at_0, 1e-3), 100e6, 1.0);
  const auto polynomial = law(
      "[bone]\nlaw = \"polynomial\"\nshear = { tangential = [387.05, -258.6], radial = [333.57], "
      "axial = [172.15] }\nedge = { tangential = [8.44] }\n");
  const auto& tangential = std::get<cutting::PolynomialLaw>(polynomial.tangential.at_0);
  EXPECT_DOUBLE_EQ(tangential.pressure[1], -258.6e6);
  EXPECT_DOUBLE_EQ(std::get<cutting::PolynomialLaw>(polynomial.lateral->at_0).pressure[0],
                   -172.15e6);
}

TEST(ForceCase, ReportsAllFaultsOfTheThreeTablesAtOnce) {
  const auto faults = faults_of(
      "[cutter]\nshape = \"conical\"\ndiameter_mm = -1\nflutes = 0\n"
      "[bone]\nlaw = \"linear\"\ntangential = { at_0_deg = { k = 1 } }\n"
      "[cut]\nspindle_speed_rpm = 5000\naxial_depth_mm = 8\nimmersion = \"up\"\n");
  EXPECT_THAT(faults, Contains(HasSubstr("cutter.shape")));
  EXPECT_THAT(faults, Contains(HasSubstr("cutter.diameter_mm")));
  EXPECT_THAT(faults, Contains(HasSubstr("cutter.flutes")));
  EXPECT_THAT(faults, Contains(HasSubstr("bone.tangential.any_deg")));
  EXPECT_THAT(faults, Contains(HasSubstr("bone.radial: is missing")));
  EXPECT_THAT(faults, Contains(HasSubstr("cut.radial_depth_mm")));
  EXPECT_THAT(faults, Contains(HasSubstr("feed_rate_mm_per_min")));
}

TEST(ForceCase, RefusesSlipsOfUnitAndDepthsBeyondTheCutter) {
  const auto with = [&](const char* line) {
    return faults_of(kCutter + "cutting_length_mm = 10\n" + kLinear +
                     "[cut]\naxial_depth_mm = 5\nimmersion = \"slot\"\n" + line);
  };
  EXPECT_THAT(with("spindle_speed_rpm = 5000\nfeed_per_tooth_mm = 3\n"),
              Contains(HasSubstr("quarter of the cutter's radius")));
  EXPECT_THAT(with("spindle_speed_rpm = 500000\nfeed_per_tooth_mm = 0.01\n"),
              Contains(HasSubstr("spindle_speed_rpm")));
  EXPECT_THAT(faults_of(kCutter + "cutting_length_mm = 5\n" + kLinear + kCut),
              Contains(HasSubstr("cutting length of 5")));
}

TEST(Catalogue, EveryBoneAndCutterReadsAndSaysHowItWasObtained) {
  for (const std::string& bone : catalogue_names("bones")) {
    CaseRun run = run_of(kCutter + kCut);
    run.tree.values["bone"] = catalogue_entry("bones", bone).values;
    const ForceCase force = read_force_case(run);
    EXPECT_NE(force.bone.provenance.obtained, bone::Obtained::unstated) << bone;
    EXPECT_NE(force.bone.provenance.source, "") << bone;
    EXPECT_GT(cutting::predict(force.cutter, force.bone.law, force.condition, force.immersion)
                  .mean_torque,
              0.0)
        << bone;
  }
  for (const std::string& cutter : catalogue_names("cutters")) {
    CaseRun run = run_of(kLinear + kCut);
    run.tree.values["cutter"] = catalogue_entry("cutters", cutter).values;
    CutterCase read;
    BoneCase bone;
    CutCase cut;
    Section::read(run, [&](Section& s) {
      bind_cutter(s, read);
      bind_bone(s, bone);
      bind_cut(s, cut);
    });
    EXPECT_NE(read.provenance.obtained, bone::Obtained::unstated) << cutter;
    EXPECT_NO_THROW(cutting::check(read.cutter)) << cutter;
  }
}

}  // namespace
}  // namespace osteomill::io
