// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "osteomill/control/loop.hpp"
#include "osteomill/control/plant.hpp"
#include "osteomill/control/supervisor.hpp"

namespace osteomill::io {

struct SupervisedOptions {
  control::SupervisorLimits limits;
  std::function<double()> clock;  ///< s, monotonic: what the controller's steps are timed by
  /// Told of a stop at once, by the thread that stopped: it must not wait.
  std::function<void(const control::LoopEvent&)> on_event = {};
  /// How tests bring in faults: changes what the supervisor sees; or keeps it from looking.
  std::function<void(control::SupervisorInput&)> disturb = {};
  std::function<void()> before_look = {};
};

/// A stop in the plant's own time, s.
struct SupervisedStop {
  control::LoopEvent event;
  std::optional<double> held;     ///< first period that began with no feed asked for
  std::optional<double> rest;     ///< the end of the first period at rest
  std::optional<double> spindle;  ///< when the spindle's inhibit was asked for
};

/// A plant in real time under a supervisor that does not run in the controller's thread.
///
/// Three threads: the machine's moves the plant period by period with the last feed that it was
/// given, whether or not the controller answers; the supervisor's looks at every period; the
/// controller's is that of the caller. The plant inside sets the pace (PacedPlant). A controller
/// that takes longer than its period is stopped by the supervisor. A supervisor that does not look
/// for limits.watchdog_periods is found by the machine's thread, its watchdog, which then stops. A
/// plant that gives no period for as long is lost.
///
/// After a stop the plant gets feed zero, whatever the controller asks for, until it rests; then it
/// is finished. It never starts again.
class SupervisedPlant final : public control::Plant {
 public:
  SupervisedPlant(control::Plant& plant, const SupervisedOptions& options);
  ~SupervisedPlant() override;
  SupervisedPlant(const SupervisedPlant&) = delete;
  SupervisedPlant& operator=(const SupervisedPlant&) = delete;

  control::Observation start() override;
  /// Gives the command and waits for the end of the period. Rethrows what the plant threw.
  control::Observation advance(const control::FeedCommand& command) override;

  std::optional<SupervisedStop> stop() const;
  /// Whether the supervisor's thread has real-time rights.
  bool real_time() const { return real_time_; }
  /// Ends the threads and puts the stop, when there was one, into the summary of the loop.
  void finish(control::LoopSummary& loop);

 private:
  static constexpr std::size_t kPending = 64;
  void move();
  void watch();
  void look(const control::Observation& seen, bool answers);
  void trip(const control::LoopEvent& event);
  control::FeedCommand next_command();
  void end();

  control::Plant& plant_;
  SupervisedOptions options_;
  bool real_time_ = false;

  // What the threads share is below, under this.
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  control::Observation seen_;
  std::array<control::Observation, kPending> pending_{};  ///< not yet looked at, a ring
  std::int64_t periods_ = 0;                              ///< that are over
  std::int64_t looked_ = 0;                               ///< that the supervisor has seen
  control::FeedCommand command_;
  bool answered_ = false;  ///< the controller has answered the newest period
  double asked_at_ = 0.0;  ///< when it was asked what it has not answered, or answered last
  double took_ = 0.0;      ///< its last answer, s
  control::SupervisorState state_;
  std::optional<SupervisedStop> stop_;
  bool done_ = false;   ///< the machine moves no more
  bool leave_ = false;  ///< the threads are asked to end
  std::exception_ptr failure_;
  std::thread machine_;
  std::thread supervisor_;
};

}  // namespace osteomill::io
