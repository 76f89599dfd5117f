// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/control/feed_controller.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"

namespace osteomill::control {
namespace {

/// What a law asks for: `wanted` is the feed that it finds right, `feed` what it commands for it.
struct Proposal {
  double wanted = 0.0;
  double feed = 0.0;
  Mode mode = Mode::constant;
  double spindle_speed = 0.0;
  Bound bound = Bound::none;
};

/// Updates the law's part of the state. `ceiling`: largest feed allowed here.
Proposal propose(const FeedController& controller, ControllerState& state, const Observation& seen,
                 double ceiling) noexcept {
  if (const SugitaLoop* loop = std::get_if<SugitaLoop>(&controller.law)) {
    const SugitaStep next = step(*loop, state.sugita, state.feed, seen.mean_force);
    state.sugita = next.state;
    return {next.feed, next.feed, Mode::adaptive};
  }
  if (const ModelAdaptive* law = std::get_if<ModelAdaptive>(&controller.law)) {
    // Just past a predicted entry the forces that would tell the gain have not come yet.
    double entry = controller.limits.highest;
    if (controller.predictive && seen.to_contact < 0.0 &&
        seen.to_contact > -law->options().settle - controller.predictive->uncertainty) {
      entry = controller.predictive->entry_feed;
    }
    const ModelAdaptive::Step next = law->step(state.model, seen, std::min(entry, ceiling));
    state.model = next.state;
    return {next.wanted, next.command, Mode::adaptive};
  }
  if (const ModelPredictive* law = std::get_if<ModelPredictive>(&controller.law)) {
    const ModelPredictive::Step next = law->step(state.predictive, seen, controller.limits.highest);
    state.predictive = next.state;
    return {next.wanted, next.command, Mode::adaptive, next.spindle_speed, next.bound};
  }
  const ConstantFeed* constant = std::get_if<ConstantFeed>(&controller.law);
  const double feed = constant->feed.value_or(seen.programmed_feed);
  return {feed, feed, Mode::constant};
}

}  // namespace

const char* name(Mode mode) {
  switch (mode) {
    case Mode::constant:
      return "constant";
    case Mode::adaptive:
      return "adaptive";
    case Mode::predictive:
      return "predictive";
    case Mode::stopped:
      break;
  }
  return "stopped";
}

const char* name(Bound bound) {
  static constexpr std::array<const char*, kBounds> names = {
      "none", "largest feed", "force", "deflection", "feed per tooth", "temperature", "chatter"};
  return names[static_cast<std::size_t>(bound)];
}

void check(const FeedController& controller) {
  const FeedLimits& limits = controller.limits;
  require_positive("limits.max_feed_mm_per_s", limits.highest / units::mm_per_s, "mm/s");
  require_within("limits.min_feed_mm_per_s", limits.lowest / units::mm_per_s, 0.0,
                 limits.highest / units::mm_per_s, "mm/s");
  require_positive("controller.period_ms", controller.period / units::ms, "ms");
  if (!(limits.acceleration > 0.0)) {
    throw InvalidInput(Fault{"limits.max_acceleration_mm_per_s2", "", "must be > 0", ""});
  }
  if (const SugitaLoop* loop = std::get_if<SugitaLoop>(&controller.law)) check(*loop);
  if (const ConstantFeed* constant = std::get_if<ConstantFeed>(&controller.law)) {
    if (constant->feed) {
      require_positive("controller.feed_mm_per_s", *constant->feed / units::mm_per_s, "mm/s");
    }
  }
  if (controller.predictive) {
    const PredictiveMode& mode = *controller.predictive;
    require_positive("controller.entry_feed_mm_per_s", mode.entry_feed / units::mm_per_s, "mm/s");
    require_non_negative("controller.entry_lead_mm", mode.lead / units::mm, "mm");
    require_non_negative("controller.entry_hold_mm", mode.hold / units::mm, "mm");
    require_non_negative("controller.entry_uncertainty_mm", mode.uncertainty / units::mm, "mm");
  }
}

double entry_limit(const PredictiveMode& mode, const Observation& seen) noexcept {
  const bool near = seen.to_contact <= mode.lead + mode.uncertainty;
  const bool held = seen.to_contact >= -(mode.hold + mode.uncertainty);
  const bool engaging = mode.until_engaged && seen.to_engagement >= -mode.uncertainty;
  const bool inside = near && (held || engaging);
  return inside ? mode.entry_feed : std::numeric_limits<double>::infinity();
}

ControlStep step(const FeedController& controller, const ControllerState& state,
                 const Observation& seen) noexcept {
  const FeedLimits& limits = controller.limits;
  const double entry = controller.predictive ? entry_limit(*controller.predictive, seen)
                                             : std::numeric_limits<double>::infinity();
  ControlStep next{state, {}};
  Proposal proposal = propose(controller, next.state, seen, std::min(entry, limits.highest));
  double highest = limits.highest;
  if (seen.rapid) {
    proposal = {seen.programmed_feed, seen.programmed_feed, Mode::constant, proposal.spindle_speed};
    highest = seen.programmed_feed;
  }
  double feed = std::clamp(proposal.feed, std::min(limits.lowest, highest), highest);
  next.command.mode = proposal.mode;
  next.command.spindle_speed = proposal.spindle_speed;
  next.command.bound = proposal.bound;
  next.command.saturated = !seen.rapid && proposal.wanted >= limits.highest;
  if (entry < highest && proposal.wanted >= entry) {
    feed = std::min(feed, entry);
    next.command.mode = Mode::predictive;
    next.command.saturated = false;
    next.command.bound = Bound::none;
  }
  const double largest_change = limits.acceleration * controller.period;
  feed = std::clamp(feed, state.feed - largest_change, state.feed + largest_change);

  // Ways to an entry may be infinite, so only NaN counts against them.
  if (!std::isfinite(feed) || !std::isfinite(seen.mean_force) || std::isnan(seen.to_contact) ||
      std::isnan(seen.to_engagement)) {
    next.command = {};
    next.state = state;
    next.state.feed = 0.0;
    return next;
  }
  next.command.feed = feed;
  next.state.feed = feed;
  if (const ModelAdaptive* law = std::get_if<ModelAdaptive>(&controller.law)) {
    next.state.model.servo = law->after(next.state.model.servo, feed);
  }
  if (const ModelPredictive* law = std::get_if<ModelPredictive>(&controller.law)) {
    next.state.predictive.servo = law->after(next.state.predictive.servo, feed);
  }
  return next;
}

}  // namespace osteomill::control
