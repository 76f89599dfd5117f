// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/fit_case.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/force_case.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

CaseRun run_of(const std::string& text) {
  CaseRun run;
  run.tree = parse_toml(text, "case.toml");
  run.directory = scratch();
  return run;
}

/// Exact cuts of log laws in two directions, each twice.
void write_cuts() {
  std::string text =
      "direction_deg,speed_m_per_s,chip_thickness_um,tangential_n_per_mm,"
      "radial_n_per_mm\n";
  for (const int direction : {0, 90}) {
    for (const double h : {2.5, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0}) {
      for (const double off : {-0.01, 0.01}) {
        const double tangential =
            cutting::force_per_width(cutting::LogLaw{direction == 0 ? 0.42 : 0.3, 0.6, -0.07},
                                     h * units::um) /
            units::n_per_mm;
        const double radial =
            cutting::force_per_width(cutting::LogLaw{0.6, 0.4, -0.2}, h * units::um) /
            units::n_per_mm;
        text +=
            fmt::format("{},3.5,{},{:.9g},{:.9g}\n", direction, h, tangential + off, radial + off);
        if (h == 10.0 && direction == 0) {
          text += fmt::format("{},1.3,{},{:.9g},{:.9g}\n", direction, h, 0.5 * tangential + off,
                              radial + off);
        }
      }
    }
  }
  write_text_file(scratch("cuts.csv"), text);
}

std::string faults_of(const std::string& text) {
  try {
    read_fit_case(run_of(text));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "none";
}

TEST(FitCase, ReadsSeriesByComponentAndDirectionAndAveragesThem) {
  write_cuts();
  const FitCase fit = read_fit_case(run_of("[cuts]\nfile = \"cuts.csv\"\nspeed_m_per_s = 3.5\n"));
  ASSERT_EQ(fit.series.size(), 4u);
  EXPECT_EQ(fit.series[0].component, "tangential");
  EXPECT_EQ(fit.series[1].direction, 90);
  EXPECT_EQ(fit.series[0].cuts.size(), 7u);
  EXPECT_NEAR(cutting::fit_log_law(fit.series[1].cuts).law.k1, 0.3, 1e-6);
  ASSERT_EQ(fit.series[0].speed_effects.size(), 1u);
  EXPECT_LT(fit.series[0].speed_effects[0].p, 1e-4);  // twice the force at the higher speed
  EXPECT_GT(fit.series[2].speed_effects[0].p, 0.9);   // the same force
  const FitCase single = read_fit_case(
      run_of("[cuts]\nfile = \"cuts.csv\"\nspeed_m_per_s = 3.5\nsingle_cuts = true\n"));
  EXPECT_EQ(single.series[0].cuts.size(), 14u);
}

TEST(FitCase, WritesABoneThatOtherCommandsTake) {
  write_cuts();
  const FitCase fit = read_fit_case(
      run_of("[cuts]\nfile = \"cuts.csv\"\nspeed_m_per_s = 3.5\n[fit]\nrake_deg = 10\n"));
  std::vector<FittedSeries> fitted;
  for (const FitSeries& series : fit.series) {
    fitted.push_back(
        {series, cutting::fit_power_law(series.cuts), cutting::fit_log_law(series.cuts)});
  }
  for (const bool log_laws : {true, false}) {
    write_text_file(scratch("bone.toml"), bone_entry(fit, fitted, log_laws));
    write_text_file(scratch("case.toml"),
                    "[cutter]\nshape = \"cylindrical\"\ndiameter_mm = 6.35\nflutes = 2\n"
                    "rake_deg = 10\n[bone]\nuse = \"bone.toml\"\n"
                    "[cut]\nspindle_speed_rpm = 5000\nfeed_per_tooth_mm = 0.01\n"
                    "axial_depth_mm = 5\nimmersion = \"slot\"\n");
    const ForceCase force = read_force_case(read_case(scratch("case.toml"), {}).front());
    const cutting::EdgeForce law =
        log_laws ? cutting::EdgeForce(fitted[1].log.law) : cutting::EdgeForce(fitted[1].power.law);
    // The entry has six digits.
    EXPECT_NEAR(cutting::force_per_width(*force.bone.law.tangential.at_90, 20e-6),
                cutting::force_per_width(law, 20e-6), 1e-4 * cutting::force_per_width(law, 20e-6));
    EXPECT_EQ(force.bone.provenance.obtained, bone::Obtained::measured);
  }
}

TEST(FitCase, NamesEveryFaultOfItsTable) {
  const std::string text = "[cuts]\nfile = \"bad.csv\"\n";
  write_text_file(scratch("bad.csv"),
                  "chip_thickness_um,tangential_n_per_mm,direction_deg,colour\n"
                  "0,3,0,1\n5,-1,45,1\n");
  EXPECT_THAT(faults_of(text), AllOf(HasSubstr("colour"), HasSubstr("bad.csv:2"),
                                     HasSubstr("bad.csv:3"), HasSubstr("direction_deg")));
  write_text_file(scratch("bad.csv"), "depth,force\n1,2\n");
  EXPECT_THAT(faults_of(text), HasSubstr("chip_thickness_um"));
  write_text_file(scratch("bad.csv"), "chip_thickness_um,radial_n_per_mm\n");
  EXPECT_THAT(faults_of(text), HasSubstr("holds no cut"));
  write_cuts();
  EXPECT_THAT(faults_of("[cuts]\nfile = \"cuts.csv\"\nspeed_m_per_s = 9\n"),
              HasSubstr("cuts.speed_m_per_s"));
  EXPECT_THAT(faults_of("[cuts]\nfile = \"nowhere.csv\"\n"), HasSubstr("nowhere.csv"));
}

}  // namespace
}  // namespace osteomill::io
