// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/recording.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <span>
#include <thread>

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
      options.on_samples = [&](std::span<const netft::Sample> samples) { recorder.add(samples); };
      options.on_event = [&](const control::LoopEvent& event) { recorder.add(event); };
      options.wrap = [&](control::Plant& inner, const SimulatedRun&, double) -> control::Plant& {
        plant = std::make_unique<RecordedPlant>(inner, recorder);
        return *plant;
      };
      run_simulations(cases, {}, options);
      recorder.finish();
    }
    const Recording recording = read_recording(file);
    EXPECT_GT(recording.periods.size(), 3000u);
    const Replay same = replay(recording.periods, cases[0].controller, cases[0].machine.start_feed);
    EXPECT_EQ(same.periods, recording.periods.size());
    // Every sample of every period, in order.
    ASSERT_EQ(recording.samples.size(), 80 * recording.periods.size());
    for (std::size_t i = 0; i < recording.samples.size(); ++i) {
      ASSERT_EQ(recording.samples[i].number, i + 1);
    }
    EXPECT_EQ(same.different, 0u) << kind << " first at " << same.first_difference;
  }
  std::filesystem::remove(file);
}

TEST(Recording, AKilledWriterLosesAtMostHalfASecond) {
  const std::filesystem::path file = scratch("killed.h5");
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    Recorder recorder(file, {.real_time = true});
    recorder.add(control::LoopEvent{0.25, control::Cause::no_go, 1.0, 2.0});
    netft::Sample sample;
    for (int i = 0; i < 800; ++i) {  // milliseconds
      RecordedPeriod period;
      period.seen.time = 1e-3 * i;
      recorder.add(period);
      for (int k = 0; k < 8; ++k) {
        ++sample.number;
        recorder.add(std::span(&sample, 1));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  const Recording recording = read_recording(file);
  // The requirement. One period a millisecond at most was written.
  EXPECT_GE(recording.periods.size(), 800u - 500u);
  EXPECT_EQ(recording.periods.back().seen.time,
            1e-3 * static_cast<double>(recording.periods.size() - 1));
  EXPECT_GE(recording.samples.size(), 8u * (800u - 500u));
  EXPECT_EQ(recording.samples.back().number, recording.samples.size());
  ASSERT_EQ(recording.events.size(), 1u);
  EXPECT_EQ(recording.events[0].cause, control::Cause::no_go);
  std::filesystem::remove(file);
}

TEST(Recording, ADiskThatIsTooSlowKeepsARealTimeLoopNotWaiting) {
  const std::filesystem::path file = scratch("full.h5");
  Recorder recorder(file, {.real_time = true});
  // Many times what the ring holds, faster than any disk.
  for (int i = 0; i < 400'000; ++i) recorder.add(control::LoopEvent{});
  recorder.finish();
  EXPECT_GT(recorder.dropped(), 0u);
  EXPECT_EQ(read_recording(file).events.size() + recorder.dropped(), 400'000u);
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
