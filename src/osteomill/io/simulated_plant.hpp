// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "osteomill/control/plant.hpp"
#include "osteomill/io/netft_client.hpp"
#include "osteomill/simulate/milling.hpp"

namespace osteomill::io {

/// A simulated milling job as a controller finds it. Neither `control` nor `simulate` knows the
/// other; here they meet.
class SimulatedPlant final : public control::Plant {
 public:
  using Listener = std::function<void(std::span<const netft::Sample>)>;
  /// `on_samples` is told what a force sensor would measure; none: nobody is.
  explicit SimulatedPlant(simulate::Milling& milling, Listener on_samples = {})
      : milling_(milling), on_samples_(std::move(on_samples)) {}

  control::Observation start() override { return seen(milling_.report()); }
  control::Observation advance(const control::FeedCommand& command) override {
    const simulate::Report report =
        milling_.advance({command.feed, static_cast<int>(command.mode), command.saturated,
                          command.spindle_speed, static_cast<int>(command.bound)});
    if (on_samples_) tell();
    return seen(report);
  }

 private:
  static control::Observation seen(const simulate::Report& report) {
    control::Observation seen;
    seen.time = report.time;
    seen.position = report.position;
    seen.feed = report.feed;
    seen.spindle_speed = report.spindle_speed;
    seen.programmed_feed = report.programmed_feed;
    seen.rapid = report.rapid;
    seen.mean_force = report.mean_force;
    seen.peak_force = report.peak_force;
    seen.mean_torque = report.mean_torque;
    seen.tooth_line = report.tooth_line;
    seen.revolution_line = report.revolution_line;
    seen.sample_time = report.time;
    seen.to_contact = report.to_contact;
    seen.to_engagement = report.to_engagement;
    seen.temperature = report.temperature;
    seen.no_go_distance = report.no_go_distance;
    seen.finished = report.finished;
    return seen;
  }

  void tell() {
    const simulate::Cut& cut = milling_.last_cut();
    samples_.resize(cut.forces_W.size());
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      samples_[i] = {cut.forces_W[i], {0.0, 0.0, cut.torques[i]}, ++told_};
    }
    on_samples_(samples_);
  }

  simulate::Milling& milling_;
  Listener on_samples_;
  std::vector<netft::Sample> samples_;
  std::uint32_t told_ = 0;  ///< samples so far
};

}  // namespace osteomill::io
