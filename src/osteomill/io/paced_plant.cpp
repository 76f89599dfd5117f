// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/paced_plant.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/real_time.hpp"

namespace osteomill::io {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * kSecond + now.tv_nsec;
}

void sleep_until(std::int64_t due) {
  const timespec at{static_cast<time_t>(due / kSecond), static_cast<long>(due % kSecond)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
  }
}

}  // namespace

PacedPlant::PacedPlant(control::Plant& plant, double period)
    : plant_(plant),
      period_ns_(
          std::llround(require_positive("controller.period_ms", period / units::ms, "ms") * 1e6)),
      real_time_(ask_for_real_time()) {}

control::Observation PacedPlant::start() {
  due_ns_ = now_ns();
  return plant_.start();
}

control::Observation PacedPlant::advance(const control::FeedCommand& command) {
  const control::Observation seen = plant_.advance(command);
  due_ns_ += period_ns_;
  sleep_until(due_ns_);
  const std::int64_t late = now_ns() - due_ns_;
  largest_lateness_ =
      std::max(largest_lateness_, static_cast<double>(late) / static_cast<double>(kSecond));
  const auto cell = static_cast<std::size_t>(std::max<std::int64_t>(0, late / 1000));
  ++wake_ups_[std::min(cell, wake_ups_.size() - 1)];
  return seen;
}

double PacedPlant::lateness(double share) const {
  const double all = std::accumulate(wake_ups_.begin(), wake_ups_.end(), 0.0);
  double below = 0.0;
  std::size_t cell = 0;
  while (cell + 1 < wake_ups_.size() && (below += wake_ups_[cell]) < share * all) ++cell;
  return static_cast<double>(cell + 1) * 1e-6;
}

}  // namespace osteomill::io
