// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "osteomill/control/feed_controller.hpp"
#include "osteomill/control/plant.hpp"

namespace osteomill::io {

/// One control period: what the controller saw and what it answered.
struct RecordedPeriod {
  control::Observation seen;
  control::FeedCommand command;
};

/// Writes every control period to an HDF5 file (single writer, many readers). Periods are flushed
/// in blocks of 0.25 s at 100 Hz, so that a process that is killed loses at most the last block and
/// the file opens whatever happens.
///
///   /periods   float64 [periods][columns]; attribute columns: the names, with units
class Recorder {
 public:
  /// WorldError when the file cannot be made.
  explicit Recorder(const std::filesystem::path& file);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void add(const RecordedPeriod& period);
  void flush();

  static constexpr std::size_t kBlock = 25;

 private:
  struct File;
  std::unique_ptr<File> file_;
  std::vector<double> block_;
};

/// InvalidInput when it is missing or no recording.
std::vector<RecordedPeriod> read_recording(const std::filesystem::path& file);

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
