// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "osteomill/io/recording.hpp"
#include "osteomill/io/simulated_run.hpp"

namespace osteomill::io {

struct LinuxcncRunOptions {
  /// The program that starts the simulated machine, `osteomill_machine`. Not used with a socket.
  std::filesystem::path launcher;
  /// Of a machine that runs already, with the program of this run loaded and started. Empty: the
  /// simulated machine is started for each run and shut down after it.
  std::filesystem::path socket;
  bool real_sensor = false;       ///< the one at SimulateCase::sensor; else a fake on loopback
  std::function<double()> clock;  ///< s, monotonic
  Recorder* recorder = nullptr;   ///< of force samples and events; null: not recorded
  std::function<void(const control::LoopEvent&)> on_event;  ///< told at once; none: nobody is
};

/// Plants on LinuxCNC for RunOptions::make; they keep what they need alive until the next one.
class LinuxcncRuns {
 public:
  explicit LinuxcncRuns(LinuxcncRunOptions options);
  ~LinuxcncRuns();
  LinuxcncRuns(const LinuxcncRuns&) = delete;
  LinuxcncRuns& operator=(const LinuxcncRuns&) = delete;

  MadePlant make(const SimulatedRun& run, simulate::Milling& milling);
  bool real_time() const { return real_time_; }  ///< of the last run

 private:
  struct Parts;
  LinuxcncRunOptions options_;
  std::unique_ptr<Parts> parts_;
  bool real_time_ = false;
};

/// The program of a run, which has its input and, but for a line profile, its path.
std::string machine_program(const SimulatedRun& run);

}  // namespace osteomill::io
