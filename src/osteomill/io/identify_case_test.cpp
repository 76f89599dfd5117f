// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/identify_case.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/force_case.hpp"
#include "osteomill/io/identify_result.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using testing::HasSubstr;

constexpr const char* kTable =
    "axial_depth_mm,feed_per_tooth_mm,mean_force_x_n,mean_force_y_n,mean_force_z_n\n"
    "1,0.02,-8.1,11.7,-2.0\n1,0.05,-10.2,15.9,-3.9\n1,0.1,-13.8,22.6,-7.1\n"
    "2,0.02,-16.4,23.1,-4.1\n2,0.05,-20.1,32.1,-7.6\n2,0.1,-27.9,45.0,-14.3\n";

constexpr const char* kRest =
    "[cutter]\nshape = \"cylindrical\"\ndiameter_mm = 6\nflutes = 2\nhelix_deg = 30\n"
    "[cut]\nimmersion = \"slot\"\nspindle_speed_rpm = 3000\n";

/// A case with this [model], beside its table.
std::filesystem::path put_case(const std::string& model, const std::string& table = kTable) {
  write_text_file(scratch("cuts.csv"), table);
  write_text_file(scratch("case.toml"),
                  std::string("[experiments]\ntable = \"cuts.csv\"\n") + kRest + model);
  return scratch("case.toml");
}

IdentifyCase read(const std::filesystem::path& file) {
  return read_identify_case(read_case(file, {}).at(0));
}

std::string refusal(const std::string& model, const std::string& table = kTable) {
  try {
    const IdentifyCase input = read(put_case(model, table));
    identify::identify_mean_forces(input.experiments, input.models, input.options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(IdentifyCase, TheEntryGivesBackTheForcesOfTheLawItWasWrittenFrom) {
  for (const char* model :
       {"[model]\nlaw = \"linear\"\n", "[model]\nlaw = \"power\"\n", "[model]\nlaw = \"log\"\n",
        "[model]\nlaw = \"polynomial\"\n", "[model]\nlaw = \"linear\"\nshear_order = -1\n"}) {
    const IdentifyCase input = read(put_case(model));
    const auto result =
        identify::identify_mean_forces(input.experiments, input.models, input.options);
    write_text_file(scratch("bone.toml"), catalogue_entry_of(input, result));
    write_text_file(scratch("force.toml"), std::string(kRest) +
                                               "axial_depth_mm = 2\nfeed_per_tooth_mm = 0.05\n"
                                               "[bone]\nuse = \"bone.toml\"\n");
    const ForceCase force = read_force_case(read_case(scratch("force.toml"), {}).at(0));
    const geometry::Vector3 mean =
        cutting::mean_load(force.cutter, force.bone.law, force.condition, force.immersion).force;
    // Both are means over a revolution, each integrated to 1e-5.
    EXPECT_LT((mean - result.best().fit->predicted.row(4).transpose()).norm(), 2e-5 * mean.norm())
        << model;
    EXPECT_TRUE(force.caveats.empty()) << model;
  }
}

TEST(IdentifyCase, DocumentHasTheKeysOfTheContract) {
  const IdentifyCase input = read(put_case("[model]\nlaw = \"linear\"\n"));
  const auto result =
      identify::identify_mean_forces(input.experiments, input.models, input.options);
  const auto document = identify_document(input, result);
  std::vector<std::string> names;
  for (const auto& one : document.at("coefficients")) {
    names.push_back(one.at("name"));
    EXPECT_TRUE(one.contains("value") && one.contains("unit") && one.contains("standard_error"));
  }
  EXPECT_THAT(names, testing::ElementsAre("Ktc", "Krc", "Kac", "Kte", "Kre", "Kae"));
  EXPECT_EQ(document.at("model"), "linear");
  EXPECT_TRUE(document.at("residual_rms_n").contains("z"));
  EXPECT_GT(document.at("leave_one_out_rms_n").get<double>(), 0.0);
  EXPECT_GT(document.at("condition_number").get<double>(), 1.0);
  EXPECT_EQ(document.at("candidates").at(0).at("model"), "linear");
  EXPECT_FALSE(document.at("verdict").empty());
}

TEST(IdentifyCase, RefusesWithTheFieldAndARemedy) {
  EXPECT_THAT(refusal("[model]\nlaw = \"linear\"\nshear_order = 2\n"), HasSubstr("polynomial"));
  EXPECT_THAT(refusal("[model]\nlaw = \"polynomial\"\nshear_order = 2\n"),
              HasSubstr("a cylinder has one kappa"));
  EXPECT_THAT(refusal("[model]\nshear_order = -1\nedge_order = -1\n"),
              HasSubstr("without any force"));
  EXPECT_THAT(refusal("[[model.bound]]\ncoefficient = \"Kxy\"\n"),
              HasSubstr("no coefficient of any model"));
  EXPECT_THAT(refusal("[model]\nrank_by = \"leave-one-group-out\"\n"), HasSubstr("two groups"));
  EXPECT_THAT(refusal("[model]\nlaw = \"linear\"\n",
                      "axial_depth_mm,feed_per_tooth_mm,mean_force_x_n,mean_force_y_n,mean_force_"
                      "z_n\n1,0.02,-8.1,11.7,-2.0\n1,0.05,-10.2,15.9,-3.9\n"),
              HasSubstr("must give more than the 6 unknowns"));
}

TEST(IdentifyCase, BoundsAreInTheUnitOfTheirCoefficient) {
  const IdentifyCase input = read(
      put_case("[model]\nlaw = \"linear\"\n[[model.bound]]\ncoefficient = \"Kte\"\nlow = 50\n"));
  ASSERT_EQ(input.options.fit.bounds.size(), 1U);
  EXPECT_DOUBLE_EQ(input.options.fit.bounds[0].low, 50.0 * units::n_per_mm);
  const auto result =
      identify::identify_mean_forces(input.experiments, input.models, input.options);
  EXPECT_TRUE(result.best().fit->coefficients[3].at_bound);
}

}  // namespace
}  // namespace osteomill::io
