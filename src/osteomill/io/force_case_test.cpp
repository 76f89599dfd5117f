// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/force_case.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/prediction.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/catalogue.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/text_file.hpp"

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

/// The keys of a log law, divided by ", " in an inline table and by line breaks in a table.
std::string log_law(double k1, double rake, const char* then = ", ") {
  return fmt::format(
      "law = \"log\"{0}rake_deg = {1}{0}range_um = [0.5, 50]{0}"
      "tangential = {{ any_deg = {{ k1 = {2}, k2 = 0.6, k3 = -0.07 }} }}{0}"
      "radial = {{ any_deg = {{ k1 = 0.6, k2 = 0.4, k3 = -0.2 }} }}",
      then, rake, k1);
}

TEST(ForceCase, InterpolatesBetweenTestedRakesAndNotBeyond) {
  const std::string bone =
      "[bone]\ntested = [ { " + log_law(0.5, 20) + " }, { " + log_law(0.3, 0) + " } ]\n";
  const ForceCase force = read_force_case(run_of(kCutter + bone + kCut));  // rake 10
  const double middle = cutting::force_per_width(force.bone.law.tangential.at_0, 10e-6);
  const double exact = 0.5 * (std::pow(10.0, 0.5 + 0.53) + std::pow(10.0, 0.3 + 0.53)) * 1e3;
  EXPECT_NEAR(middle, exact, 1e-6 * exact);
  EXPECT_THAT(force.caveats, Contains(HasSubstr("between rakes of 0 and 20 deg")));
  std::string steep = kCutter;
  steep.replace(steep.find("rake_deg = 10"), 13, "rake_deg = 25");
  EXPECT_THAT(faults_of(steep + bone + kCut), Contains(HasSubstr("0 ... 20 deg")));
  EXPECT_THAT(faults_of(kCutter + "[bone]\ntested = [ { " + log_law(0.5, 20) + " } ]\n" + kCut),
              Contains(HasSubstr("two laws or more")));
}

TEST(ForceCase, InterpolatesBetweenTestedInclinationsByTheHelix) {
  const auto oblique = [](double k1, double inclination) {
    return fmt::format(
        "law = \"log\", range_um = [0.5, 50], "
        "tangential = {{ any_deg = {{ k1 = {0}, k2 = 0.6, k3 = -0.07 }} }}, "
        "radial = {{ any_deg = {{ k1 = 0.6, k2 = 0.4, k3 = -0.2 }} }}, "
        "lateral = {{ inclination_deg = {1}, any_deg = {{ k1 = {0}, k2 = 0.5, k3 = -0.1 }} }}",
        k1, inclination);
  };
  const std::string bone = "[bone]\ntested_by = \"inclination\"\ntested = [ { " + oblique(0.2, 15) +
                           " }, { " + oblique(0.5, 45) + " } ]\n";
  const ForceCase force = read_force_case(run_of(kCutter + bone + kCut));  // helix 30
  // Half way in angle, so the mean of the two forces at each chip; at 10 um log10 h = 1.
  const double lateral = cutting::force_per_width(force.bone.law.lateral->at_0, 10e-6);
  const double exact = 0.5 * (std::pow(10.0, 0.2 + 0.4) + std::pow(10.0, 0.5 + 0.4)) * 1e3;
  EXPECT_NEAR(lateral, exact, 1e-6 * exact);  // a log law is fitted to the mean of two
  EXPECT_NEAR(force.bone.law.lateral_inclination, 30.0 * units::deg, 1e-12);
  EXPECT_THAT(force.caveats, Contains(HasSubstr("between inclinations of 15 and 45 deg")));
  std::string steep = kCutter;
  steep.replace(steep.find("helix_deg = 30"), 14, "helix_deg = 50");
  EXPECT_THAT(faults_of(steep + bone + kCut), Contains(HasSubstr("15 ... 45 deg")));
}

TEST(ForceCase, RefusesATangentialForceThatDrivesTheEdge) {
  const std::string bone =
      "[bone]\nlaw = \"linear\"\ntangential = { any_deg = { k = -5, edge = 0.1 } }\n"
      "radial = { any_deg = { k = 90 } }\n";
  EXPECT_THAT(faults_of(kCutter + bone + kCut), Contains(HasSubstr("bone.tangential")));
}

