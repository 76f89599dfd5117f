// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/test_table.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/experiments.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

std::filesystem::path put(const std::string& name, const std::string& text) {
  write_text_file(scratch(name), text);
  return scratch(name);
}

TEST(TestTable, BringsEachUnitToSi) {
  const auto rows = read_test_table(put(
      "table.csv",
      "name;group;axial_depth_mm;feed_rate_mm_per_min;spindle_speed_rpm;flutes;immersion;"
      "radial_depth_um;diameter_mm;fibre_angle_deg;mean_force_x_kn;mean_force_y_kn;mean_force_z_kn;"
      "standard_error_x_n;standard_error_y_n;standard_error_z_n;operator\n"
      "a;tibia 1;0.5;60;5000;4;up;1500;6;90;0.001;-0.002;0.003;0.1;0.2;0.3;me\n"
      "b;tibia 2;1;120;6000;2;slot;;6;;0.004;0.005;0.006;;;;me\n"));
  ASSERT_THAT(rows, SizeIs(2));
  EXPECT_EQ(rows[0].group, "tibia 1");
  EXPECT_DOUBLE_EQ(*rows[0].axial_depth, 0.5e-3);
  EXPECT_DOUBLE_EQ(*rows[0].feed_rate, 1e-3);
  EXPECT_DOUBLE_EQ(*rows[0].spindle_speed, 5000 * units::rpm);
  EXPECT_EQ(*rows[0].flutes, 4);
  EXPECT_EQ(*rows[0].immersion, cutting::ImmersionKind::up);
  EXPECT_DOUBLE_EQ(*rows[0].radial_depth, 1.5e-3);
  EXPECT_DOUBLE_EQ(*rows[0].fibre_angle, 90 * units::deg);
  EXPECT_TRUE(rows[0].mean_force->isApprox(geometry::Vector3(1, -2, 3)));
  EXPECT_TRUE(rows[0].standard_error->isApprox(geometry::Vector3(0.1, 0.2, 0.3)));
  EXPECT_FALSE(rows[1].standard_error);
  EXPECT_FALSE(rows[1].radial_depth);
  EXPECT_EQ(rows[1].line, 3);
}

TEST(TestTable, NamesEveryFaultWithItsLine) {
  struct Bad {
    const char* text;
    const char* says;
  };
  for (const Bad& bad :
       {Bad{"axial_depth,mean_force_x_n,mean_force_y_n,mean_force_z_n\n1,1,2,3\n",
            "axial_depth: does not say its unit, or one that it cannot have; name it "
            "axial_depth_mm, axial_depth_um, axial_depth_m"},
        {"axial_depth_inch,mean_force_x_n,mean_force_y_n,mean_force_z_n\n1,1,2,3\n",
         "axial_depth_inch: does not say its unit"},
        {"axial_depth_mm,axial_depth_um,record\n1,1000,a.csv\n", "stands twice, in two units"},
        {"axial_depth_mm,mean_force_x_n,mean_force_y_n,mean_force_z_n\n1,1,,3\n",
         "table.csv:2: mean_force = 2 of x, y, z: must be given for all three axes"},
        {"axial_depth_mm,mean_force_x_n,mean_force_y_n,mean_force_z_n\n-1,1,2,3\n",
         "axial_depth_mm = -1: must be > 0"},
        {"axial_depth_mm,mean_force_x_n,mean_force_y_n,mean_force_z_n\nbig,1,2,3\n",
         "axial_depth_mm = big: must be a number"},
        {"axial_depth_mm\n1\n", "neither a record nor mean forces are given"},
        {"record,mean_force_x_n,mean_force_y_n,mean_force_z_n\na.csv,1,2,3\n",
         "stands beside mean forces"},
        {"record,immersion\na.csv,half\n", "immersion = half: must be slot, up or down"},
        {"record,flutes\na.csv,2.5\n", "must be a whole number"},
        {"record,name\na.csv,x\nb.csv,x\n", "table.csv:3: name = x: stands twice"},
        {"record\n", "needs one experiment at least"}}) {
    try {
      read_test_table(put("table.csv", bad.text));
      ADD_FAILURE() << bad.says;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr(bad.says));
    }
  }
}

ExperimentsCase read(const std::string& toml) {
  ExperimentsCase out;
  for (const CaseRun& run : read_case(put("case.toml", toml), {})) {
    Section::read(run, [&](Section& section) {
      out = {};
      bind_experiments(section, out);
    });
  }
  return out;
}

/// A slot cut of two flutes at 6000 rpm: mean force 4, -10, 2 N about idle values.
std::string record_of(double scale) {
  std::string text = "time_s,Fx_N,Fy_N,Fz_N\n";
  for (int i = 0; i < 12000; ++i) {
    const double t = i / 4000.0, wave = std::cos(2.0 * M_PI * 200.0 * t);
    const bool cut = i >= 2000 && i < 10000;
    // A little noise that does not repeat with the revolution.
    const double noise = 0.05 * std::sin(0.37 * i * i);
    text += fmt::format("{:.6f},{:.4f},{:.4f},{:.4f}\n", t,
                        1.0 + noise + cut * scale * (4.0 + 3.0 * wave),
                        2.0 + cut * scale * (-10.0 - 4.0 * wave), -3.0 + cut * scale * 2.0);
  }
  return text;
}

const ExperimentDefaults kDefaults{
    .cutter = {.radius = 3e-3, .flutes = 2, .cutting_length = 10e-3},
    .immersion = {},
    .spindle_speed = 6000 * units::rpm,
};

