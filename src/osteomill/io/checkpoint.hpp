// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "osteomill/control/plant.hpp"
#include "osteomill/simulate/milling.hpp"
#include "osteomill/simulate/stock_job.hpp"

namespace osteomill::io {

/// Where and how often the state of a run is kept on disk.
struct CheckpointOptions {
  std::filesystem::path folder;   ///< NAME.checkpoint of each run goes there
  double every = 60.0;            ///< s by `clock`
  bool resume = false;            ///< go on from what is there
  std::function<double()> clock;  ///< s
  std::string program;            ///< name and version: another one's checkpoint is refused
  std::function<void(const std::string&)> say;  ///< what the user has to know
};

/// A simulated plant that keeps its state on disk and comes back from there.
///
/// A checkpoint holds bone, cutter, temperatures, machine and record as they lie in memory, and
/// what the plant answered in each period. Whoever commands is not in it: when a run is resumed,
/// the controller lives through the recorded answers again, which takes no time, and its commands
/// must be the recorded ones, bit for bit. So the result is that of the run without a break. Files
/// appear under their name only when they are whole and on disk.
class CheckpointedPlant final : public control::Plant {
 public:
  /// Comes back from the folder's checkpoint of that name when asked to and when there is one.
  /// `identity` says what is run: the expanded case. InvalidInput when the checkpoint is of
  /// something else or broken. All must outlive the plant.
  CheckpointedPlant(control::Plant& inner, simulate::Milling& milling,
                    simulate::StockWorkpiece& workpiece, const std::string& name,
                    const std::string& identity, const CheckpointOptions& options);

  control::Observation start() override;
  /// WorldError when it is time for a checkpoint and the disk refuses; the one before stays.
  control::Observation advance(const control::FeedCommand& command) override;

  /// Writes the state as it is now.
  void save();
  /// Periods that were taken from the checkpoint.
  std::size_t resumed() const { return resumed_; }

 private:
  void load();

  control::Plant& inner_;
  simulate::Milling& milling_;
  simulate::StockWorkpiece& workpiece_;
  CheckpointOptions options_;
  std::filesystem::path file_;
  std::string head_;
  std::vector<control::Observation> answers_;  ///< of start and of each period
  std::vector<double> commands_;               ///< feeds
  std::size_t at_ = 0;                         ///< next answer to be given again
  std::size_t resumed_ = 0;
  double saved_at_ = 0.0;
};

}  // namespace osteomill::io
