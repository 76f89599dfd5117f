// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/played_bone.hpp"

#include <semaphore.h>

#include <algorithm>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cerrno>
#include <exception>
#include <mutex>
#include <thread>

#include "osteomill/io/real_time.hpp"

namespace osteomill::io {
namespace {

constexpr std::size_t kMostWaiting = 4096;  // cycles
constexpr int kPriority = 60;               // below the controller's

}  // namespace

struct PlayedBone::Parts {
  Parts(simulate::Milling& bone, netft::FakeSensor* sensor, int samples)
      : milling(bone), fake(sensor), positions(samples), feeds(samples), load(samples) {
    sem_init(&news, 0, 0);
    thread = std::thread([this] { work(); });
  }
  ~Parts() {
    end();
    sem_destroy(&news);
  }

  void end() {
    over = true;
    sem_post(&news);
    if (thread.joinable()) thread.join();
  }

  void work() {
    ask_for_real_time(kPriority);
    try {
      while (true) {
        const bool last = over;  // before the ring is emptied
        PlayedCycle piece;
        while (cycles.pop(piece)) play(piece);
        if (last) return;
        while (sem_wait(&news) != 0 && errno == EINTR) {
        }
      }
    } catch (...) {
      failure = std::current_exception();
      failed = true;
    }
  }

  void play(const PlayedCycle& piece) {
    if (piece.cycle && log.empty()) milling.start_at(piece.from);
    const auto count = static_cast<double>(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const double share = static_cast<double>(i + 1) / count;
      positions[i] = piece.from + share * (piece.to - piece.from);
      feeds[i] = piece.feed_from + share * (piece.feed_to - piece.feed_from);
      load[i] = {};
    }
    if (piece.cut) {
      const simulate::Cut& cut = milling.follow(positions, feeds);
      for (std::size_t i = 0; i < load.size(); ++i) {
        load[i].force_S = cut.forces_W[i];
        load[i].torque_S.z() = cut.torques[i];
      }
    }
    if (piece.cycle && fake != nullptr) fake->measure(load);
    keep(piece);
  }

  void keep(const PlayedCycle& piece) {
    if (piece.ends_period) milling.end_period(piece.request);
    const std::lock_guard lock(mutex);
    if (piece.cycle) {
      if (!log.empty()) kept.lost += piece.cycle->number - log.back().number - 1;
      log.push_back(*piece.cycle);
      if (piece.cut) kept.bone_lag = std::max(kept.bone_lag, newest - piece.cycle->number);
      while (changes.read_available() > 0 && changes.front().order <= piece.cycle->order) {
        kept.feed_delays.push_back(static_cast<int>(piece.cycle->number - changes.front().seen));
        changes.pop();
      }
    }
    kept.stop = piece.stop;
    if (!piece.ends_period) return;
    simulate::Step step = milling.steps().back();
    // What the bone gave is replaced by what the sensor measured of it.
    if (step.samples_in_contact > 0) {
      step.sum_force = piece.sum_force / std::max(1, piece.samples) * step.samples_in_contact;
    }
    step.mean_force = piece.mean_force;
    step.peak_force = piece.peak_force;
    step.time_above_limit = piece.time_above_limit;
    step.mean_torque = piece.mean_torque;
    steps.push_back(step);
  }

  simulate::Milling& milling;
  netft::FakeSensor* fake;
  std::vector<double> positions, feeds;  ///< of the samples of a cycle
  std::vector<netft::Sample> load;

  boost::lockfree::spsc_queue<PlayedCycle, boost::lockfree::capacity<kMostWaiting>> cycles;
  boost::lockfree::spsc_queue<FeedChange, boost::lockfree::capacity<256>> changes;
  std::atomic<std::uint32_t> newest{0};  ///< number of the newest cycle that was given
  std::atomic<bool> over{false};
  std::atomic<bool> failed{false};  ///< `failure` is written before
  sem_t news{};
  std::exception_ptr failure;

  mutable std::mutex mutex;  ///< for what is kept, between this thread and who asks for it
  MachineSummary kept;
  std::vector<linuxcnc::Cycle> log;
  std::vector<simulate::Step> steps;

  std::thread thread;
};

PlayedBone::PlayedBone(simulate::Milling& milling, netft::FakeSensor* fake, int samples)
    : parts_(std::make_unique<Parts>(milling, fake, samples)) {}

PlayedBone::~PlayedBone() = default;

void PlayedBone::give(const PlayedCycle& cycle) noexcept {
  if (cycle.cycle) parts_->newest = cycle.cycle->number;
  parts_->cycles.push(cycle);
  sem_post(&parts_->news);
}

void PlayedBone::give(const FeedChange& change) noexcept { parts_->changes.push(change); }

void PlayedBone::finish() {
  parts_->end();
  if (parts_->failure) std::rethrow_exception(parts_->failure);
}

bool PlayedBone::failed() const noexcept { return parts_->failed; }

MachineSummary PlayedBone::summary() const {
  const std::lock_guard lock(parts_->mutex);
  MachineSummary done = parts_->kept;
  done.cycles = static_cast<std::uint32_t>(parts_->log.size());
  return done;
}

std::vector<simulate::Step> PlayedBone::steps() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->steps;
}

std::vector<linuxcnc::Cycle> PlayedBone::cycles() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->log;
}

}  // namespace osteomill::io
