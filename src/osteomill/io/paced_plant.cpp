// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/paced_plant.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

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
          std::llround(require_positive("controller.period_ms", period / units::ms, "ms") * 1e6)) {
  sched_param priority{};
  priority.sched_priority = 80;
  real_time_ =
      sched_setscheduler(0, SCHED_FIFO, &priority) == 0 && mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

control::Observation PacedPlant::start() {
  due_ns_ = now_ns();
  return plant_.start();
}

control::Observation PacedPlant::advance(const control::FeedCommand& command) {
  const control::Observation seen = plant_.advance(command);
  due_ns_ += period_ns_;
  sleep_until(due_ns_);
  largest_lateness_ = std::max(
      largest_lateness_, static_cast<double>(now_ns() - due_ns_) / static_cast<double>(kSecond));
  return seen;
}

}  // namespace osteomill::io
