// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/checkpoint.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include "osteomill/base/archive.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/simulate_result.hpp"
#include "osteomill/io/simulated_run.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;

/// A ramp into a small block and back, under Sugita's loop with a noisy sensor, with heat and a
/// tool that bends: everything that has a state.
std::vector<SimulateCase> cases(const std::string& feed = "6") {
  write_text_file(
      scratch("checkpoint_case.toml"),
      "[stock]\nkind = \"block\"\nlower_mm = [0, 0, -5]\nupper_mm = [14, 10, 0]\n"
      "density_kg_per_m3 = 1500\nspacing_mm = 0.4\n[path]\nkind = \"points\"\nfeed_mm_per_s = " +
          feed +
          "\nspindle_speed_rpm = 6000\npoints = [{x_mm=-4, y_mm=4, z_mm=0}, {x_mm=16, y_mm=5, "
          "z_mm=-3}, {x_mm=16, y_mm=7, z_mm=-3}, {x_mm=-4, y_mm=7, z_mm=-2}]\n"
          "[cutter]\nshape = \"ball\"\ndiameter_mm = 4\nflutes = 2\nhelix_deg = 20\nrake_deg = 10\n"
          "cutting_length_mm = 8\n[bone]\nuse = \"bovine-cortical-high-speed\"\n"
          "[heat]\nspacing_mm = 0.8\n[tool]\nlength_mm = 30\neffective_diameter_mm = 3\n"
          "youngs_modulus_gpa = 200\n"
          "[controller]\nkind = \"sugita\"\npredictive = {}\n[machine]\nforce_noise_n = 0.5\n"
          "[limits]\nmax_feed_mm_per_s = 8\nmin_feed_mm_per_s = 1\n");
  return read_simulate_cases(read_case(scratch("checkpoint_case.toml"), {}));
}

CheckpointOptions keep(const fs::path& folder, double every, bool resume) {
  return {folder, every, resume, [] { return 1.0; }, "a program", [](const std::string&) {}};
}
RunOptions how(const CheckpointOptions& checkpoint) {
  RunOptions options;
  options.checkpoint = checkpoint;
  return options;
}

/// Every number of the result, as it lies in memory.
std::string bits(const SimulatedRun& run) {
  std::string bytes;
  std::vector<simulate::Step> steps = run.steps;
  workpiece::Stock after = *run.after;
  Archive::saving([&](const void* from, std::size_t size) {
    bytes.append(static_cast<const char*>(from), size);
  })(steps, after);
  return bytes + document_of({run}, 0.0).dump();
}

fs::path fresh(const std::string& name) {
  fs::remove_all(scratch(name));
  return scratch(name);
}

class Checkpoint : public testing::Test {
 protected:
  static void SetUpTestSuite() { whole_ = new std::string(bits(run_simulations(cases()).front())); }
  static void TearDownTestSuite() {
    delete whole_;
    whole_ = nullptr;
  }
  static std::string* whole_;  ///< the result of the run without a break
};
std::string* Checkpoint::whole_ = nullptr;

TEST_F(Checkpoint, AStoppedRunGoesOnToTheSameBits) {
  const fs::path folder = fresh("stopped");
  // Stopped twice, resumed twice; one that is never stopped is the same, too.
  for (const double until : {0.3, 0.7}) {
    const auto stop = [&](std::string_view, double share) { return share < until; };
    const auto part = run_simulations(cases(), stop, how(keep(folder, 1e9, true)));
    ASSERT_EQ(part.front().summary.status, simulate::Status::stopped);
  }
  EXPECT_EQ(bits(run_simulations(cases(), {}, how(keep(folder, 1e9, true))).front()), *whole_);
  // What is left in the folder is the finished run: taken up again it is at its end at once.
  EXPECT_EQ(bits(run_simulations(cases(), {}, how(keep(folder, 1e9, true))).front()), *whole_);
}

/// A ball that leans over as it goes, with heat from each of its patches and a vessel beside it.
std::vector<SimulateCase> leaning_cases() {
  write_text_file(scratch("leaning.cl"),
                  "UNITS/MM\nMULTAX\nSPINDL/20000,RPM,CLW\nFROM/-6,3,-1,-0.28,0,0.96\n"
                  "FEDRAT/480,MMPM\nGOTO/2,3,-1,0,0,1\nGOTO/10,3,-1.2,0.36,0.48,0.8\n"
                  "GOTO/18,3,-1,0.6,0,0.8\nRAPID\nGOTO/18,3,6,0.6,0,0.8\n");
  write_text_file(
      scratch("leaning_case.toml"),
      "[stock]\nkind = \"block\"\nlower_mm = [0, 0, -4]\nupper_mm = [12, 6, 0]\n"
      "density_kg_per_m3 = 1800\nspacing_mm = 0.3\n[path]\nkind = \"cl\"\nfile = \"leaning.cl\"\n"
      "rapid_mm_per_s = 30\n[cutter]\nshape = \"ball\"\ndiameter_mm = 5\nflutes = 2\n"
      "helix_deg = 20\nrake_deg = 10\ncutting_length_mm = 8\n"
      "[bone]\nuse = \"bovine-cortical-high-speed\"\n[heat]\nspacing_mm = 0.6\n"
      "[[no_go]]\nname = \"vessel\"\nkind = \"ball\"\ncentre_mm = [5, 14, 3]\nradius_mm = 2\n"
      "[controller]\nkind = \"sugita\"\npredictive = {}\n"
      "[limits]\nmax_feed_mm_per_s = 8\nmin_feed_mm_per_s = 1\n");
  return read_simulate_cases(read_case(scratch("leaning_case.toml"), {}));
}