TEST(ForceCase, TakesTheLowSpeedLawUpTo100Rpm) {
  const std::string bone =
      "[bone]\nlow_speed = { " + log_law(0.7, 10) + " }\n" + log_law(0.4, 10, "\n") + "\n";
  const auto force_at = [&](const char* rpm) {
    const ForceCase force = read_force_case(
        run_of(kCutter + bone + "[cut]\nspindle_speed_rpm = " + rpm +
               "\nfeed_per_tooth_mm = 0.01\naxial_depth_mm = 8\nimmersion = \"slot\"\n"));
    return cutting::force_per_width(force.bone.law.tangential.at_0, 10e-6);
  };
  EXPECT_DOUBLE_EQ(force_at("100"),
                   cutting::force_per_width(cutting::LogLaw{0.7, 0.6, -0.07}, 10e-6));
  EXPECT_DOUBLE_EQ(force_at("101"),
                   cutting::force_per_width(cutting::LogLaw{0.4, 0.6, -0.07}, 10e-6));
}

TEST(ForceCase, TakesAMapInPlaceOfTheImmersion) {
  write_text_file(scratch("map.csv"), [] {
    std::string text = "height_mm,angle_deg,weight\n";
    for (int slice = 0; slice < 8; ++slice) {
      for (int angle = 0; angle < 180; angle += 2) text += fmt::format("{},{},1\n", slice, angle);
    }
    return text;
  }());
  const std::string cut =
      "[cut]\nspindle_speed_rpm = 5000\nfeed_rate_mm_per_min = 130\n"
      "[engagement]\nfile = \"map.csv\"\n";
  CaseRun run = run_of(kCutter + kLinear + cut);
  run.directory = scratch();
  const ForceCase mapped = read_force_case(run);
  ASSERT_TRUE(mapped.engagement);
  EXPECT_EQ(mapped.engagement->slices, 8);
  EXPECT_EQ(mapped.engagement->angles, 180);
  const ForceCase nominal = read_force_case(run_of(kCutter + kLinear + kCut));
  const auto one =
      cutting::predict(mapped.cutter, mapped.bone.law, mapped.condition, *mapped.engagement);
  const auto other =
      cutting::predict(nominal.cutter, nominal.bone.law, nominal.condition, nominal.immersion);
  // Patches of two degrees taken at their middle: (2 pi/180)²/24 of the curvature.
  EXPECT_LT((one.mean.force - other.mean.force).norm(), 2e-4 * other.mean.force.norm());
  EXPECT_NEAR(one.rubbing_power, other.rubbing_power, 1e-4 * other.rubbing_power);

  const auto faults_with = [&](const std::string& text) {
    write_text_file(scratch("map.csv"), text);
    std::string texts;
    try {
      read_force_case(run);
    } catch (const InvalidInput& error) {
      texts = error.what();
    }
    return texts;
  };
  EXPECT_THAT(faults_with("height_mm,angle_deg\n0,0\n"), HasSubstr("weight"));
  EXPECT_THAT(faults_with("height_mm,angle_deg,weight\n0,0,x\n0,400,1\n"),
              testing::AllOf(HasSubstr("map.csv:2"), HasSubstr("map.csv:3")));
  EXPECT_THAT(faults_with("height_mm,angle_deg,weight\n0,0,1\n0,7,1\n1,0,1\n"),
              HasSubstr("whole part of 360"));
  EXPECT_THAT(faults_with("height_mm,angle_deg,weight\n0,0,1\n"), HasSubstr("size of a patch"));
  EXPECT_THAT(faults_with("height_mm,angle_deg,weight\n0,0,1\n60,5,1\n"),
              HasSubstr("cutting length"));
}

TEST(ForceCase, ReadsTheGeneralCutterOfApt) {
  const std::string apt =
      "[cutter]\nshape = \"apt\"\ndiameter_mm = 8\nflutes = 2\ncutting_length_mm = 12\n"
      "corner_radius_mm = 1\ncorner_centre_radius_mm = 3.06485\n"
      "corner_centre_height_mm = 1.85651\nbottom_deg = 15\ntaper_deg = 5\n";
  const ForceCase force = read_force_case(run_of(apt + kLinear + kCut));
  // The upper line: from where the lines meet, 5 degrees against the axis up to 12 mm.
  const double meet = 4.0 * std::tan(15.0 * units::deg);
  EXPECT_NEAR(force.cutter.radius, 1e-3 * (4.0 + (12.0 - meet) * std::tan(5.0 * units::deg)), 1e-8);
  std::string small = apt;
  small.replace(small.find("corner_radius_mm = 1\n"), 20, "corner_radius_mm = 0.5");
  EXPECT_THAT(faults_of(small + kLinear + kCut), Contains(HasSubstr("must reach the lower line")));
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
