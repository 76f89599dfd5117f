// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/linuxcnc_run.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "osteomill/base/error.hpp"
#include "osteomill/io/linuxcnc_machine.hpp"
#include "osteomill/io/linuxcnc_plant.hpp"
#include "osteomill/io/machine_path.hpp"
#include "osteomill/io/machine_process.hpp"
#include "osteomill/io/real_time.hpp"

namespace osteomill::io {
namespace {

constexpr double kClearance = 5e-3;  // from the wall on the way back, m
/// Of each sample of the fake sensor, N: a sensor that repeats itself is taken for frozen. A Net
/// F/T resolves a few hundredths of a newton.
constexpr double kSensorNoise = 0.02;

// A machine that stands so near to the path goes on with it, m. The robot blends its pieces within
// 5 um of each slide, and its chords leave 5 um.
constexpr double kGantryStands = 1e-6;
constexpr double kRobotStands = 20e-6;

std::vector<MachineMove> path_of(const SimulatedRun& run) {
  if (run.path && !run.path->upright() && !run.input.robot) {
    throw InvalidInput(Fault{"path", "a tool that leans over",
                             "must keep the tool's axis at +z on a machine with three axes",
                             "give the [robot] that carries the tool"});
  }
  if (run.path) return machine_path(*run.path, kClearance);
  return machine_path(simulate::LineProfileWorkpiece(run.input.stock.profile), kClearance);
}

}  // namespace

struct LinuxcncRuns::Parts {
  std::optional<MachineProcess> process;
  std::unique_ptr<netft::FakeSensor> fake;
  std::unique_ptr<netft::Client> sensor;
  std::unique_ptr<linuxcnc::Machine> machine;
};

LinuxcncRuns::LinuxcncRuns(LinuxcncRunOptions options) : options_(std::move(options)) {}

LinuxcncRuns::~LinuxcncRuns() = default;

std::string machine_program(const SimulatedRun& run) {
  const double full_feed = run.input.controller.limits.highest;
  const double spindle_speed = run.input.machine.spindle_speed;
  if (!run.input.robot) return gcode_of(path_of(run), full_feed, spindle_speed);
  const CarryingRobot& robot = *run.input.robot;
  return gcode_of(robot, joint_program(robot, path_of(run), full_feed), spindle_speed);
}

MadePlant LinuxcncRuns::make(const SimulatedRun& run, simulate::Milling& milling) {
  const SimulateCase& input = run.input;
  // The last run's machine goes before the next one comes: there can be one.
  parts_ = std::make_unique<Parts>();
  std::filesystem::path socket = options_.socket;
  if (socket.empty()) {
    parts_->process.emplace(options_.launcher, machine_program(run),
                            input.robot ? "seven_axis.ini" : "osteomill.ini");
    socket = parts_->process->socket();
  }
  netft::ClientOptions address = input.sensor;
  if (!options_.real_sensor) {
    netft::FakeOptions fake;
    // The noise of a mean over the samples of a revolution is the samples' by their root.
    const double samples = input.machine.sample_rate * input.machine.period;
    fake.noise = std::max(kSensorNoise, input.machine.force_noise * std::sqrt(samples));
    fake.seed = input.machine.seed;
    parts_->fake = std::make_unique<netft::FakeSensor>(fake);
    address = {"127.0.0.1", parts_->fake->port(), fake.counts_per_newton,
               fake.counts_per_newton_metre};
  }
  parts_->sensor = std::make_unique<netft::Client>(address, options_.clock);
  parts_->machine = std::make_unique<linuxcnc::Machine>(socket);

  LinuxcncOptions how;
  if (input.supervisor) how.supervisor = *input.supervisor;
  how.full_feed = input.controller.limits.highest;
  how.force_limit = input.force_limit;
  how.spindle_speed = input.machine.spindle_speed;
  how.sample_rate = input.machine.sample_rate;
  how.flutes = input.machine.flutes;
  how.clock = options_.clock;
  if (Recorder* recorder = options_.recorder) {
    how.on_samples = [recorder](std::span<const netft::Sample> samples) { recorder->add(samples); };
  }
  how.on_event = [recorder = options_.recorder, told = options_.on_event](const auto& event) {
    if (recorder != nullptr) recorder->add(event);
    if (told) told(event);
  };
  how.robot = input.robot;
  const double tolerance = input.robot ? kRobotStands : kGantryStands;
  auto plant = std::make_unique<LinuxcncPlant>(
      *parts_->machine, milling, PathFollower(path_of(run), tolerance), *parts_->sensor,
      parts_->fake.get(), how, input.controller.period);
  LinuxcncPlant* seen = plant.get();
  real_time_ = ask_for_real_time();
  return {std::move(plant), [seen](SimulatedRun& done) {
            done.machine = seen->summary();
            done.steps = seen->steps();
            if (!done.machine->stop) return;
            done.loop.events.push_back(done.machine->stop->event);
            done.loop.end = control::LoopEnd::supervisor;
          }};
}

}  // namespace osteomill::io
