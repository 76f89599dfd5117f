// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "osteomill/control/plant.hpp"

namespace osteomill::io {

/// A plant in real time: every period ends when the clock says so. Asks for SCHED_FIFO and locked
/// memory when it is made, and says whether it got them.
class PacedPlant final : public control::Plant {
 public:
  PacedPlant(control::Plant& plant, double period);

  control::Observation start() override;
  control::Observation advance(const control::FeedCommand& command) override;

  bool real_time() const { return real_time_; }
  double largest_lateness() const { return largest_lateness_; }  ///< of a wake-up, s
  /// Below which that share of the wake-ups was, to a microsecond; s. The last cell is open.
  double lateness(double share) const;

 private:
  control::Plant& plant_;
  std::int64_t period_ns_;
  std::int64_t due_ns_ = 0;  ///< monotonic clock
  double largest_lateness_ = 0.0;
  std::array<std::uint32_t, 2000> wake_ups_{};  ///< by their lateness in whole microseconds
  bool real_time_ = false;
};

}  // namespace osteomill::io
