// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <semaphore.h>

#include <array>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "osteomill/control/plant.hpp"
#include "osteomill/control/supervisor.hpp"
#include "osteomill/io/joint_program.hpp"
#include "osteomill/io/linuxcnc_machine.hpp"
#include "osteomill/io/machine_path.hpp"
#include "osteomill/io/machine_summary.hpp"
#include "osteomill/io/netft_client.hpp"
#include "osteomill/io/netft_fake.hpp"
#include "osteomill/io/played_bone.hpp"
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
  std::optional<CarryingRobot> robot;  ///< whose joints the machine reports; none: x, y, z
  std::function<double()> clock;       ///< s; how old a force is, how long the controller took
  /// Changes what the supervisor sees: how tests bring in a fault that neither the fake sensor nor
  /// the machine can have. None: nothing is changed.
  std::function<void(control::SupervisorInput&)> disturb;
  // What the thread that watches tells at once, in that thread; neither may wait or allocate.
  std::function<void(std::span<const netft::Sample>)> on_samples;  ///< none: nobody is told
  std::function<void(const control::LoopEvent&)> on_event;         ///< none: nobody is told
};

/// LinuxCNC moves, the bone is played from the positions that it reports, and the forces come from
/// a Net F/T sensor, or from a fake one that measures what the bone gives. The supervisor looks in
/// every servo cycle, not once a control period, and what it says goes to the machine at once. When
/// it has stopped the machine, the observation says finished, and `summary().stop` why.
///
/// The time of the case runs while the tool is on the case's path; the moves between lines are the
/// machine's own. Without a fake the bone serves as a plan: where contact is expected.
///
/// Three threads: the supervisor's, which alone talks to machine and sensor and takes neither lock
/// nor heap; the controller's, which is the caller's; and that of PlayedBone. They hand records to
/// each other through rings without locks.
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
  void watch_machine() noexcept;
  bool watching() const noexcept;
  void take_answers() noexcept;
  void play(const linuxcnc::Cycle& cycle);
  geometry::Pose tool_of(const linuxcnc::Cycle& cycle);
  void take_forces();
  void look(const linuxcnc::Cycle& cycle, bool answers);
  const char* missing(const linuxcnc::Cycle& cycle, bool answers) noexcept;
  bool waits_for_force() const noexcept;
  void note_stop(const linuxcnc::Cycle& cycle) noexcept;
  void order() noexcept;
  void close_period(PlayedCycle& piece) noexcept;
  void tell_controller() noexcept;
  control::Observation wait_for_period();

  // Of the controller's thread.
  const simulate::Milling& plan_;
  control::Observation seen_;  ///< the newest

  // Of the thread that watches, once it runs.
  linuxcnc::Machine& machine_;
  PathFollower follower_;
  Eigen::VectorXd joints_;
  double off_path_ = 0.0;  ///< largest distance of the tip from its path while cutting, m
  double off_axis_ = 0.0;  ///< and angle of the tool's axis, rad
  netft::Client& sensor_;
  LinuxcncOptions options_;
  double control_period_ = 0.0;  ///< s
  int cycles_per_period_ = 10;
  control::FeedCommand command_;
  control::SupervisorState watch_;
  control::SupervisorStep verdict_;
  std::optional<double> asked_;  ///< clock when the controller got to work; none: it waits
  double worked_ = 0.0;          ///< its longest answer since the last look, s
  double stop_by_ = 0.0;         ///< clock until which a stop is followed
  std::uint32_t cycles_ = 0;     ///< that were seen
  std::uint32_t first_ = 0;      ///< number of the first of them
  std::uint32_t newest_ = 0;     ///< and of the newest
  double looked_ = 0.0;          ///< clock of the last look
  double longest_gap_ = 0.0;     ///< between two, s
  int heard_ = 0;                ///< cycles in a row, at the beginning, with the watchdog content
  PathFollower::Place place_;
  double feed_ = 0.0;         ///< of the tool, m/s
  int cycles_in_period_ = 0;  ///< on the case's path
  int periods_ = 0;           ///< that are over
  bool on_path_ = false;      ///< the approach is over and there is a force
  numerics::RevolutionWindow force_, torque_;
  std::vector<netft::Sample> arrived_;  ///< in this cycle
  double peak_in_cycle_ = 0.0;
  double peak_in_period_ = 0.0;  ///< of the last one that is over
  PlayedCycle measured_;         ///< forces of the period so far
  double sent_feed_ = -1.0;
  std::optional<MachineStop> stop_;

  // Between the threads.
  struct Answer {
    control::FeedCommand command;
    double clock = 0.0;  ///< when the controller had it
  };
  PlayedBone bone_;
  boost::lockfree::spsc_queue<control::Observation, boost::lockfree::capacity<64>> observations_;
  boost::lockfree::spsc_queue<Answer, boost::lockfree::capacity<64>> answers_;
  sem_t news_{};  ///< for the controller
  std::atomic<bool> stopped_{false};
  std::atomic<bool> done_{false};   ///< the thread looks no more
  std::atomic<bool> leave_{false};  ///< it is asked to end
  std::thread thread_;
};

}  // namespace osteomill::io
