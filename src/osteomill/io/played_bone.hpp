// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "osteomill/io/linuxcnc_link.hpp"
#include "osteomill/io/machine_summary.hpp"
#include "osteomill/io/netft_fake.hpp"
#include "osteomill/simulate/milling.hpp"

namespace osteomill::io {

/// A servo cycle on its way from the thread that watches the machine to the one that plays the
/// bone.
struct PlayedCycle {
  std::optional<linuxcnc::Cycle> cycle;  ///< none: the machine is lost
  double from = 0.0;                     ///< along the case's path, m
  double to = 0.0;
  double feed_from = 0.0;  ///< of the tool, m/s
  double feed_to = 0.0;
  bool cut = false;  ///< on the case's path

  bool ends_period = false;  ///< of control; the rest is about that period
  simulate::FeedRequest request;
  double sum_force = 0.0;  ///< as the sensor measured: of the magnitudes, N
  int samples = 0;
  double mean_force = 0.0;
  double peak_force = 0.0;
  double mean_torque = 0.0;
  double time_above_limit = 0.0;

  std::optional<MachineStop> stop;  ///< as far as it is known
};

/// An order that changed the feed.
struct FeedChange {
  std::int32_t order = 0;
  std::uint32_t seen = 0;  ///< newest cycle when it left
};

/// Plays the bone from what a machine reports, in a thread of its own, and loads the fake sensor
/// with its forces. A bone that takes longer than the machine's cycle falls behind, its forces
/// grow old, and the supervisor stops the machine when they are too old: that bounds the lag.
/// It also keeps what is to be known afterwards, so that the thread that watches need not.
class PlayedBone {
 public:
  /// `fake`: none with a real sensor. `samples`: of the sensor in a servo cycle.
  PlayedBone(simulate::Milling& milling, netft::FakeSensor* fake, int samples);
  ~PlayedBone();
  PlayedBone(const PlayedBone&) = delete;
  PlayedBone& operator=(const PlayedBone&) = delete;

  // For the thread that watches: no heap, lock or throw. What finds no place is lost; by then the
  // bone is four seconds behind.
  void give(const PlayedCycle& cycle) noexcept;
  void give(const FeedChange& change) noexcept;

  /// Plays what was given and ends. Throws what went wrong with the bone.
  void finish();
  /// Whether something has gone wrong; finish() says what.
  bool failed() const noexcept;

  // As far as it has come.
  MachineSummary summary() const;  ///< without the sensor and the gap
  std::vector<simulate::Step> steps() const;
  std::vector<linuxcnc::Cycle> cycles() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace osteomill::io
