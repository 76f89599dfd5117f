// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "osteomill/control/plant.hpp"
#include "osteomill/identify/online.hpp"
#include "osteomill/numerics/second_order_lag.hpp"

namespace osteomill::control {

/// What a map of the bone promises along the path, before it is cut: force = edge + gain v at the
/// programmed spindle speed, at places `spacing` apart from the start of the path.
struct Forecast {
  double spacing = 0.1e-3;         ///< m
  std::vector<double> gains;       ///< of the mean force, N/(m/s)
  std::vector<double> edges;       ///< of the mean force, N
  std::vector<double> peak_gains;  ///< of the largest sample
  std::vector<double> peak_edges;

  /// How much hotter than the body the hottest bone is while the tool is there, K: at two feeds,
  /// and at the faster one with another spindle speed. Empty: not known, and of `spun` no other
  /// speed.
  struct Heat {
    double slow_feed = 0.0;   ///< m/s
    double fast_feed = 0.0;   ///< m/s
    double spun_speed = 0.0;  ///< rad/s
    std::vector<double> slow, fast, spun;
  };
  Heat heat = {};
};

/// How far the map is to be believed.
struct MapTrust {
  double position_error = 0.0;  ///< the bone is somewhere within +- this along the path, m
  double gain_error = 0.1;      ///< standard deviation of its gain, relative
  double correlation = 1.5e-3;  ///< along the path, over which that error falls to 1/e, m
};

/// What must hold, whichever comes first. None of them: infinite.
struct PlanLimits {
  double force = 30.0;  ///< on the largest sample, N
  /// The force that bends the tip as far as it may: stiffness times deflection, N.
  double force_of_deflection = std::numeric_limits<double>::infinity();
  double feed_per_tooth = std::numeric_limits<double>::infinity();  ///< m
  double temperature = std::numeric_limits<double>::infinity();     ///< of the hottest bone, K
  double body_temperature = 310.15;                                 ///< K
};

/// Spindle speeds that may be asked for, rad/s.
struct SpindleHandle {
  double lowest = 0.0;
  double highest = 0.0;
  double time_constant = 0.2;  ///< s, of the drive
};

/// Depth at which the cut begins to chatter at a spindle speed, in bone of ChatterLimits::gain.
struct StableDepth {
  double spindle_speed = 0.0;  ///< rad/s
  double depth = 0.0;          ///< m
};

/// The stable depth goes with one over the cutting gain, as it does in the linear theory; so a cut
/// is stable where its gain is small enough, whatever its own depth.
struct ChatterLimits {
  std::vector<StableDepth> lobes;  ///< by rising speed, linear between; none: no limit
  double gain = 0.0;               ///< of the bone that they hold for, cut `depth` deep, N/(m/s)
  double depth = 0.0;              ///< m
  double margin = 1.2;             ///< stable depth over depth of the cut
};

struct ModelPredictiveOptions {
  PlanLimits limits;
  MapTrust map;
  double margin = 0.92;        ///< share of the force or deflection limit that is aimed at
  double confidence = 1.5;     ///< standard errors that are added to the strength of the bone
  double floor_feed = 0.4e-3;  ///< never slower: the loop cannot stall, m/s
  numerics::SecondOrderLag servo{118.0, 0.7};
  double period = 10e-3;                 ///< s
  double flutes = 2.0;                   ///< of the cutter
  double spindle_speed = 0.0;            ///< programmed, rad/s; 0: feed per tooth is not limited
  std::optional<SpindleHandle> spindle;  ///< none: the programmed speed
  ChatterLimits chatter;
  /// How much the gain may rise although the map does not show it, relative to itself, per metre;
  /// answered after `reaction_time` and the delay.
  double unforeseen_rise = 0.0;
  double reaction_time = 32e-3;  ///< from a force to the feed that answers it, s
};

/// Throws InvalidInput that names the field.
void check(const ModelPredictiveOptions& options);

/// Control periods of delay that the strength of the bone is found under: it need not be known.
inline constexpr int kLongestDelay = 3;

struct ModelPredictiveState {
  identify::KalmanState strength = identify::first_state(0.0, 0.0);
  /// Least and largest mean force that the map has for the last periods, newest first, N.
  std::array<double, kLongestDelay> least{};
  std::array<double, kLongestDelay> largest{};
  double position = 0.0;       ///< where the last observation was, m
  double spindle_speed = 0.0;  ///< that the tool had last, rad/s
  double warmth = 1.0;         ///< rise of the bone over that of the map, no less than 1
  numerics::LagState servo;    ///< as the model has it
  bool begun = false;
};

/// A law that looks ahead in the map. Each period it
///   1. corrects the map by the strength that the forces show, the part of them that no place
///      within the position error explains;
///   2. takes for every place ahead the worst of the map within the position error, and the
///   strength
///      there: 1 + (s - 1) exp(-d/L) and `confidence` standard errors of a Gauss-Markov error;
///   3. leads the servo to the feed that is allowed here, by no more than the largest command after
///      which a servo that brakes from the next period on stays below the limit of every place that
///      it still comes to. So a limit ahead is met in time, and there is always a command that
///      keeps to it;
///   4. keeps the bone cool by going fast: where a higher feed is cooler, the temperature asks for
///   a
///      least feed, and gets it as far as the force's limit itself allows, without what is kept
///      in reserve below it. Where a higher feed were hotter it would bound the feed from above;
///   5. where the spindle can be set, asks for the least speed that gives the largest feed on the
///      stretch that the drive needs to answer: the chip, and with it the force, goes with feed
///      over speed. Speeds at which the cut would chatter or the bone grow too hot are left out;
///      when none is cool enough the coolest is taken.
/// Not published; compared with [sugita2009] in docs/theory/control.md.
class ModelPredictive {
 public:
  /// Throws InvalidInput when the options do not make a law or the forecast is none.
  ModelPredictive(const ModelPredictiveOptions& options, Forecast forecast);

