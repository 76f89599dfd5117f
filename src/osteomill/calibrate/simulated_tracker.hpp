// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "osteomill/base/random.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/calibrate/guide_calibration.hpp"

namespace osteomill::calibrate {

/// Noise of one camera reading, per coordinate. [plaskos2006] 4.3.4: 0.46 mm and 0.713° SD.
struct TrackerNoise {
  double position = 0.46 * units::mm;
  double rotation = 0.713 * units::deg;
};

/// What goes wrong while recording; a stop is counted P1, P2, P3, A1..., A2... from 0.
struct SimulatedFaults {
  std::optional<std::size_t> reference_moves_at;
  Pose reference_shift = Pose::Identity();
  std::optional<std::size_t> brake_slips_at;
  int slipping_axis = 1;  ///< 1 or 2
  double slip = 0.0;      ///< rad
  std::optional<std::size_t> hidden_at;
  double hidden_share = 0.0;  ///< of the readings at that stop
  std::optional<std::size_t> disturbed_at;
  Pose disturbance = Pose::Identity();  ///< of the reading of G at that stop
};

/// A robot and a tracker with known truth. [plaskos2006] 5.6; sensors 2.0° and 4.1° SD (4.3.5).
struct SimulatedRobot {
  GuideModel truth;  ///< its reference readings are those of P1
  TrackerNoise tracker;
  Halls hall_sd = {2.0 * units::deg, 4.1 * units::deg};  ///< rad of the motor
  int samples = 30;
  double step = 10.0 * units::deg;
  double range1 = 100.0 * units::deg;  ///< P3 to P2
  double range2 = 120.0 * units::deg;
  double start2 = 70.0 * units::deg;  ///< of the sweep of A2, from P1
};

/// A plausible robot on the medial side of the knee, gear 100:1.
SimulatedRobot simulated_robot();

/// Plays the whole procedure. The same random stream gives the same record.
GuideRecord play_procedure(const SimulatedRobot& robot, Random& random,
                           const SimulatedFaults& faults = {});

/// Readings of a body that stands still.
std::vector<PoseSample> readings(const Pose& X_FG, const TrackerNoise& noise, int count,
                                 Random& random);

}  // namespace osteomill::calibrate
