// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "osteomill/base/progress.hpp"
#include "osteomill/control/feed_controller.hpp"
#include "osteomill/control/plant.hpp"

namespace osteomill::control {

enum class LoopEnd : std::uint8_t {
  finished,  ///< the path has come to its end
  stopped,   ///< asked to stop
  stalled    ///< no feed was commanded for `patience`
};

struct LoopOptions {
  double first_feed = 3e-3;  ///< what the accumulator starts from, m/s
  double patience = 5.0;     ///< s
  double path_length = 0.0;  ///< for the share of progress, m
};

/// Runs a controller on a plant as fast as the plant answers.
LoopEnd run(Plant& plant, const FeedController& controller, const LoopOptions& options,
            const Progress& progress = {});

}  // namespace osteomill::control
