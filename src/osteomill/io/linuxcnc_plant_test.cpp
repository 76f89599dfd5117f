// SPDX-License-Identifier: BSD-3-Clause
// The plant on a machine of a hundred lines that speaks the component's protocol: what needs no
// LinuxCNC, and what the sanitizers are to see of its threads. On LinuxCNC itself:
// apps/linuxcnc/machine_test.cpp.
#include "osteomill/io/linuxcnc_plant.hpp"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/control/loop.hpp"
#include "osteomill/io/recording.hpp"

namespace osteomill::io {
namespace {

using linuxcnc::Cycle;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Moves along +x from the start of the line at the share of 12 mm/s that it is told, in cycles of
/// 1 ms; a hold stays.
class FakeMachine {
 public:
  explicit FakeMachine(const geometry::Vector3& start_W) : start_W_(start_W) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path.c_str());
    listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    EXPECT_EQ(bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
    thread_ = std::thread([this] { work(); });
  }
  ~FakeMachine() {
    over_ = true;
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
    std::filesystem::remove(path);
  }

  const std::string path = testing::TempDir() + "osteomill_machine_" + std::to_string(getpid());
  std::atomic<bool> silent{false};  ///< as a machine that is lost
  std::atomic<double> x{0.0};       ///< from the start, mm

 private:
  void work() {
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) return;
    const linuxcnc::Hello hello{linuxcnc::kMagic, sizeof(Cycle)};
    send(client, &hello, sizeof(hello), MSG_NOSIGNAL);
    linuxcnc::Order order;
    bool hold = false;
    bool spindle = false;
    auto due = std::chrono::steady_clock::now();
    for (Cycle cycle; !over_; ++cycle.number) {
      linuxcnc::Order next;
      while (recv(client, &next, sizeof(next), MSG_DONTWAIT) == sizeof(next)) {
        order = next;
        hold = hold || order.feed_hold != 0;
        spindle = spindle || order.spindle_inhibit != 0;
      }
      cycle.feed = hold ? 0.0 : 12.0 * order.adaptive_feed;
      cycle.adaptive_feed = order.adaptive_feed;
      x = x + 1e-3 * cycle.feed;
      cycle.joint[0] = start_W_.x() / units::mm + x;
      cycle.joint[1] = start_W_.y() / units::mm;
      cycle.joint[2] = start_W_.z() / units::mm;
      cycle.motion_type = 2;
      cycle.order = order.number;
      cycle.feed_inhibited = hold ? 1 : 0;
      cycle.spindle_inhibited = spindle ? 1 : 0;
      cycle.heart_beats = cycle.motion_enabled = 1;
      if (!silent) send(client, &cycle, sizeof(cycle), MSG_NOSIGNAL | MSG_DONTWAIT);
      due += std::chrono::milliseconds(1);
      std::this_thread::sleep_until(due);
    }
    close(client);
  }

  geometry::Vector3 start_W_;
  int listener_ = -1;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

struct Cell {
  explicit Cell(double length) {
    profile.zones = {{0.0, length, 1500.0, {}, {}}};
    profile.line_length = length;
    profile.lines = 1;
    // Sanitizers and busy computers are slow; what is looked at here is not how fast.
    options.supervisor.sample_age = 0.5;
    options.supervisor.period = 0.5;
    options.spindle_speed = 6000 * units::rpm;
    options.clock = now;
    machine_of.spindle_speed = options.spindle_speed;
    milling.emplace(bone(), machine_of, 30.0);
    fake.emplace(bone().at(0.0).tip_W);
    machine.emplace(fake->path);
  }
  simulate::LineProfileWorkpiece& bone() {
    if (!workpiece) workpiece.emplace(profile);
    return *workpiece;
  }
  control::Plant& plant() {
    if (!made) {
      made.emplace(*machine, *milling, PathFollower(machine_path(bone(), 5e-3)), client, &sensor,
                   options, 10e-3);
    }
    return *made;
  }

