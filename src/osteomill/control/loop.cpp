// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/loop.hpp"

#include <algorithm>

namespace osteomill::control {

LoopEnd run(Plant& plant, const FeedController& controller, const LoopOptions& options,
            const Progress& progress) {
  check(controller);
  ControllerState state;
  state.feed = options.first_feed;
  double moved_at = 0.0;
  int periods = 0;
  for (Observation seen = plant.start(); !seen.finished; ++periods) {
    const ControlStep next = step(controller, state, seen);
    state = next.state;
    seen = plant.advance(next.command);
    if (next.command.feed > 0.0) moved_at = seen.time;
    if (seen.time - moved_at > options.patience) return LoopEnd::stalled;
    if (periods % 50 == 0 &&
        !go_on(progress, "milling", std::min(1.0, seen.position / options.path_length))) {
      return LoopEnd::stopped;
    }
  }
  return LoopEnd::finished;
}

}  // namespace osteomill::control
