// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/instantaneous_case.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/cutting/milling_force.hpp"
#include "osteomill/identify/revolution_fit.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/force_case.hpp"
#include "osteomill/io/identify_case.hpp"
#include "osteomill/io/identify_result.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using testing::HasSubstr;

const std::filesystem::path kExample = OSTEOMILL_SOURCE_DIR "/examples/identify_instantaneous.toml";

InstantaneousCase read(const std::vector<std::string>& overrides = {}) {
  return read_instantaneous_case(read_case(kExample, overrides).front());
}

std::string refusal(const std::vector<std::string>& overrides) {
  try {
    solve(read(overrides));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

/// Mean force of the example's cut with a bone that stands in an entry.
geometry::Vector3 mean_with(const std::string& entry, const InstantaneousCase& input) {
  write_text_file(scratch("bone.toml"), entry);
  write_text_file(scratch("force.toml"),
                  "[cutter]\nshape = \"cylindrical\"\ndiameter_mm = 6\nflutes = 2\nhelix_deg = 30\n"
                  "[cut]\nimmersion = \"slot\"\nspindle_speed_rpm = 3012\naxial_depth_mm = 2\n"
                  "feed_per_tooth_mm = 0.1\n[bone]\nuse = \"bone.toml\"\n");
  const ForceCase force = read_force_case(read_case(scratch("force.toml"), {}).front());
  return cutting::mean_load(input.cutter.cutter, force.bone.law, force.condition, force.immersion)
      .force;
}

TEST(InstantaneousCase, OfTheExampleGivesACatalogueEntryOfEachLaw) {
  std::vector<geometry::Vector3> means;
  for (const char* law : {"linear", "power", "log"}) {
    const InstantaneousCase input = read({std::string("instantaneous.law=") + law});
    const InstantaneousResult result = solve(input);
    const auto document = instantaneous_document(input, result);
    EXPECT_EQ(document["status"], "converged") << law;
    EXPECT_FALSE(document["steps"].empty());
    EXPECT_GT(document["run_out_um"].get<double>(), 3.0) << law;
    means.push_back(mean_with(instantaneous_entry(input, result), input));
    // Of the powers and logs the edge force that the record was made with is missing: a curve in
    // its place is close, not equal.
    EXPECT_LT((means.back() - means.front()).norm(), 0.05 * means.front().norm()) << law;
  }
}

TEST(InstantaneousCase, RefusesWhatTheMethodCannotUse) {
  EXPECT_THAT(refusal({"signals.rotation=none"}), HasSubstr("needs the rotation"));
  EXPECT_THAT(refusal({"signals.average_flutes=true"}), HasSubstr("takes away the run-out"));
  EXPECT_THAT(refusal({"instantaneous.law=cubic"}), HasSubstr("linear | polynomial | power | log"));
  EXPECT_THAT(refusal({"instantaneous.record=missing.csv"}), HasSubstr("missing.csv"));
  EXPECT_THAT(refusal({"instantaneous.confidence=2"}), HasSubstr("confidence"));
}

TEST(IdentifyCase, WritesTheSameKindOfEntryFromTheRevolutionsOfAllRecords) {
  const auto runs = read_case(OSTEOMILL_SOURCE_DIR "/examples/identify_records.toml",
                              {"model.method=instantaneous"});
  const IdentifyCase input = read_identify_case(runs.front());
  EXPECT_EQ(input.units.size(), 6U);
  std::vector<identify::InstantaneousFit> fits;
  std::vector<std::string> names;
  for (const LoadedExperiment& one : input.loaded) {
    fits.push_back(identify::fit_processed(*one.processed, input.chain, one.experiment.cutter,
                                           one.experiment.condition, one.experiment.immersion, {}));
    names.push_back(one.experiment.name);
  }
  const auto combined = identify::combine_records(fits, names, input.units);
  const std::string entry = catalogue_entry_of(input, combined);
  EXPECT_THAT(entry, HasSubstr("method = \"instantaneous\""));
  // The records were made with these: examples/records/synthesise.py.
  const std::vector<double> truth{180.0, 95.0, -60.0, 4.0, 5.5, -1.2};
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const identify::Estimate& one = combined.coefficients[i];
    EXPECT_LT(std::abs(one.value / unit_of(one).factor - truth[i]),
              3.0 * one.standard_error / unit_of(one).factor)
        << one.name;
  }
  EXPECT_EQ(records_json(input.loaded).size(), 6U);
  EXPECT_EQ(record_signals(input).runs.size(), 6U);
}

}  // namespace
}  // namespace osteomill::io
