// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "osteomill/base/random.hpp"
#include "osteomill/numerics/revolution_window.hpp"
#include "osteomill/numerics/second_order_lag.hpp"
#include "osteomill/simulate/workpiece.hpp"

namespace osteomill::simulate {

/// A spindle whose speed can be asked for: a first-order lag behind the request.
struct SpindleDrive {
  double lowest = 0.0;         ///< rad/s
  double highest = 0.0;        ///< rad/s
  double time_constant = 0.2;  ///< s
};

/// The machine around the workpiece: spindle, feed servo, force sensor.
struct Machine {
  double spindle_speed = 0.0;                     ///< programmed, rad/s
  std::optional<SpindleDrive> spindle;            ///< none: always the programmed speed
  std::optional<numerics::SecondOrderLag> servo;  ///< none: the feed is the command at once
  double period = 10e-3;                          ///< of control, s
  double sample_rate = 8000.0;                    ///< of the force sensor, 1/s
  double start_feed = 3e-3;                       ///< m/s
  double force_noise = 0.0;  ///< standard deviation on each mean force that is reported, N
  int flutes = 2;            ///< of the cutter: where the tooth line of the spectrum is
  int delay_updates = 1;     ///< control periods from the force to the feed that it sets
  std::uint64_t seed = 1;    ///< of the noise
  /// How far along the path the map lies from the bone: what is predicted of contacts is wrong by
  /// it, m.
  double map_offset = 0.0;
};

/// Throws InvalidInput that names the field.
void check(const Machine& machine);

/// What is asked for in one control period.
struct FeedRequest {
  double feed = 0.0;           ///< m/s
  int mode = 0;                ///< recorded as it is
  bool saturated = false;      ///< recorded as it is
  double spindle_speed = 0.0;  ///< rad/s; 0: the programmed one
  int bound = 0;               ///< recorded as it is
};

/// What the sensor and the machine report at the end of a control period.
struct Report {
  double time = 0.0;
  double position = 0.0;       ///< m along the path
  double feed = 0.0;           ///< m/s
  double spindle_speed = 0.0;  ///< rad/s
  double programmed_feed = 0.0;
  bool rapid = false;       ///< in a move that is no cut
  double mean_force = 0.0;  ///< of the magnitude, over whole revolutions; noise and delay included
  double peak_force = 0.0;  ///< of the same period as mean_force; noise and delay included
  double mean_torque = 0.0;
  double tooth_line = 0.0;       ///< amplitude of the magnitude at the tooth frequency, N
  double revolution_line = 0.0;  ///< at the spindle's frequency, N
  double to_contact = 0.0;
  double to_engagement = 0.0;
  double temperature = 0.0;     ///< see Workpiece
  double no_go_distance = 0.0;  ///< m; infinite when there is no region
  bool finished = false;
};

/// One control period as it was, without noise and delay. Times and places are those of its end.
struct Step {
  double time = 0.0;      ///< s
  double position = 0.0;  ///< m along the path
  int line = 0;           ///< from 0
  geometry::Vector3 tip_W = geometry::Vector3::Zero();
  geometry::Vector3 axis_W = geometry::Vector3::UnitZ();       ///< of the tool
  double command = 0.0;                                        ///< m/s
  double feed = 0.0;                                           ///< at the end, m/s
  double spindle_speed = 0.0;                                  ///< at the end, rad/s
  geometry::Vector3 mean_force_W = geometry::Vector3::Zero();  ///< on the tool, over the period, N
  double mean_force = 0.0;        ///< mean of the magnitude over the sensor's window, N
  double peak_force = 0.0;        ///< largest magnitude, N
  double mean_torque = 0.0;       ///< N m
  double removed_volume = 0.0;    ///< in this period, m³
  double contact_length = 0.0;    ///< of the edges in bone at its end, m; see Cut
  double material = 0.0;          ///< see Workpiece::material_key
  double feed_work = 0.0;         ///< - integral of F · v dt of this period, J
  double spindle_work = 0.0;      ///< integral of torque × speed of this period, J
  double time_above_limit = 0.0;  ///< in this period, s
  double sum_force = 0.0;         ///< of the magnitude over the samples in contact, N
  int samples_in_contact = 0;
  double first_contact = 0.0;  ///< time of the first and the last sample in contact, s;
  double last_contact = 0.0;   ///< meaningful when samples_in_contact > 0
  int mode = 0;
  bool saturated = false;
  int bound = 0;             ///< of FeedRequest
  double temperature = 0.0;  ///< at the end, of Workpiece, K; 0: not worked out
  bool rapid = false;        ///< the tool ends in a move that is no cut

  /// See base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(time, position, line, tip_W, axis_W, command, feed, spindle_speed, mean_force_W, mean_force,
      peak_force, mean_torque, removed_volume, contact_length, material, feed_work, spindle_work,
      time_above_limit, sum_force, samples_in_contact, first_contact, last_contact, mode, saturated,
      bound, temperature, rapid);
  }
};

/// A workpiece being milled in time. It is advanced one control period at a time with the feed that
/// is asked for; the servo is stepped exactly between the samples of the force sensor. Or a machine
/// moves: then `follow` plays what it did, piece by piece, and `end_period` closes the period.
class Milling {
 public:
  /// `force_limit`: what Step::time_above_limit counts against, N.
  Milling(Workpiece& workpiece, const Machine& machine, double force_limit);

  Report report() const;
  /// What of a report is known beforehand at a place along the path, m: the programmed feed and
  /// where contact is expected. Reads the workpiece's plan only: may be asked while another thread
  /// mills.
  Report plan_at(double position) const;
  Report advance(const FeedRequest& request);
  /// The machine is found at a place along the path, m, before anything is followed.
  void start_at(double position) { state_.integral = position; }
  /// Plays a piece of motion, sampled at the sensor's rate: places along the path, m, and feeds,
  /// m/s. A piece is at most a control period long.
  const Cut& follow(std::span<const double> positions, std::span<const double> feeds);
  /// A control period of motion has been followed; `request` is what was asked for in it.
  Report end_period(const FeedRequest& request);
  bool finished() const { return state_.integral >= length_; }
  /// What the tool met in the last piece that was followed.
  const Cut& last_cut() const { return cut_; }
  const std::vector<Step>& steps() const { return steps_; }

  /// Everything between two control periods but for the workpiece; see base/archive.hpp.
  template <class Archive>
  void exchange(Archive& a) {
    a(state_, angle_, spindle_speed_, noise_, window_, reported_, steps_);
  }

 private:
  Workpiece& workpiece_;
  Machine machine_;
  double force_limit_ = 0.0;
  double length_ = 0.0;
  std::optional<numerics::HeldLag> servo_;
  numerics::LagState state_;    ///< integral: position along the path
  double angle_ = 0.0;          ///< of the spindle, rad
  double spindle_speed_ = 0.0;  ///< rad/s
  Random noise_;
  std::vector<double> positions_, feeds_, angles_;  ///< of the samples of a period
  Cut cut_;
  Step open_;               ///< the period that is not over yet
  double opened_at_ = 0.0;  ///< place along the path, m
  int followed_ = 0;        ///< samples of it so far
  int pieces_in_bone_ = 0;
  numerics::RevolutionWindow window_;  ///< last magnitudes
  struct Reading {
    double mean = 0.0;
    double peak = 0.0;
  };
  std::vector<Reading> reported_;  ///< with noise, newest first, delay_updates of them
  std::vector<Step> steps_;
};

}  // namespace osteomill::simulate
