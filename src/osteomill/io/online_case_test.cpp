// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/online_case.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "osteomill/base/error.hpp"
#include "osteomill/base/random.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/section.hpp"
#include "osteomill/io/signals_file.hpp"
#include "osteomill/io/simulate_case.hpp"
#include "osteomill/io/simulate_report.hpp"
#include "osteomill/io/simulated_run.hpp"
#include "osteomill/io/toml_text.hpp"

namespace osteomill::io {
namespace {

using testing::HasSubstr;

std::filesystem::path example(const char* name) {
  return std::filesystem::path(OSTEOMILL_SOURCE_DIR) / "examples" / name;
}

OnlineCase read(const std::vector<std::string>& overrides = {}) {
  return read_online_case(read_case(example("identify_online.toml"), overrides).front());
}

TEST(OnlineCase, KnowsTheExamplesBoneFromItsPowerAndWritesItAsAnEntry) {
  const OnlineCase input = read();
  const identify::OnlineTrack track = follow(input.periods, input.response, input.options);
  const nlohmann::ordered_json document = online_document(input, track);
  // The table has the true force beside the power.
  const OnlineCase truth = read({"online.measure=force"});
  const auto& predicted = document["track"]["predicted_force_n"];
  int within = 0;
  int all = 0;
  for (std::size_t i = 0; i < truth.periods.size(); ++i) {
    if (truth.periods[i].measured <= 0.0 || !track.in_bone[i]) continue;
    within += std::abs(predicted[i].get<double>() / truth.periods[i].measured - 1.0) <= 0.1;
    ++all;
  }
  EXPECT_GT(all, 1300);
  EXPECT_GE(within, all * 95 / 100);

  // The entry is a bone like any other, with that strength in its law.
  CaseRun patient;
  patient.tree.values["bone"] = parse_toml(patient_entry(input, track), "patient.toml").values;
  BoneCase bone;
  Section::read(patient, [&](Section& section) { bind_bone(section, bone); });
  EXPECT_NEAR(bone.strength, track.median, 1e-12);
  const double ratio = cutting::force_per_width(bone.law.tangential.at_0, 10e-6) /
                       cutting::force_per_width(input.bone->law.tangential.at_0, 10e-6);
  EXPECT_NEAR(ratio, track.median, 1e-9);
}

TEST(OnlineCase, PredictsTheForceOfASimulatedPatientFromItsPowerToTenPercent) {
  // A slot through rim, graded zone and inside of a tibia, whose strength goes from 1.4 to 0.35 and
  // back and whose law is not the catalogue's: examples/patient_tibia.toml, in coarser voxels.
  const auto runs = run_simulations(
      read_simulate_cases(read_case(example("patient_tibia.toml"), {"stock.spacing_mm=0.5"})));
  const std::filesystem::path file = scratch("signals.h5");
  write_signals(signals_of(runs), file);
  const auto replayed = [&](const char* measure) {
    return read_online_case(
        read_case(example("identify_online_simulated.toml"),
                  {"replay.signals=" + file.string(), std::string("online.measure=") + measure})
            .front());
  };
  OnlineCase input = replayed("power");
  const OnlineCase truth = replayed("force");
  // The drive's efficiency is known to 3 %, its power with noise of 1 W and 1 %.
  Random random(1);
  for (identify::OnlinePeriod& one : input.periods) {
    one.measured += std::hypot(1.0, 0.01 * one.measured) * random.normal();
  }
  input.options.power.efficiency *= 0.97;
  const identify::OnlineTrack track = follow(input.periods, input.response, input.options);
  const nlohmann::ordered_json document = online_document(input, track);
  const auto& predicted = document["track"]["predicted_force_n"];
  double square = 0.0;
  int within = 0;
  int all = 0;
  double weakest = 1e300, strongest = 0.0;
  for (std::size_t i = 0; i < truth.periods.size(); ++i) {
    // The whole of the cutter in the bone: between 1.1 diameters behind entry and before exit the
    // cut is as wide as the case says.
    const double x = runs.front().steps[i].tip_W.x();
    if (x < 3.5e-3 || x > 26.5e-3) continue;
    const double miss = predicted[i].get<double>() / truth.periods[i].measured - 1.0;
    square += miss * miss;
    within += std::abs(miss) <= 0.1;
    weakest = std::min(weakest, track.estimates[i].strength);
    strongest = std::max(strongest, track.estimates[i].strength);
    ++all;
  }
  ASSERT_GT(all, 700);
  RecordProperty("rms", std::to_string(std::sqrt(square / all)));
  RecordProperty("within", std::to_string(static_cast<double>(within) / all));
  EXPECT_LT(std::sqrt(square / all), 0.1);
  EXPECT_GE(within, all * 95 / 100);
  EXPECT_GT(strongest / weakest, 3.0);
}

TEST(OnlineCase, RefusesWhatSaysNothingOfBone) {
  const auto faults = [](const std::vector<std::string>& overrides) -> std::string {
    try {
      read(overrides);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(faults({"replay.recording=identify_online.csv"}), HasSubstr("replay"));
  EXPECT_THAT(faults({"replay.table=identify_online.toml"}), HasSubstr("identify_online.toml"));
  EXPECT_THAT(faults({"reference.gain_n_per_mm_per_s=4"}), HasSubstr("bone: is no known key here"));
  EXPECT_THAT(faults({"power.efficiency=0"}), HasSubstr("power.efficiency"));
  EXPECT_THAT(faults({"online.methd=kalman"}), HasSubstr("methd"));
  EXPECT_THAT(faults({"bone.strength=-1"}), HasSubstr("bone.strength"));
}

TEST(TomlText, ReadsBackAsTheTreeItWasMadeOf) {
  const nlohmann::ordered_json tree = {
      {"law", "log"},
      {"range_um", {0.5, 50}},
      {"tangential", {{"at_0_deg", {{"k1", 0.1}, {"k2", -3e-7}}}, {"flag", true}}},
      {"note", "quotes \" and\nlines"},
      {"left out", nullptr},
      {"rows", {{1, 2}, {3, 4}}}};
  nlohmann::ordered_json expected = tree;
  expected.erase("left out");
  const nlohmann::ordered_json back = parse_toml(toml_text(tree), "t").values;
  // The order of keys differs: plain ones come before tables.
  EXPECT_EQ(nlohmann::json::parse(back.dump()), nlohmann::json::parse(expected.dump()));
}

}  // namespace
}  // namespace osteomill::io
