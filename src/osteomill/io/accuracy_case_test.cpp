// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/accuracy_case.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/section.hpp"

namespace osteomill::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

CaseRun run_of(const std::string& text) {
  CaseRun run;
  run.tree = parse_toml(text, "case.toml");
  return run;
}

const std::string kBone =
    "[bone]\nlaw = \"linear\"\ntangential = { any_deg = { k = 200, edge = 3 } }\n"
    "radial = { any_deg = { k = 90, edge = 5 } }\n";
const std::string kCutting =
    "[cutter]\nshape = \"cylindrical\"\ndiameter_mm = 3.1\nflutes = 2\n" + kBone +
    "[cut]\nspindle_speed_rpm = 20000\nfeed_per_tooth_mm = 0.005\naxial_depth_mm = 5\n"
    "immersion = \"slot\"\n";
const std::string kTool =
    "[tool]\nlength_mm = 35\neffective_diameter_mm = 2.54\nyoungs_modulus_gpa = 197\n";
const std::string kBeam =
    "[beam]\nyoungs_modulus_gpa = 197\ndensity_kg_per_m3 = 7850\n"
    "segments = [ { length_mm = 35, diameter_mm = 2.54 } ]\n"
    "supports = [ { at_mm = 0, type = \"clamp\" } ]\n";
const std::string kChoose =
    "[[candidate]]\nname = \"a\"\nuse = \"midas-rex-m10\"\nflutes = 4\ntool_length_mm = 35\n" +
    kBone +
    "[job]\nkerf_area_mm2 = 3000\n[choose]\nfeed_per_tooth_mm = [0.001, 0.02]\n"
    "spindle_speed_rpm = [20000]\naxial_depth_mm = [1, 30]\n";

