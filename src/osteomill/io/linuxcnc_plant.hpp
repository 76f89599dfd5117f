// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "osteomill/control/plant.hpp"
#include "osteomill/control/supervisor.hpp"
#include "osteomill/io/linuxcnc_machine.hpp"
#include "osteomill/io/machine_path.hpp"
#include "osteomill/io/machine_summary.hpp"
#include "osteomill/io/netft_client.hpp"
#include "osteomill/io/netft_fake.hpp"
#include "osteomill/numerics/revolution_window.hpp"
#include "osteomill/simulate/milling.hpp"

namespace osteomill::io {

struct LinuxcncOptions {
  control::SupervisorLimits supervisor;
  double full_feed = 12e-3;    ///< that the program asks for; commands are shares of it, m/s
  double servo_period = 1e-3;  ///< of the machine, s
  /// Without a servo cycle for so long the machine is lost, s. It does not move meanwhile: what
  /// moves it is that cycle.
  double silence = 0.25;
  double force_limit = 30.0;    ///< N; time above it is counted
  double spindle_speed = 0.0;   ///< rad/s
  double sample_rate = 8000.0;  ///< of the force sensor, 1/s
  int flutes = 2;
  std::function<double()> clock;  ///< s; how old a force is, how long the controller took
  /// Changes what the supervisor sees: how tests bring in a fault that neither the fake sensor nor
  /// the machine can have. None: nothing is changed.
  std::function<void(control::SupervisorInput&)> disturb;
};

/// LinuxCNC moves, the bone is played from the positions that it reports, and the forces come from
/// a Net F/T sensor, or from a fake one that measures what the bone gives. The supervisor looks in
/// every servo cycle, not once a control period, and what it says goes to the machine at once. When
/// it has stopped the machine, the observation says finished, and `summary().stop` why.
///
/// The time of the case runs while the tool is on the case's path; the moves between lines are the
/// machine's own. Without a fake the bone serves as a plan: where contact is expected.
class LinuxcncPlant final : public control::Plant {
 public:
  /// The references live as long as the plant. `fake`: none with a real sensor.
  LinuxcncPlant(linuxcnc::Machine& machine, simulate::Milling& milling, PathFollower follower,
                netft::Client& sensor, netft::FakeSensor* fake, const LinuxcncOptions& options,
                double control_period);

  ~LinuxcncPlant() override;
  LinuxcncPlant(const LinuxcncPlant&) = delete;
  LinuxcncPlant& operator=(const LinuxcncPlant&) = delete;

  control::Observation start() override;
  control::Observation advance(const control::FeedCommand& command) override;

  MachineSummary summary() const;
  bool stopped() const;
  /// As the sensor measured it: the bone's periods with the forces of the sensor in their place.
  std::vector<simulate::Step> steps() const;
  /// Every cycle that was seen.
  std::vector<linuxcnc::Cycle> cycles() const;

 private:
  void watch_machine();
  bool watching();
  void play(const linuxcnc::Cycle& cycle);
  void measure(const PathFollower::Place& place, const linuxcnc::Cycle& cycle);
  void look(const linuxcnc::Cycle& cycle, bool answers);
  const char* missing(const linuxcnc::Cycle& cycle, bool answers);
  void note_stop(const linuxcnc::Cycle& cycle);
  void order();
  void close_period();
  control::Observation observe() const;
  control::Observation wait_for_period(std::unique_lock<std::mutex>& lock);

  linuxcnc::Machine& machine_;
  simulate::Milling& milling_;
  PathFollower follower_;
  netft::Client& sensor_;
  netft::FakeSensor* fake_;
  LinuxcncOptions options_;
  int cycles_per_period_ = 10;
  int samples_per_cycle_ = 8;

  control::FeedCommand command_;
  control::SupervisorState watch_;
  control::SupervisorStep verdict_;
  std::optional<double> asked_;  ///< clock when the controller got to work; none: it waits
  double stop_by_ = 0.0;         ///< clock until which a stop is followed

  std::vector<linuxcnc::Cycle> log_;
  std::uint32_t lost_ = 0;
  int heard_ = 0;  ///< cycles in a row, at the beginning, with the watchdog content
  PathFollower::Place place_;
  double feed_ = 0.0;         ///< of the tool, m/s
  int cycles_in_period_ = 0;  ///< on the case's path
  bool period_over_ = false;  ///< and the controller has not seen it yet
  bool on_path_ = false;      ///< the approach is over

  numerics::RevolutionWindow force_, torque_;
  std::vector<double> positions_, feeds_;  ///< of the samples of a cycle
  std::vector<netft::Sample> load_, arrived_;
  double peak_in_cycle_ = 0.0;
  simulate::Step measured_;  ///< forces of the period so far
  std::vector<simulate::Step> steps_;

  struct Sent {
    std::int32_t number = 0;
    std::uint32_t seen = 0;  ///< newest cycle when the order left
  };
  std::vector<Sent> changes_;  ///< orders that changed the feed and have not been seen yet
  double sent_feed_ = -1.0;
  std::vector<int> feed_delays_;
  std::optional<MachineStop> stop_;

  // What the thread and the controller share is everything above, under this.
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;   ///< the thread looks no more
  bool leave_ = false;  ///< it is asked to end
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace osteomill::io
