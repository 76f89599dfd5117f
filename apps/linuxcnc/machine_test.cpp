// SPDX-License-Identifier: BSD-3-Clause
// On the real controller: LinuxCNC with the simulated machine. Faults: machine_faults_test.cpp.
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "session_for_test.hpp"

namespace osteomill::io {
namespace {

/// A case of one run on the machine; again when a busy computer stopped it.
std::vector<SimulatedRun> run_online(const std::vector<SimulateCase>& cases) {
  LinuxcncRunOptions started;
  started.launcher = kLauncher;
  started.clock = now;
  LinuxcncRuns linuxcnc(started);
  RunOptions options;
  options.make = [&](const SimulatedRun& run, simulate::Milling& milling) {
    return linuxcnc.make(run, milling);
  };
  std::vector<SimulatedRun> online = run_simulations(cases, {}, options);
  for (int more = kTries; more > 1 && starved(online.front().machine->stop); --more) {
    online = run_simulations(cases, {}, options);
  }
  return online;
}

TEST(LinuxcncMachine, RemovesTheVoxelsThatTheSimulationRemoves) {
  const std::filesystem::path file =
      testing::TempDir() + "osteomill_block_" + std::to_string(getpid()) + ".toml";
  write_text_file(file, R"(
[stock]
kind = "block"
lower_mm = [0, 0, -4]
upper_mm = [16, 10, 0]
spacing_mm = 0.25
density_kg_per_m3 = 1900
[path]
kind = "points"
points = [{ x_mm = -3, y_mm = 5, z_mm = -2 }, { x_mm = 19, y_mm = 5, z_mm = -2 }]
feed_mm_per_s = 6
spindle_speed_rpm = 20000
[cutter]
use = "craniotomy-3mm"
[bone]
use = "bovine-cortical-high-speed"
[controller]
kind = "constant"
)");
  const auto cases = read_control_cases(read_case(file, {}));
  std::filesystem::remove(file);
  const SimulatedRun offline = run_simulations(cases).front();
  const SimulatedRun online = run_online(cases).front();
  ASSERT_EQ(online.summary.status, simulate::Status::finished);
  std::printf("slot in a block of voxels: %.2f s on LinuxCNC, %.2f s simulated; lag %u cycles\n",
              online.summary.cutting_time, offline.summary.cutting_time, online.machine->bone_lag);
  EXPECT_NEAR(online.summary.cutting_time, offline.summary.cutting_time,
              0.05 * offline.summary.cutting_time);
  EXPECT_NEAR(online.summary.removed_volume, offline.summary.removed_volume,
              1e-3 * offline.summary.removed_volume);
}

TEST(LinuxcncMachine, MillsThreeLinesInTheTimeOfTheSimulation) {
  const auto cases =
      read_control_cases(read_case(OSTEOMILL_SOURCE_DIR "/examples/linuxcnc_tibia.toml", {}));
  const std::vector<SimulatedRun> offline = run_simulations(cases);
  const std::vector<SimulatedRun> online = run_online(cases);
  ASSERT_EQ(online.size(), 1U);
  const SimulatedRun& run = online.front();
  std::printf("three lines: %.2f s on LinuxCNC, %.2f s simulated; moves between included %.2f s\n",
              run.summary.cutting_time, offline.front().summary.cutting_time,
              run.machine->machine_time);
  EXPECT_EQ(run.summary.status, simulate::Status::finished);
  EXPECT_EQ(run.summary.line_times.size(), 3U);
  // The requirement: 5 %.
  EXPECT_NEAR(run.summary.cutting_time, offline.front().summary.cutting_time,
              0.05 * offline.front().summary.cutting_time);
  // What the tool removes does not depend on how fast it goes.
  EXPECT_NEAR(run.summary.removed_volume, offline.front().summary.removed_volume,
              1e-3 * run.summary.removed_volume);
  EXPECT_EQ(run.machine->sensor.lost, 0U);
}

// Two things that three axes cannot do: a robot's joints, and a tool that leans over.
TEST(LinuxcncMachine, MillsWithALeaningToolOnTheRobotWithSevenAxes) {
  const std::filesystem::path folder =
      testing::TempDir() + "osteomill_leaning_" + std::to_string(getpid());
  std::filesystem::create_directories(folder);
  write_text_file(folder / "pass.cl", R"(PARTNO LEANS FROM -10 TO 20 DEGREES
UNITS/MM
MULTAX
SPINDL/20000,RPM,CLW
RAPID
GOTO/-6,0,-0.5,-0.173648178,0,0.984807753
FEDRAT/300,MMPM
GOTO/2,0,-1,0.087155743,0,0.996194698
GOTO/10,0,-0.5,0.342020143,0,0.939692621
FINI
)");
  write_text_file(folder / "case.toml", R"(
[stock]
kind = "block"
lower_mm = [-2, -4, -4]
upper_mm = [6, 4, 0]
spacing_mm = 0.25
density_kg_per_m3 = 1900
[path]
kind = "cl"
file = "pass.cl"
[cutter]
shape = "ball"
diameter_mm = 6
flutes = 2
helix_deg = 30
rake_deg = 10
cutting_length_mm = 8
[bone]
use = "bovine-cortical-high-speed"
[controller]
kind = "constant"
[limits]
max_feed_mm_per_s = 5
[robot]
model = "seven-axis"
c5_mm = 0
g9_mm = [0, 0, 0]
[robot.work]
position_mm = [-2, 300, 0]
)");
  const auto cases = read_control_cases(read_case(folder / "case.toml", {}));
  const SimulatedRun offline = run_simulations(cases).front();
  const SimulatedRun online = run_online(cases).front();
  std::filesystem::remove_all(folder);
  ASSERT_EQ(online.summary.status, simulate::Status::finished);
  std::printf(
      "leaning tool: %.2f s on LinuxCNC, %.2f s simulated; off the path by %.1f um, %.4f "
      "deg\n",
      online.summary.cutting_time, offline.summary.cutting_time,
      online.machine->off_path / units::um, online.machine->off_axis / units::deg);
  // The requirement: 5 %.
  EXPECT_NEAR(online.summary.cutting_time, offline.summary.cutting_time,
              0.05 * offline.summary.cutting_time);
  EXPECT_NEAR(online.summary.removed_volume, offline.summary.removed_volume,
              1e-3 * offline.summary.removed_volume);
  // Chords of 5 um and a blend of 5 um.
  EXPECT_LT(online.machine->off_path, 10e-6);
  EXPECT_LT(online.machine->off_axis, 0.05 * units::deg);
}

TEST(LinuxcncMachine, FollowsAChangeOfTheFeedWithinTwoServoPeriods) {
  const LongLines there;
  std::unique_ptr<Session> made;
  for (int tries = 0; tries < kTries; ++tries) {
    made.reset();  // there can be one
    made = cutting(there.process, {});
    ASSERT_TRUE(made);
    for (int i = 0; i < 40; ++i) made->cut(i % 2 == 0 ? kFull : kFull / 4.0, 10);
    const MachineSummary done = made->plant->summary();
    // A busy computer delays the orders; what it can do is what counts here.
    if (!starved(done.stop) && median(done.feed_delays) <= 2) break;
  }
  Session& session = *made;
  ASSERT_FALSE(session.plant->stopped());

  // From the cycle in which the pin had another value to the first one with another speed.
  const std::vector<Cycle> cycles = session.plant->cycles();
  std::vector<int> responses;
  for (std::size_t i = 1; i + 20 < cycles.size(); ++i) {
    const bool steady = i > 20 && cycles[i - 1].feed == cycles[i - 20].feed;
    if (cycles[i].adaptive_feed == cycles[i - 1].adaptive_feed || !steady) continue;
    int cycle = 0;
    while (cycles[i + cycle].feed == cycles[i - 1].feed && cycle < 20) ++cycle;
    responses.push_back(cycle + 1);
  }
  const std::vector<int> delays = session.plant->summary().feed_delays;
  ASSERT_GT(responses.size(), 20U);
  std::printf(
      "feed changes: %zu; pin to motion %d cycles at most; order to the end of the cycle that has "
      "it "
      "%d cycles (median), %d at most\n",
      responses.size(), *std::max_element(responses.begin(), responses.end()), median(delays),
      *std::max_element(delays.begin(), delays.end()));
  EXPECT_LE(*std::max_element(responses.begin(), responses.end()), 2);
  // The way from this process to the pin is as good as the scheduler lets it be; the median is
  // that of a machine that has nothing else to do.
  EXPECT_LE(median(delays), 2);
}

/// `osteomill control` on a machine that runs, as a process of its own.
class Controller {
 public:
  explicit Controller(const MachineProcess& process) {
    const std::string socket = process.socket().string();
    const std::vector<std::string> words = {
        kProgram,  "control",  OSTEOMILL_SOURCE_DIR "/examples/linuxcnc_tibia.toml",
        "--plant", "linuxcnc", "--machine",
        socket,    "--format", "json"};
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (const int stream : {1, 2}) {
      posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", 1, 0);
    }
    EXPECT_EQ(posix_spawn(&id_, kProgram, &actions, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
  }
  ~Controller() {
    signal(SIGKILL);
    waitpid(id_, nullptr, 0);
  }
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;
  void signal(int number) const { kill(id_, number); }

 private:
  pid_t id_ = -1;
};

bool comes_true(const std::function<bool()>& condition, double patience) {
  const double end = now() + patience;
  while (!condition()) {
    if (now() > end) return false;
    sleep_for(0.02);
  }
  return true;
}

bool unheard() { return pin("heart-beats.out") == "FALSE"; }

bool moves() { return std::abs(std::stod(pin("motion.current-vel"))) > 1.0; }

/// A controller that moves the machine; null when the computer is too busy.
std::unique_ptr<Controller> moving(const MachineProcess& process) {
  for (int tries = 0; tries < kTries; ++tries) {
    auto controller = std::make_unique<Controller>(process);
    if (comes_true(moves, 5.0)) return controller;
  }
  return nullptr;
}

/// The machine with the program of the tibia, which the controller expects.
struct Tibia {
  std::vector<SimulateCase> cases =
      read_control_cases(read_case(OSTEOMILL_SOURCE_DIR "/examples/linuxcnc_tibia.toml", {}));
  MachineProcess process{kLauncher, program_of(cases.front())};
};

TEST(LinuxcncMachine, HoldsTheFeedWhenTheControllerIsKilledOrHangsOrTheComponentDies) {
  const Tibia there;
  EXPECT_TRUE(held()) << "before a controller comes";
  {
    const std::unique_ptr<Controller> controller = moving(there.process);
    ASSERT_TRUE(controller);
    controller->signal(SIGKILL);
    const double killed = now();
    ASSERT_TRUE(comes_true(held, 5.0));
    std::printf("kill -9 of the controller: held, seen after %.0f ms\n", 1e3 * (now() - killed));
    EXPECT_TRUE(comes_true([] { return pin("osteomill.armed") == "FALSE"; }, 5.0));
    EXPECT_TRUE(comes_true(unheard, 5.0));
    ASSERT_TRUE(comes_true([] { return pin("spindle.0.inhibit") == "TRUE"; }, 5.0));
  }
  {
    const std::unique_ptr<Controller> controller = moving(there.process);
    ASSERT_TRUE(controller) << "another controller takes over";
    controller->signal(SIGSTOP);
    const double stopped = now();
    ASSERT_TRUE(comes_true(held, 5.0));
    std::printf("SIGSTOP of the controller: held, seen after %.0f ms\n", 1e3 * (now() - stopped));
    EXPECT_TRUE(comes_true(unheard, 5.0));
    controller->signal(SIGCONT);
    sleep_for(0.3);
    EXPECT_TRUE(held()) << "it does not start again when the controller wakes up";
  }
  {
    const std::unique_ptr<Controller> controller = moving(there.process);
    ASSERT_TRUE(controller);
    const std::string id = output_of("pidof osteomill_hal");
    ASSERT_FALSE(id.empty());
    kill(std::stoi(id), SIGKILL);
    const double killed = now();
    ASSERT_TRUE(comes_true(held, 5.0));
    std::printf("kill -9 of osteomill_hal: held, seen after %.0f ms\n", 1e3 * (now() - killed));
    EXPECT_TRUE(comes_true(unheard, 5.0));
    ASSERT_TRUE(comes_true([] { return pin("spindle.0.inhibit") == "TRUE"; }, 5.0));
  }
}

}  // namespace
}  // namespace osteomill::io