  simulate::LineProfile profile;
  simulate::Machine machine_of;
  LinuxcncOptions options;
  std::optional<simulate::LineProfileWorkpiece> workpiece;
  std::optional<simulate::Milling> milling;
  netft::FakeSensor sensor{{.noise = 0.02}};
  netft::Client client{{.address = "127.0.0.1", .port = sensor.port()}, now};
  std::optional<FakeMachine> fake;
  std::optional<linuxcnc::Machine> machine;
  std::optional<LinuxcncPlant> made;
};

control::FeedController adaptive() {
  control::FeedController controller;
  controller.law = control::ModelAdaptive({});
  controller.limits.lowest = 0.4e-3;
  return controller;
}

TEST(LinuxcncPlant, MillsALineAndRecordsWhatReplays) {
  Cell cell(4e-3);
  const std::filesystem::path file =
      testing::TempDir() + "osteomill_plant_" + std::to_string(getpid()) + ".h5";
  Recorder recorder(file, {.real_time = true});
  cell.options.on_samples = [&](std::span<const netft::Sample> samples) { recorder.add(samples); };
  RecordedPlant recorded(cell.plant(), recorder);
  control::LoopOptions loop;
  loop.path_length = cell.bone().length();
  EXPECT_EQ(control::run(recorded, adaptive(), loop).end, control::LoopEnd::finished);
  const MachineSummary done = cell.made->summary();
  EXPECT_FALSE(done.stop);
  EXPECT_EQ(done.lost, 0U);
  EXPECT_EQ(done.sensor.lost, 0U);
  double removed = 0.0;
  for (const simulate::Step& step : cell.made->steps()) removed += step.removed_volume;
  // All of the line but what the period that is open at the end has taken.
  EXPECT_NEAR(removed, 4e-3 * simulate::cross_section(cell.profile), 0.05 * removed);
  cell.made.reset();
  recorder.finish();
  const Recording recording = read_recording(file);
  const Replay same = replay(recording.periods, adaptive(), loop.first_feed);
  EXPECT_GT(same.periods, 50U);
  EXPECT_EQ(same.different, 0U);
  EXPECT_EQ(recording.samples.size(), done.sensor.received);
  std::filesystem::remove(file);
}

TEST(LinuxcncPlant, StandsAfterAFaultUntilItGoes) {
  Cell cell(60e-3);
  std::vector<control::LoopEvent> told;
  cell.options.on_event = [&](const control::LoopEvent& event) { told.push_back(event); };
  control::Plant& plant = cell.plant();
  plant.start();
  for (int i = 0; i < 20; ++i) plant.advance({6e-3, control::Mode::constant, false});
  EXPECT_FALSE(cell.made->stopped());
  cell.sensor.set_fault(netft::SensorFault::saturated);
  control::Observation seen;
  for (int i = 0; i < 20; ++i) seen = plant.advance({6e-3, control::Mode::constant, false});
  EXPECT_TRUE(seen.finished);
  EXPECT_TRUE(cell.made->stopped());
  const double at = cell.fake->x;
  cell.sensor.set_fault(netft::SensorFault::none);
  for (int i = 0; i < 20; ++i) plant.advance({6e-3, control::Mode::constant, false});
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(cell.fake->x, at);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].cause, control::Cause::sensor_saturated);
  const MachineSummary done = cell.made->summary();
  ASSERT_TRUE(done.stop && done.stop->held && done.stop->rest && done.stop->spindle);
}

TEST(LinuxcncPlant, HoldsWhenTheControllerLeaves) {
  Cell cell(60e-3);
  control::Plant& plant = cell.plant();
  plant.start();
  for (int i = 0; i < 10; ++i) plant.advance({6e-3, control::Mode::constant, false});
  EXPECT_GT(cell.fake->x, 0.0);
  cell.made.reset();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const double at = cell.fake->x;
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(cell.fake->x, at);
}

TEST(LinuxcncPlant, KnowsAMachineThatIsLost) {
  Cell cell(60e-3);
  control::Plant& plant = cell.plant();
  plant.start();
  for (int i = 0; i < 10; ++i) plant.advance({6e-3, control::Mode::constant, false});
  cell.fake->silent = true;
  EXPECT_TRUE(plant.advance({6e-3, control::Mode::constant, false}).finished);
  ASSERT_TRUE(cell.made->summary().stop);
  EXPECT_EQ(cell.made->summary().stop->event.cause, control::Cause::machine_lost);
}

TEST(LinuxcncPlant, RefusesSamplesThatDoNotFitTheServoPeriod) {
  Cell cell(4e-3);
  cell.options.sample_rate = 7500.0;
  EXPECT_THROW(cell.plant(), InvalidInput);
}

}  // namespace
}  // namespace osteomill::io