  struct Step {
    ModelPredictiveState state;
    double wanted = 0.0;         ///< feed that the bone allows where the tool is, m/s
    double command = 0.0;        ///< m/s
    double spindle_speed = 0.0;  ///< rad/s; 0: the programmed one
    Bound bound = Bound::none;
  };
  /// `ceiling`: the largest feed allowed, m/s. `state.servo` is still that before the period.
  Step step(const ModelPredictiveState& state, const Observation& seen,
            double ceiling) const noexcept;
  /// The servo's model after a period with this command.
  numerics::LagState after(const numerics::LagState& servo, double command) const noexcept {
    return lag_.advance(servo, command);
  }
  const ModelPredictiveOptions& options() const { return options_; }
  /// Largest feed at a place along the path, and which limit makes it so.
  struct Allowed {
    double feed = std::numeric_limits<double>::infinity();  ///< m/s
    Bound bound = Bound::none;
  };
  /// `ahead`: of the place, from the tool, m.
  Allowed allowed(const ModelPredictiveState& state, double position, double ahead) const noexcept;
  /// Temperature that the map has for a feed at a place, K; 0: not known.
  double temperature(const ModelPredictiveState& state, double position,
                     double feed) const noexcept;

 private:
  /// Worst and best of the map within the position error.
  struct Place {
    double largest_gain = 0.0;
    double largest_edge = 0.0;
    double least_gain = 0.0;
    double least_edge = 0.0;
    double peak_gain = 0.0;  ///< largest
    double peak_edge = 0.0;
    // Largest rise at Heat::fast_feed; it goes with feed^-slowness and speed^haste.
    double rise = 0.0;
    double slowness = 0.0;
    double haste = 0.0;
  };
  const Place& at(double position) const noexcept;
  /// `bound`: of the first limit that is not kept.
  bool keeps(const ModelPredictiveState& state, double command, double position, double ceiling,
             Bound& bound) const noexcept;
  double lead(const numerics::LagState& servo, double wanted) const noexcept;
  struct Speed {
    double value = 0.0;         ///< rad/s
    Bound bound = Bound::none;  ///< what keeps it from one with a larger feed
  };
  Speed speed(const ModelPredictiveState& state, const Observation& seen,
              double ceiling) const noexcept;
  /// The rise of temperature at a feed, K, with the state's speed.
  double rise(const ModelPredictiveState& state, const Place& place, double feed) const noexcept;
  double rise_allowed() const noexcept;
  double feed_of_rise(const ModelPredictiveState& state, const Place& place) const noexcept;
  /// The largest feed whose peaks stay below `force`.
  double feed_of_force(const Place& place, double strength, double chip,
                       double force) const noexcept;
  /// The largest gain that does not chatter at a speed, N/(m/s).
  double stable_gain(double spindle_speed) const noexcept;
  void learn(ModelPredictiveState& now, const ModelPredictiveState& before,
             const Observation& seen) const noexcept;

  ModelPredictiveOptions options_;
  identify::OnlineOptions tracking_;
  double spacing_ = 0.0;
  double heat_feed_ = 0.0;  ///< of Place::rise, m/s
  std::shared_ptr<const std::vector<Place>> places_;
  numerics::HeldLag lag_;   ///< over a period
  numerics::HeldLag two_;   ///< over two of them
  numerics::HeldLag part_;  ///< over a part of one
};

}  // namespace osteomill::control