TEST(Experiments, RecordsAndMeansOfATableBecomeExperiments) {
  put("one.csv", record_of(1.0));
  put("two.csv", record_of(2.0));
  put("table.csv",
      "name,group,axial_depth_mm,feed_per_tooth_um,record,mean_force_x_n,mean_force_y_n,"
      "mean_force_z_n\na,1,1,5,one.csv,,,\nb,2,2,5,two.csv,,,\nc,2,3,8,,7,8,9\n");
  const ExperimentsCase from = read(
      "[experiments]\ntable = \"table.csv\"\n"
      "[record]\naxes = [\"x\", \"-y\", \"-z\"]\n"
      "[signals]\nbaseline = \"tare\"\nfilter_order = 4\ncutoff_over_tooth_passing = "
      "5\naverage_flutes = true\n");
  int seen = 0;
  const auto loaded =
      load_experiments(from, kDefaults, [&](const identify::ForceRecord& raw, const auto& one) {
        ++seen;
        EXPECT_EQ(raw.force.rows(), 12000);
        EXPECT_TRUE(one.processed->revolution.has_value());
      });
  ASSERT_THAT(loaded, SizeIs(3));
  EXPECT_EQ(seen, 2);
  for (const int i : {0, 1}) {
    const auto& one = loaded[static_cast<std::size_t>(i)].experiment;
    // Noise of 0.035 N rms over 8000 samples and 4000 idle ones leaves 0.001 N.
    EXPECT_LT((one.mean_force - (i + 1) * geometry::Vector3(4.0, 10.0, -2.0)).norm(), 0.01);
    EXPECT_DOUBLE_EQ(one.immersion.axial_depth, (i + 1) * 1e-3);
    EXPECT_DOUBLE_EQ(one.condition.feed_per_tooth, 5e-6);
    EXPECT_GT(one.standard_error.x(), 1e-5);
    EXPECT_LT(one.standard_error.x(), 5e-3);
  }
  EXPECT_TRUE(loaded[2].experiment.mean_force.isApprox(geometry::Vector3(7, -8, -9)));
  EXPECT_FALSE(loaded[2].processed);
  EXPECT_EQ(loaded[2].experiment.group, "2");
  EXPECT_THAT(loaded[0].notes, SizeIs(11));
}

TEST(Experiments, FaultsSayWhichRowTheyComeFrom) {
  put("one.csv", record_of(1.0));
  put("table.csv",
      "name,axial_depth_mm,feed_per_tooth_um,record\na,1,5,one.csv\nb,,5,one.csv\n"
      "c,1,5,missing.csv\nd,50,5,one.csv\ne,1,,one.csv\n");
  try {
    load_experiments(read("[experiments]\ntable = \"table.csv\"\n"), kDefaults);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.faults(), SizeIs(4));
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("table.csv:3: axial_depth_mm: is missing"),
                      HasSubstr("table.csv:4: "), HasSubstr("missing.csv"),
                      HasSubstr("table.csv:5: "), HasSubstr("table.csv:6: feed_per_tooth_mm")));
  }
}

TEST(Experiments, TheFeedMayStandTwiceWhereItAgrees) {
  const std::string head =
      "axial_depth_mm,feed_per_tooth_um,feed_rate_mm_per_min,mean_force_x_n,mean_force_y_n,"
      "mean_force_z_n\n";
  // 5 um × 2 flutes × 6000 rpm = 60 mm/min.
  put("table.csv", head + "1,5,60,1,2,3\n");
  const auto from = read("[experiments]\ntable = \"table.csv\"\n");
  EXPECT_DOUBLE_EQ(load_experiments(from, kDefaults)[0].experiment.condition.feed_per_tooth, 5e-6);
  put("table.csv", head + "1,5,70,1,2,3\n");
  try {
    load_experiments(from, kDefaults);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("70 mm/min make 5.833 um a tooth, but feed_per_tooth is 5"));
  }
}

TEST(Experiments, TheCaseSaysAllThatIsWrongWithIt) {
  try {
    read(
        "[experiments]\ntable = \"none.csv\"\n[record]\naxes = [\"x\", \"x\", \"z\"]\n"
        "tare_n = [1, 2]\ncolumns = [\"a\", \"b\"]\n"
        "[signals]\nfilter_order = 99\nplateau_s = [1]\nrotation = \"guess\"\n");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.faults(), SizeIs(7));
  }
}

TEST(Dynamometer, IsReadForOneAxisOrThree) {
  const auto all =
      read_dynamometer(put("frf.csv", "frequency_hz,real,imaginary\n10,1,0\n20,1.1,-0.1\n"));
  EXPECT_EQ(all.response(1, 2), std::complex<double>(1.1, -0.1));
  const auto each = read_dynamometer(put(
      "frf.csv",
      "frequency_hz,real_x,imaginary_x,real_y,imaginary_y,real_z,imaginary_z\n10,1,2,3,4,5,6\n"));
  EXPECT_EQ(each.response(0, 1), std::complex<double>(3, 4));
  EXPECT_THROW(read_dynamometer(put("frf.csv", "frequency_hz,real\n10,1\n")), InvalidInput);
  EXPECT_THROW(read_dynamometer(put("frf.csv", "frequency_hz,real,imaginary\n10,1,no\n")),
               InvalidInput);
}

}  // namespace
}  // namespace osteomill::io
