// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/vibration_case.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

using testing::HasSubstr;

CaseRun run_of(const std::string& text) {
  CaseRun run;
  run.tree = parse_toml(text, "case.toml");
  return run;
}

const std::string kBeam =
    "[beam]\nyoungs_modulus_gpa = 197\ndensity_kg_per_m3 = 7850\n"
    "segments = [ { length_mm = 100, diameter_mm = 3.1 } ]\n"
    "supports = [ { at_mm = 0, type = \"clamp\" }, { at_mm = 66, type = \"pin\" } ]\n";
const std::string kModes =
    "[structure]\nmodes = [ { direction = \"x\", frequency_hz = 922, damping_ratio = 0.011, "
    "modal_mass_kg = 0.04 }, { direction = \"y\", frequency_hz = 700, damping_ratio = 0.02, "
    "stiffness_n_per_mm = 1000 } ]\n";
const std::string kCut =
    "[cut]\nflutes = 2\nimmersion = \"up\"\nradial_immersion = 0.5\n"
    "tangential_coefficient_n_per_mm2 = 600\nradial_coefficient_n_per_mm2 = 200\n";
const std::string kOptions = "[options]\nspindle_speeds_rpm = [5000]\nmax_depth_mm = 10\n";

template <class Read>
std::string faults_of(Read read, const std::string& text) {
  try {
    read(run_of(text));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "none";
}

TEST(VibrationCase, ReadsABeam) {
  const ModesCase one = read_modes_case(run_of(kBeam + "[options]\nmodes = 2\n"));
  EXPECT_TRUE(one.exact);
  EXPECT_EQ(one.modes, 2);
  ASSERT_EQ(one.beam.supports.size(), 2u);
  EXPECT_DOUBLE_EQ(one.beam.supports[1].position, 0.066);
  EXPECT_DOUBLE_EQ(one.beam.segments[0].diameter, 0.0031);
}

TEST(VibrationCase, TakesTheBeamFromTheCuttersShank) {
  const std::string cutter =
      "[cutter]\nshape = \"cylindrical\"\ndiameter_mm = 3.1\nflutes = 2\n"
      "cutting_length_mm = 35\n[cutter.shank]\nfree_length_mm = 55\ndiameter_mm = 3.1\n"
      "youngs_modulus_gpa = 197\ndensity_kg_per_m3 = 7850\n";
  const ModesCase one = read_modes_case(run_of(cutter));
  ASSERT_EQ(one.beam.segments.size(), 2u);
  EXPECT_DOUBLE_EQ(one.beam.segments[1].length, 0.035);
  const std::string cut =
      "[bone]\nlaw = \"linear\"\ntangential = { any_deg = { k = 200 } }\n"
      "radial = { any_deg = { k = 90 } }\n"
      "[cut]\nspindle_speed_rpm = 20000\nfeed_per_tooth_mm = 0.005\naxial_depth_mm = 5\n"
      "immersion = \"slot\"\n";
  // Each of the modes asked for, in both directions.
  const std::string structure = "[structure]\nbeam_modes = 3\n";
  const RespondCase respond = read_respond_case(
      run_of(cutter + cut + structure + "[options]\nspindle_speeds_rpm = [20000]\n"));
  EXPECT_EQ(respond.structure.modes.size(), 6u);
  const StabilityCase stability = read_stability_case(run_of(cutter + cut + structure + kOptions));
  EXPECT_EQ(stability.structure.modes.size(), 6u);
}

TEST(VibrationCase, ReadsModesByMassOrStiffness) {
  const StabilityCase one = read_stability_case(run_of(kModes + kCut + kOptions));
  ASSERT_EQ(one.structure.modes.size(), 2u);
  EXPECT_EQ(one.structure.modes[0].direction_y, 0.0);
  EXPECT_EQ(one.structure.modes[1].direction_x, 0.0);
  EXPECT_NEAR(vibration::modal_stiffness(one.structure.modes[1]), 1e6, 1e-6);
  EXPECT_NEAR(one.cut->exit(), std::numbers::pi / 2.0, 1e-12);
}

TEST(VibrationCase, TakesTheModesOfABeamInBothDirections) {
  const StabilityCase one = read_stability_case(
      run_of(kBeam + "[structure]\ndamping_ratio = 0.03\nbeam_modes = 2\n" + kCut + kOptions));
  ASSERT_EQ(one.structure.modes.size(), 4u);
  EXPECT_NEAR(one.structure.modes[2].frequency_hz, 1034.05, 0.05);
  EXPECT_EQ(one.structure.modes[2].direction_y, 1.0);
  EXPECT_THAT(one.caveats, testing::Contains(HasSubstr("damping ratio")));
}

TEST(VibrationCase, LinearisesACutterInABone) {
  const StabilityCase one = read_stability_case(
      run_of(kModes +
             "[cutter]\nshape = \"cylindrical\"\ndiameter_mm = 6\nflutes = 2\n"
             "[bone]\nlaw = \"linear\"\ntangential = { any_deg = { k = 200, edge = 3 } }\n"
             "radial = { any_deg = { k = 90, edge = 5 } }\n"
             "[cut]\nspindle_speed_rpm = 9000\nfeed_per_tooth_mm = 0.02\naxial_depth_mm = 2\n"
             "immersion = \"slot\"\n" +
             kOptions));
  EXPECT_NEAR(one.cut->edge(1.0).tangential, 200e6, 1e3);
  EXPECT_DOUBLE_EQ(*one.depth, 0.002);
}

TEST(VibrationCase, NamesEveryFault) {
  EXPECT_THAT(faults_of(read_modes_case, "[beam]\nyoungs_modulus_gpa = -1\n"),
              testing::AllOf(HasSubstr("beam.youngs_modulus_gpa"),
                             HasSubstr("beam.density_kg_per_m3"), HasSubstr("beam.segments")));
  EXPECT_THAT(faults_of(read_stability_case, "[structure]\n" + kCut + kOptions),
              HasSubstr("no modes"));
  EXPECT_THAT(faults_of(read_stability_case, kModes + kBeam + kCut + kOptions),
              HasSubstr("more than one"));
  EXPECT_THAT(faults_of(read_stability_case, kModes + kCut + "[options]\nmax_depth_mm = 10\n"),
              HasSubstr("spindle_speeds_rpm"));
  EXPECT_THAT(faults_of(read_stability_case, kModes + kCut + kOptions +
                                                 "method = \"zero-order\"\ncontinuation = true\n"),
              HasSubstr("Floquet"));
  EXPECT_THAT(
      faults_of(read_stability_case, kModes +
                                         "[cut]\nflutes = 2\nimmersion = \"up\"\n"
                                         "tangential_coefficient_n_per_mm2 = 600\n"
                                         "radial_coefficient_n_per_mm2 = 200\nhelix_deg = 30\n" +
                                         kOptions),
      testing::AllOf(HasSubstr("radial_immersion"), HasSubstr("diameter_mm")));
}

TEST(VibrationCase, ExamplesAreRead) {
  const std::filesystem::path examples = OSTEOMILL_SOURCE_DIR "/examples";
  for (const CaseRun& run : read_case(examples / "tool_modes.toml", {})) read_modes_case(run);
  for (const char* lobes : {"lobes.toml", "measured_lobes.toml"}) {
    for (const CaseRun& run : read_case(examples / lobes, {})) read_stability_case(run);
  }
  for (const CaseRun& run : read_case(examples / "forced_vibration.toml", {})) {
    EXPECT_EQ(read_respond_case(run).speeds.size(), 400u);
  }
}

}  // namespace
}  // namespace osteomill::io