template <class Read>
std::string faults_of(Read read, const std::string& text) {
  try {
    read(run_of(text));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "none";
}

TEST(DeflectCase, TakesTheToolFromTheCuttersShank) {
  const std::string shank =
      "[cutter.shank]\nfree_length_mm = 35\ndiameter_mm = 3.1\nyoungs_modulus_gpa = 197\n"
      "density_kg_per_m3 = 7850\neffective_diameter_factor = 0.82\n";
  const std::string length = "[cutter]\ncutting_length_mm = 35\n";
  const std::string cutting = length + kCutting.substr(std::string("[cutter]\n").size());
  const DeflectCase one = read_deflect_case(run_of(cutting + shank));
  const DeflectCase same = read_deflect_case(
      run_of(cutting +
             "[tool]\nlength_mm = 35\neffective_diameter_mm = 2.542\nyoungs_modulus_gpa = 197\n"));
  EXPECT_NEAR(one.tool->tip_stiffness(), same.tool->tip_stiffness(),
              1e-6 * same.tool->tip_stiffness());
  // A [tool] or a [beam] of the case's own stands above the cutter's shank.
  EXPECT_NEAR(read_deflect_case(run_of(cutting + shank + kTool)).tool->tip_stiffness(),
              read_deflect_case(run_of(cutting + kTool)).tool->tip_stiffness(), 1e-9);
  EXPECT_THAT(
      faults_of(read_deflect_case, cutting +
                                       "[cutter.shank]\nfree_length_mm = 30\ndiameter_mm = 0\n"
                                       "youngs_modulus_gpa = 197000\n"),
      AllOf(HasSubstr("cutter.shank.diameter_mm"), HasSubstr("cutter.shank.youngs_modulus_gpa"),
            HasSubstr("cutter.shank.density_kg_per_m3")));
  EXPECT_THAT(faults_of(read_deflect_case,
                        cutting + "[cutter.shank]\nfree_length_mm = 30\ndiameter_mm = 3.1\n"
                                  "youngs_modulus_gpa = 197\ndensity_kg_per_m3 = 7850\n"
                                  "holder_stiffness_n_per_mm = 3000\n"),
              AllOf(HasSubstr("free_length_mm"), HasSubstr("cutting length"), HasSubstr("both")));
}

TEST(AccuracyCase, ReadsToolOrBeamAlike) {
  const DeflectCase tool = read_deflect_case(run_of(kCutting + kTool));
  const DeflectCase beam = read_deflect_case(run_of(kCutting + kBeam));
  EXPECT_NEAR(tool.tool->tip_stiffness() * units::mm, 28.16, 0.01);
  EXPECT_NEAR(beam.tool->tip_stiffness(), tool.tool->tip_stiffness(),
              1e-6 * tool.tool->tip_stiffness());
  EXPECT_FALSE(tool.structure);
  EXPECT_FALSE(tool.surface);
}

TEST(AccuracyCase, ReadsStructureSurfaceAndBudget) {
  const DeflectCase one = read_deflect_case(
      run_of(kCutting + kBeam +
             "[structure]\ndamping_ratio = 0.03\n[surface]\nwidth_mm = 60\nfeed = \"outward\"\n"
             "[budget]\nsources = [ { name = \"registration\", varus_valgus_deg = 0.3, times = 2 } "
             "]\n"));
  ASSERT_TRUE(one.structure && one.surface && one.budget);
  EXPECT_EQ(one.structure->modes.size(), 4u);
  EXPECT_EQ(one.surface->feed, FeedPattern::outward);
  ASSERT_EQ(one.budget->varus_valgus.size(), 1u);
  EXPECT_NEAR(one.budget->varus_valgus[0].spread, 0.3 * units::deg, 1e-15);
  EXPECT_EQ(one.budget->flexion_extension[0].times, 2);
  EXPECT_NEAR(one.tool->tip_stiffness() * units::mm, 28.16, 0.01);
}

TEST(AccuracyCase, TurnsTheLoadOnAFixationIntoBiasAndSpread) {
  const auto with = [](const std::string& source) {
    return kCutting + kTool + "[budget]\nsources = [ { name = \"fixation\", " + source + " } ]\n";
  };
  const DeflectCase one = read_deflect_case(
      run_of(with("load_n = 10, load_sd_n = 5, flexion_extension_deg_per_n = 0.009")));
  EXPECT_EQ(one.budget->varus_valgus[0].spread, 0.0);
  EXPECT_NEAR(one.budget->flexion_extension[0].bias, 0.09 * units::deg, 1e-15);
  EXPECT_NEAR(one.budget->flexion_extension[0].spread, 0.045 * units::deg, 1e-15);
  EXPECT_THAT(faults_of(read_deflect_case, with("varus_valgus_deg_per_n = 0.1")),
              HasSubstr("load_n"));
  EXPECT_THAT(faults_of(read_deflect_case, with("load_n = 1")), HasSubstr("compliance"));
  EXPECT_THAT(faults_of(read_deflect_case,
                        with("load_n = 1, varus_valgus_deg_per_n = 0.1, varus_valgus_deg = 1")),
              HasSubstr("two sources"));
}

TEST(AccuracyCase, ReadsCandidatesFromTheCatalogue) {
  const OptimiseCase one = read_optimise_case(run_of(kChoose));
  ASSERT_EQ(one.candidates.size(), 1u);
  EXPECT_EQ(one.candidates[0].cutter.flutes, 4);
  EXPECT_NEAR(one.candidates[0].cutter.radius, 1.55e-3, 1e-12);
  EXPECT_EQ(one.problem.spans[1].low, one.problem.spans[1].high);
}

TEST(AccuracyCase, CalibratesTheHeatRelation) {
  const OptimiseCase one = read_optimise_case(
      run_of(kChoose +
             "[heat]\nstart_c = 25\nobservations = [ { axial_depth_mm = 5, spindle_speed_rpm = "
             "5000, flutes = 2, feed_rate_mm_per_s = 3.3333333, temperature_c = 45 } ]\n"));
  // l ω N/f = 2π · 5 mm/0.02 mm.
  EXPECT_NEAR(one.problem.heat.coefficient, 20.0 / (2.0 * 3.14159265 * 250.0), 1e-6);
  ASSERT_TRUE(one.heat_fit);
  EXPECT_NEAR(one.heat_fit->residual_rms, 0.0, 1e-9);
}

TEST(AccuracyCase, NamesEveryFault) {
  EXPECT_THAT(faults_of(read_deflect_case, kCutting), HasSubstr("tool"));
  EXPECT_THAT(faults_of(read_deflect_case, kCutting + kTool + kBeam), HasSubstr("beside a [beam]"));
  EXPECT_THAT(faults_of(read_deflect_case, kCutting + "[tool]\nlength_mm = -1\n"),
              AllOf(HasSubstr("tool.length_mm"), HasSubstr("tool.effective_diameter_mm"),
                    HasSubstr("tool.youngs_modulus_gpa")));
  EXPECT_THAT(faults_of(read_optimise_case, kBone),
              AllOf(HasSubstr("candidate"), HasSubstr("job"), HasSubstr("choose")));
  EXPECT_THAT(
      faults_of(read_optimise_case, kChoose + "[[candidate]]\nname = \"b\"\nuse = \"nothing\"\n"
                                              "tool_length_mm = 35\n"),
      HasSubstr("candidate"));
  EXPECT_THAT(faults_of(read_optimise_case, kChoose + "[heat]\nstart_c = 20\n"),
              HasSubstr("coefficient_k"));
  EXPECT_THAT(faults_of(read_optimise_case, kChoose + "[limits]\ntemperature_c = 47\n"),
              HasSubstr("heat"));
}

TEST(AccuracyCase, ExamplesAreRead) {
  const std::filesystem::path examples = OSTEOMILL_SOURCE_DIR "/examples";
  for (const CaseRun& run : read_case(examples / "deflection.toml", {})) read_deflect_case(run);
  for (const CaseRun& run : read_case(examples / "choose_conditions.toml", {})) {
    EXPECT_EQ(read_optimise_case(run).candidates.size(), 4u);
  }
}

}  // namespace
}  // namespace osteomill::io
