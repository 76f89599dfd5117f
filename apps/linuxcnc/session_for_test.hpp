// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/case_file.hpp"
#include "osteomill/io/control_case.hpp"
#include "osteomill/io/linuxcnc_plant.hpp"
#include "osteomill/io/linuxcnc_run.hpp"
#include "osteomill/io/machine_process.hpp"
#include "osteomill/io/real_time.hpp"
#include "osteomill/io/simulated_run.hpp"
#include "osteomill/io/text_file.hpp"

/// What the tests on LinuxCNC share. Times are counted in its servo cycles of 1 ms, so that they
/// mean the same on a machine without a realtime kernel.
namespace osteomill::io {

using control::Cause;
using linuxcnc::Cycle;

inline constexpr const char* kLauncher = OSTEOMILL_LAUNCHER;
inline constexpr const char* kProgram = OSTEOMILL_PROGRAM;
inline constexpr double kFull = 12e-3;  // m/s

inline double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

inline void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Three long lines in one material: 18 N at full feed.
inline SimulateCase long_lines() {
  SimulateCase input;
  input.stock.kind = StockKind::line_profile;
  input.stock.profile.zones = {{0.0, 200e-3, 1500.0, {}, {}}};
  input.stock.profile.line_length = 200e-3;
  input.stock.profile.peak_to_mean = 1.48;
  input.machine.spindle_speed = 6000 * units::rpm;
  return input;
}

inline std::string program_of(const SimulateCase& input) {
  SimulatedRun run;
  run.input = input;
  return machine_program(run);
}

/// Without a realtime kernel a busy computer may keep a process waiting until the supervisor or the
/// watchdog stops the machine, as they should; or the thread that plays the bone, whose forces are
/// too old then or come with a gap, in which the tooth-passing line is lost. What is tested here is
/// what happens when it does not.
inline bool starved(const std::optional<MachineStop>& stop) {
  if (!stop) return false;
  std::printf("stopped: %s %s\n", control::name(stop->event.cause), stop->detail);
  return stop->event.cause == Cause::machine_lost ||
         stop->event.cause == Cause::controller_overrun ||
         stop->event.cause == Cause::sensor_stale || stop->event.cause == Cause::tool_breakage;
}

inline constexpr int kTries = 8;  ///< on a busy computer

/// What a shell command prints, without the end of the line.
inline std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 256> piece{};
  while (pipe != nullptr && fgets(piece.data(), piece.size(), pipe) != nullptr)
    text += piece.data();
  if (pipe != nullptr) pclose(pipe);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

inline std::string pin(const std::string& name) {
  return output_of("halcmd getp " + name + " 2>&1");
}

/// The machine stands, and it is the feed's inhibit that holds it.
inline bool held() {
  return pin("motion.feed-inhibit") == "TRUE" &&
         std::abs(std::stod(pin("motion.current-vel"))) < 1e-9;
}

/// One connection to the machine, as `osteomill control` makes it, without its controller: the test
/// commands the feed.
struct Session {
  explicit Session(const MachineProcess& process, LinuxcncOptions options = {})
      : machine(process.socket()) {
    options.spindle_speed = input.machine.spindle_speed;
    options.clock = now;
    options.disturb = [this](control::SupervisorInput& seen) {
      const std::lock_guard lock(mutex);
      if (disturb) disturb(seen);
    };
    plant.emplace(machine, milling, PathFollower(machine_path(bone, 5e-3)), client, &sensor,
                  options, 10e-3);
    ask_for_real_time();
    plant->start();
  }
  /// Control periods at a feed; ends early when the supervisor stops the machine.
  void cut(double feed, int periods) {
    for (int i = 0; i < periods; ++i) {
      plant->advance({feed, control::Mode::constant, false});
      if (plant->stopped()) break;
    }
  }

  SimulateCase input = long_lines();
  simulate::LineProfileWorkpiece bone{input.stock.profile};
  simulate::Milling milling{bone, input.machine, 30.0};
  netft::FakeSensor sensor{{.noise = 0.02}};
  netft::Client client{{.address = "127.0.0.1", .port = sensor.port()}, now};
  linuxcnc::Machine machine;
  std::mutex mutex;  ///< the supervisor looks in a thread of its own
  std::function<void(control::SupervisorInput&)> disturb;
  std::optional<LinuxcncPlant> plant;
};

/// LinuxCNC with the long lines in it, from the start of the first one.
struct LongLines {
  MachineProcess process{kLauncher, program_of(long_lines())};
};

/// A session that cuts at full feed; null when the computer is too busy.
inline std::unique_ptr<Session> cutting(const MachineProcess& process,
                                        const LinuxcncOptions& options) {
  for (int tries = 0; tries < kTries; ++tries) {
    auto session = std::make_unique<Session>(process, options);
    session->cut(kFull, 40);
    if (!session->plant->stopped()) return session;
    if (!starved(session->plant->summary().stop)) break;
  }
  return nullptr;
}

inline int median(std::vector<int> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

}  // namespace osteomill::io
