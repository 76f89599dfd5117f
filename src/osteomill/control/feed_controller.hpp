// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <variant>

#include "osteomill/control/model_adaptive.hpp"
#include "osteomill/control/model_predictive.hpp"
#include "osteomill/control/plant.hpp"
#include "osteomill/control/sugita_loop.hpp"

namespace osteomill::control {

/// The programmed feed, or one that replaces it.
struct ConstantFeed {
  std::optional<double> feed;  ///< m/s
};

/// What stands between the law and the machine. Rapids have the machine's own speed, which neither
/// the law nor `lowest` and `highest` change; the entry into bone and `acceleration` hold for them.
struct FeedLimits {
  double lowest = 0.0;     ///< m/s; above zero the loop cannot stall
  double highest = 12e-3;  ///< m/s
  double acceleration = std::numeric_limits<double>::infinity();  ///< of the command, m/s²
};

/// Slow to the entry feed before the predicted contact and hold it until the cutter is engaged.
/// [sugita2009] section III.B: full feed in air, "decreased to a set value before the actual bone
/// cutting starts". How long it is held is not printed.
struct PredictiveMode {
  double entry_feed = 3e-3;  ///< m/s
  double lead = 1.5e-3;      ///< how far before the predicted contact it starts, m
  double hold = 0.3e-3;      ///< how far past it, m
  double uncertainty = 0.0;  ///< of the predicted contact, m: widens both sides
  /// Hold until the cutter is fully engaged, by more than `hold` where that comes later. Releasing
  /// earlier loses the benefit of a slow entry: the loop answers the small force of a cutter that
  /// is half in bone with more feed.
  bool until_engaged = false;
};

/// A law, its limits and, where the entry into bone is known, the predictive mode.
struct FeedController {
  std::variant<ConstantFeed, SugitaLoop, ModelAdaptive, ModelPredictive> law;
  FeedLimits limits;
  std::optional<PredictiveMode> predictive;
  double period = 10e-3;  ///< between two commands, s
};

/// Throws InvalidInput that names the field, when the values do not make a controller.
void check(const FeedController& controller);

/// Everything that the controller remembers; a value, so that a record of it replays.
struct ControllerState {
  double feed = 0.0;  ///< last command, limits applied: so the accumulator cannot wind up, m/s
  SugitaState sugita;
  ModelAdaptiveState model;
  ModelPredictiveState predictive;
};

struct ControlStep {
  ControllerState state;
  FeedCommand command;
};

/// One control period: compute, limit, limit the rate, check that all is finite. A pure function of
/// its arguments; no heap, lock, log or throw. An observation that is not finite gives feed zero in
/// mode `stopped` and leaves the taps as they were.
ControlStep step(const FeedController& controller, const ControllerState& state,
                 const Observation& seen) noexcept;

/// Largest feed that the predictive mode allows here; infinite outside its zone.
double entry_limit(const PredictiveMode& mode, const Observation& seen) noexcept;

}  // namespace osteomill::control
