// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>

namespace osteomill::control {

/// What is known at the end of a control period. The machine and the sensor give it, or a
/// simulation or a recording of them.
struct Observation {
  double time = 0.0;             ///< since the start, s
  double position = 0.0;         ///< along the path, m
  double feed = 0.0;             ///< at the end of the period, m/s
  double spindle_speed = 0.0;    ///< rad/s; 0: not known
  double programmed_feed = 0.0;  ///< what the path asks for here, m/s
  bool rapid = false;            ///< a move through air at the machine's own speed, programmed_feed
  double mean_force = 0.0;       ///< mean of the sampled magnitude over whole revolutions, N
  double peak_force = 0.0;       ///< largest sampled magnitude of the period, N
  double mean_torque = 0.0;      ///< N m
  double tooth_line = 0.0;       ///< amplitude of the magnitude at the tooth frequency, N
  double revolution_line = 0.0;  ///< at the spindle's frequency, N
  double sample_time = 0.0;      ///< of the newest sample, s
  /// Along the path to the nearest predicted entry into bone, m: positive before it, negative past
  /// it until the next entry is nearer; infinite when none is predicted.
  double to_contact = std::numeric_limits<double>::infinity();
  /// The same to where the cutter is fully engaged there.
  double to_engagement = std::numeric_limits<double>::infinity();
  double temperature = 0.0;  ///< of the hottest bone now that stays, K; 0: not known
  /// From the tool to the nearest no-go region, m; infinite when there is none.
  double no_go_distance = std::numeric_limits<double>::infinity();
  bool finished = false;  ///< the path has come to its end
};

/// Which rule set the feed.
enum class Mode : std::uint8_t {
  constant,    ///< the programmed feed
  adaptive,    ///< the force loop
  predictive,  ///< the limit before and at the entry into bone
  stopped,     ///< no valid input: feed zero
};

const char* name(Mode mode);

/// Which limit a law that plans keeps to with its command.
enum class Bound : std::uint8_t {
  none,  ///< none of these: the law knows no limits, or is on its way to one
  largest_feed,
  force,
  deflection,
  feed_per_tooth,
  temperature,  ///< by less reserve of force than otherwise, or by the speed of the spindle
  chatter       ///< by the speed of the spindle
};
inline constexpr int kBounds = 7;

const char* name(Bound bound);

struct FeedCommand {
  double feed = 0.0;  ///< m/s
  Mode mode = Mode::stopped;
  bool saturated = false;      ///< the law asks for no less than the largest feed
  double spindle_speed = 0.0;  ///< rad/s; 0: the programmed one
  Bound bound = Bound::none;
};

/// What a controller acts on: a simulation, a recording or a machine.
class Plant {
 public:
  virtual ~Plant() = default;
  /// What is known before the first command.
  virtual Observation start() = 0;
  /// Holds the command for one control period and says what is known at its end.
  virtual Observation advance(const FeedCommand& command) = 0;
};

}  // namespace osteomill::control
