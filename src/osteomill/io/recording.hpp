// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "osteomill/control/feed_controller.hpp"
#include "osteomill/control/loop.hpp"
#include "osteomill/control/plant.hpp"
#include "osteomill/io/netft_client.hpp"

namespace osteomill::io {

/// One control period: what the controller saw and what it answered.
struct RecordedPeriod {
  control::Observation seen;
  control::FeedCommand command;
};

/// What a recording holds.
struct Recording {
  std::vector<RecordedPeriod> periods;
  std::vector<netft::Sample> samples;
  std::vector<control::LoopEvent> events;
};

struct RecorderOptions {
  /// A real-time thread is never kept waiting: what finds no place is counted as dropped. Otherwise
  /// who records waits for the disk.
  bool real_time = false;
};

/// Writes every control period, every force sample and every event to an HDF5 file (single writer,
/// many readers). They are handed over without a lock or the heap to a thread of its own, which
/// flushes ten times a second: a process that is killed loses that much and the file opens whatever
/// happens.
///
///   /periods  /samples  /events   float64 [rows][columns]; attribute columns: names with units
///
/// Periods, samples and events may come from three threads, but each kind from one only.
class Recorder {
 public:
  /// WorldError when the file cannot be made.
  explicit Recorder(const std::filesystem::path& file, const RecorderOptions& options = {});
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void add(const RecordedPeriod& period) noexcept;
  void add(std::span<const netft::Sample> samples) noexcept;
  void add(const control::LoopEvent& event) noexcept;

  /// Writes what is left and closes the file. WorldError when the disk refused something.
  void finish();
  std::uint64_t dropped() const noexcept;

 private:
  struct File;
  std::unique_ptr<File> file_;
};

/// InvalidInput when it is missing or no recording.
Recording read_recording(const std::filesystem::path& file);

/// A plant of which every period is recorded.
class RecordedPlant final : public control::Plant {
 public:
  RecordedPlant(control::Plant& plant, Recorder& recorder) : plant_(plant), recorder_(recorder) {}
  control::Observation start() override { return seen_ = plant_.start(); }
  control::Observation advance(const control::FeedCommand& command) override {
    recorder_.add({seen_, command});
    return seen_ = plant_.advance(command);
  }

 private:
  control::Plant& plant_;
  Recorder& recorder_;
  control::Observation seen_;
};

struct Replay {
  std::size_t periods = 0;
  std::size_t different = 0;         ///< commands that are not the same bit for bit
  std::size_t first_difference = 0;  ///< period of the first of them
};

/// Gives the controller what it saw and compares what it answers. Periods in which a supervisor had
/// stopped the machine (mode stopped) are left out.
Replay replay(const std::vector<RecordedPeriod>& recording,
              const control::FeedController& controller, double first_feed);

}  // namespace osteomill::io
