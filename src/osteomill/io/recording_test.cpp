// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/recording.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <memory>

#include "osteomill/base/error.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/control_case.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

const std::filesystem::path kCase = OSTEOMILL_SOURCE_DIR "/examples/model_adaptive.toml";

std::filesystem::path scratch(const char* name) {
  return std::filesystem::path(testing::TempDir()) /
         (std::string("osteomill_") + std::to_string(::getpid()) + "_" + name);
}

TEST(Recording, ReplayGivesEveryCommandBitForBit) {
  const std::filesystem::path file = scratch("replay.h5");
  for (const char* kind : {"constant", "sugita", "model-adaptive"}) {
    auto cases = read_control_cases(
        read_case(kCase, {"machine.force_noise_n=1", std::string("controller.kind=") + kind}));
    cases.resize(1);
    {
      Recorder recorder(file);
      std::unique_ptr<RecordedPlant> plant;
      RunOptions options;
      options.wrap = [&](control::Plant& inner, double) -> control::Plant& {
        plant = std::make_unique<RecordedPlant>(inner, recorder);
        return *plant;
      };
      run_simulations(cases, {}, options);
    }
    const std::vector<RecordedPeriod> recording = read_recording(file);
    EXPECT_GT(recording.size(), 3000u);
    const Replay same = replay(recording, cases[0].controller, cases[0].machine.start_feed);
    EXPECT_EQ(same.periods, recording.size());
    EXPECT_EQ(same.different, 0u) << kind << " first at " << same.first_difference;
  }
  std::filesystem::remove(file);
}

TEST(Recording, AKilledWriterLosesAtMostItsLastBlock) {
  const std::filesystem::path file = scratch("killed.h5");
  const int periods = 260;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    Recorder recorder(file);
    for (int i = 0; i < periods; ++i) {
      RecordedPeriod period;
      period.seen.time = 0.01 * i;
      recorder.add(period);
    }
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  const std::vector<RecordedPeriod> recording = read_recording(file);
  EXPECT_GE(recording.size(), periods - Recorder::kBlock);
  EXPECT_EQ(recording.back().seen.time, 0.01 * static_cast<double>(recording.size() - 1));
  std::filesystem::remove(file);
}

TEST(Recording, RefusesWhatIsNoRecording) {
  EXPECT_THROW(read_recording("no/such/file.h5"), InvalidInput);
  const std::filesystem::path file = scratch("text.h5");
  write_text_file(file, "not HDF5");
  EXPECT_THROW(read_recording(file), InvalidInput);
  std::filesystem::remove(file);
  EXPECT_THROW(Recorder("no/such/folder/file.h5"), WorldError);
}

}  // namespace
}  // namespace osteomill::io
