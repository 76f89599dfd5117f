// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "osteomill/control/plant.hpp"
#include "osteomill/simulate/milling.hpp"

namespace osteomill::io {

/// A simulated milling job as a controller finds it. Neither `control` nor `simulate` knows the
/// other; here they meet.
class SimulatedPlant final : public control::Plant {
 public:
  explicit SimulatedPlant(simulate::Milling& milling) : milling_(milling) {}

  control::Observation start() override { return seen(milling_.report()); }
  control::Observation advance(const control::FeedCommand& command) override {
    return seen(
        milling_.advance({command.feed, static_cast<int>(command.mode), command.saturated}));
  }

 private:
  static control::Observation seen(const simulate::Report& report) {
    control::Observation seen;
    seen.time = report.time;
    seen.position = report.position;
    seen.feed = report.feed;
    seen.programmed_feed = report.programmed_feed;
    seen.mean_force = report.mean_force;
    seen.peak_force = report.peak_force;
    seen.mean_torque = report.mean_torque;
    seen.tooth_line = report.tooth_line;
    seen.revolution_line = report.revolution_line;
    seen.sample_time = report.time;
    seen.to_contact = report.to_contact;
    seen.entering = report.entering;
    seen.finished = report.finished;
    return seen;
  }

  simulate::Milling& milling_;
};

}  // namespace osteomill::io
