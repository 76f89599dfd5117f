// SPDX-License-Identifier: BSD-3-Clause
// What a control step and a look of the supervisor take from heap, locks and exceptions: nothing.
// This program replaces malloc, the mutex and throw by ones that count; hence a program of its own.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "osteomill/base/random.hpp"
#include "osteomill/control/feed_controller.hpp"
#include "osteomill/control/supervisor.hpp"

namespace {

struct Counts {
  long heap = 0, locks = 0, throws = 0;
};
thread_local bool counting = false;
thread_local Counts counts;

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t size) noexcept;
void* __libc_calloc(std::size_t count, std::size_t size) noexcept;
void* __libc_realloc(void* memory, std::size_t size) noexcept;
void* __libc_memalign(std::size_t alignment, std::size_t size) noexcept;
void __libc_free(void* memory) noexcept;

void* malloc(std::size_t size) noexcept {
  if (counting) ++counts.heap;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  if (counting) ++counts.heap;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  if (counting) ++counts.heap;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  if (counting) ++counts.heap;
  return __libc_memalign(alignment, size);
}
void free(void* memory) noexcept {
  if (counting) ++counts.heap;
  __libc_free(memory);
}
int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static const auto lock = next<int (*)(pthread_mutex_t*)>("pthread_mutex_lock");
  if (counting) ++counts.locks;
  return lock(mutex);
}
[[noreturn]] void __cxa_throw(void* thrown, void* type, void (*destroy)(void*)) {
  static const auto on = next<void (*)(void*, void*, void (*)(void*))>("__cxa_throw");
  if (counting) ++counts.throws;
  on(thrown, type, destroy);
  std::abort();
}
}

namespace osteomill::control {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

template <class Work>
Counts counted(Work work) {
  counts = {};
  counting = true;
  work();
  counting = false;
  return counts;
}

void expect_nothing(const Counts& taken) {
  EXPECT_EQ(taken.heap, 0);
  EXPECT_EQ(taken.locks, 0);
  EXPECT_EQ(taken.throws, 0);
}

std::vector<std::pair<std::string, FeedController>> controllers() {
  std::vector<std::pair<std::string, FeedController>> all;
  const auto add = [&](const char* name, auto law) {
    FeedController controller;
    controller.law = std::move(law);
    controller.limits.lowest = 0.4e-3;
    controller.limits.acceleration = 1.0;
    controller.predictive = PredictiveMode{};
    all.emplace_back(name, std::move(controller));
  };
  add("constant", ConstantFeed{});
  add("override", SugitaLoop{.reading = SumReading::override});
  add("mean", SugitaLoop{.reading = SumReading::mean});
  add("sum", SugitaLoop{.reading = SumReading::sum});
  add("model-adaptive", ModelAdaptive({}));
  const std::vector<double> gains(2000, 3e3), edges(2000, 1.0), rises(2000, 30.0);
  Forecast map{0.1e-3, gains, edges, gains, edges};
  add("model-predictive", ModelPredictive({}, map));
  // All of its limits and handles.
  map.heat = {2e-3, 12e-3, 900.0, std::vector<double>(2000, 60.0), rises, rises};
  ModelPredictiveOptions options;
  options.limits = {30.0, 25.0, 0.1e-3, 330.15};
  options.spindle_speed = 600.0;
  options.spindle = SpindleHandle{400.0, 900.0, 0.2};
  options.chatter = {{{400.0, 9e-3}, {900.0, 5e-3}}, 3000.0, 5e-3, 1.2};
  add("model-predictive, every limit", ModelPredictive(options, map));
  return all;
}

/// A value as it may come from a sensor: mostly sane.
double odd(Random& random, double sane) {
  const double which = random.uniform();
  if (which < 0.01) return kNan;
  if (which < 0.02) return std::numeric_limits<double>::infinity();
  if (which < 0.03) return -1e300;
  return sane * random.uniform(0.0, 2.0);
}

TEST(Counting, SeesHeapLocksAndThrows) {
  std::mutex mutex;
  const Counts taken = counted([&] {
    const auto memory = std::make_unique<int>(7);
    const std::lock_guard lock(mutex);
    try {
      throw *memory;
    } catch (int) {
    }
  });
  EXPECT_GE(taken.heap, 2);
  EXPECT_EQ(taken.locks, 1);
  EXPECT_EQ(taken.throws, 1);
}

TEST(CountedStep, EveryControllerTakesNothingWhateverItSees) {
  for (const auto& [name, controller] : controllers()) {
    SCOPED_TRACE(name);
    Random random(5);
    ControllerState state;
    expect_nothing(counted([&] {
      for (int i = 0; i < 20'000; ++i) {
        Observation seen;
        seen.time = 0.01 * i;
        seen.position = 1e-5 * i;
        seen.feed = odd(random, 5e-3);
        seen.programmed_feed = 3e-3;
        seen.mean_force = odd(random, 12.0);
        seen.peak_force = odd(random, 18.0);
        seen.to_contact = odd(random, 5e-3);
        state = step(controller, state, seen).state;
      }
    }));
    EXPECT_TRUE(std::isfinite(state.feed));
  }
}

TEST(CountedStep, TheSupervisorTakesNothingWhateverItSees) {
  Random random(6);
  const SupervisorLimits limits;
  int stops = 0;
  expect_nothing(counted([&] {
    SupervisorState state;
    for (int i = 0; i < 20'000; ++i) {
      if (state.cause != Cause::none) state = confirmed();
      SupervisorInput in;
      in.clock = odd(random, 0.01 * i);
      in.sample_clock = in.clock;
      in.mean_force = odd(random, 12.0);
      in.peak_force = odd(random, 80.0);
      in.torque = odd(random, 1.1);
      in.feed = in.command = odd(random, 6e-3);
      in.temperature = odd(random, 160.0);
      in.machine_answers = random.uniform() > 0.01;
      const SupervisorStep next = supervise(limits, state, in);
      stops += next.tripped ? 1 : 0;
      state = next.state;
    }
  }));
  EXPECT_GT(stops, 1000);
}

}  // namespace
}  // namespace osteomill::control