TEST_F(Checkpoint, WithALeaningToolAndHeatTheRunGoesOnToTheSameBits) {
  const SimulatedRun whole = run_simulations(leaning_cases()).front();
  ASSERT_GT(whole.heat->hottest, 320.0);
  const fs::path folder = fresh("leaning");
  for (const double until : {0.35, 0.6}) {
    const auto stop = [&](std::string_view, double share) { return share < until; };
    const auto part = run_simulations(leaning_cases(), stop, how(keep(folder, 1e9, true)));
    ASSERT_EQ(part.front().summary.status, simulate::Status::stopped);
  }
  const SimulatedRun resumed =
      run_simulations(leaning_cases(), {}, how(keep(folder, 1e9, true))).front();
  EXPECT_EQ(bits(resumed), bits(whole));
  ASSERT_EQ(resumed.steps.size(), whole.steps.size());
  for (std::size_t i = 0; i < whole.steps.size(); ++i) {
    EXPECT_EQ(resumed.steps[i].axis_W, whole.steps[i].axis_W) << i;
    EXPECT_EQ(resumed.steps[i].contact_length, whole.steps[i].contact_length) << i;
  }
}

TEST_F(Checkpoint, ARunThatWasKilledGoesOnFromTheLastOneWritten) {
  const fs::path folder = fresh("killed");
  struct Killed {};
  const auto kill = [](std::string_view, double share) -> bool {
    if (share > 0.5) throw Killed{};
    return true;
  };
  // A clock that goes on by a second whenever it is asked.
  CheckpointOptions options = keep(folder, 40.0, false);
  options.clock = [seconds = 0.0]() mutable { return seconds += 1.0; };
  EXPECT_THROW(run_simulations(cases(), kill, how(options)), Killed);
  ASSERT_TRUE(fs::exists(folder / "run.checkpoint"));
  EXPECT_EQ(bits(run_simulations(cases(), {}, how(keep(folder, 1e9, true))).front()), *whole_);
}

TEST_F(Checkpoint, WithoutResumeTheRunBeginsAnew) {
  const fs::path folder = fresh("anew");
  EXPECT_EQ(bits(run_simulations(cases(), {}, how(keep(folder, 1e9, true))).front()), *whole_);
  std::string said;
  CheckpointOptions options = keep(folder, 1e9, false);
  options.say = [&](const std::string& text) { said = text; };
  EXPECT_EQ(bits(run_simulations(cases(), {}, how(options)).front()), *whole_);
  EXPECT_EQ(said, "");
}

std::string refusal(const std::vector<SimulateCase>& list, const CheckpointOptions& options) {
  try {
    run_simulations(list, {}, how(options));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST_F(Checkpoint, OfAnotherRunOrBrokenIsRefused) {
  const fs::path folder = fresh("other");
  run_simulations(cases(), {}, how(keep(folder, 1e9, false)));
  EXPECT_THAT(refusal(cases("5"), keep(folder, 1e9, true)), testing::HasSubstr("of another run"));
  CheckpointOptions program = keep(folder, 1e9, true);
  program.program = "another program";
  EXPECT_THAT(refusal(cases(), program), testing::HasSubstr("of another run"));
  const fs::path file = folder / "run.checkpoint";
  std::string text = read_text_file(file);
  text[text.size() / 2] ^= 1;
  write_text_file(file, text);
  EXPECT_THAT(refusal(cases(), keep(folder, 1e9, true)), testing::HasSubstr("check sum"));
  write_text_file(file, text.substr(0, 12));
  EXPECT_THAT(refusal(cases(), keep(folder, 1e9, true)), testing::HasSubstr("no checkpoint"));
}

TEST_F(Checkpoint, WhenTheDiskIsFullTheOneBeforeStaysWhole) {
  const fs::path folder = fresh("full_disk");
  const auto stop = [](std::string_view, double share) { return share < 0.3; };
  run_simulations(cases(), stop, how(keep(folder, 1e9, false)));
  const std::string before = read_text_file(folder / "run.checkpoint");
  // No file may grow beyond 4 kB, as on a full disk.
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const rlimit small{4096, limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string said;
  try {
    run_simulations(cases(), {}, how(keep(folder, 0.0, true)));
  } catch (const WorldError& error) {
    said = error.what();
  }
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_THAT(said, testing::AllOf(testing::HasSubstr("cannot be written"),
                                   testing::HasSubstr("the checkpoint before is whole"),
                                   testing::HasSubstr("--resume")));
  EXPECT_EQ(read_text_file(folder / "run.checkpoint"), before);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
  EXPECT_EQ(bits(run_simulations(cases(), {}, how(keep(folder, 1e9, true))).front()), *whole_);
}

}  // namespace
}  // namespace osteomill::io
