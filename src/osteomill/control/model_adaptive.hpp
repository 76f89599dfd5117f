// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "osteomill/control/plant.hpp"
#include "osteomill/identify/local_gain.hpp"
#include "osteomill/numerics/second_order_lag.hpp"

namespace osteomill::control {

/// What the model-adaptive law takes for granted about machine and bone.
struct ModelAdaptiveOptions {
  double force_limit = 30.0;   ///< on the largest sample, N
  double margin = 0.92;        ///< share of the limit that is aimed at
  double confidence = 1.5;     ///< standard errors that are added to the predicted gain
  double floor_feed = 0.4e-3;  ///< never slower: the loop cannot stall, m/s
  numerics::SecondOrderLag servo{118.0, 0.7};
  double period = 10e-3;  ///< s
  /// How much the gain may rise unforeseen, relative to itself, per metre: a zone 4.4 times as hard
  /// that meets the leading edge of the arc, (4.4 - 1) x 0.88/mm at a_e 1 mm on D 8 mm.
  double hardest_rise = 3000.0;
  double reaction_time = 12e-3;  ///< from a force to the feed that answers it, s, delay not counted
  double slope_length = 1e-3;    ///< over which a slope of the gain persists, m
  double slope_spread = 450.0;   ///< of the relative slope of ordinary bone, 1/m
  double jump_spread = 2000.0;   ///< of the relative slope where a jump was seen, 1/m
  double jump_test = 5.0;        ///< squared innovation over its variance that is called a jump
  double settle =
      1e-3;  ///< past a predicted entry, before the estimate is trusted with more feed, m
};

/// Throws InvalidInput that names the field.
void check(const ModelAdaptiveOptions& options);

/// Control periods of delay that are told apart.
inline constexpr int kDelays = 3;

struct ModelAdaptiveState {
  std::array<identify::GainEstimate, kDelays> estimates{};  ///< one a delay
  std::array<double, kDelays> feeds{};  ///< mean feed of the last periods, newest first, m/s
  double position = 0.0;                ///< where the last observation was, m
  double peak_to_mean = 1.5;
  numerics::LagState servo;  ///< as the model has it
  bool begun = false;
};

/// A law that knows what it acts on. Each period it
///   1. estimates gain and slope under one, two and three periods of delay and takes the likeliest;
///   2. finds the largest feed v that keeps the peak below the limit when the gain ahead is
///      K + S l + z sigma, raised by (1 + hardest_rise v t_r) for what nobody foresees;
///   3. asks the servo for what brings the feed there by the end of the period (lead).
/// Not published; compared with [sugita2009] in docs/theory/control.md.
class ModelAdaptive {
 public:
  explicit ModelAdaptive(const ModelAdaptiveOptions& options);

  struct Step {
    ModelAdaptiveState state;
    double wanted = 0.0;   ///< feed that the bone allows, m/s
    double command = 0.0;  ///< what brings the servo there, m/s
  };
  /// `ceiling`: the largest feed allowed here, m/s. `state.servo` is still that before the period.
  Step step(const ModelAdaptiveState& state, const Observation& seen,
            double ceiling) const noexcept;
  /// The servo's model after a period with this command.
  numerics::LagState after(const numerics::LagState& servo, double command) const noexcept {
    return lag_.advance(servo, command);
  }
  const ModelAdaptiveOptions& options() const { return options_; }

 private:
  double allowed_feed(const identify::GainEstimate& estimate, int delay,
                      const ModelAdaptiveState& state, double ceiling) const noexcept;

  ModelAdaptiveOptions options_;
  identify::LocalGainOptions gain_options_;
  numerics::HeldLag lag_;
};

}  // namespace osteomill::control
