// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

/// The local strength of bone while it is cut: how many times the reference law's force it takes.
/// Pure functions of state and sample, without heap or throw, so that a controller may call them in
/// its step. Sample rates from 100 Hz (one mean a control period) up to that of the sensor.
namespace osteomill::identify {

/// What was measured, and what bone of strength 1 would have answered (FeedResponse). Forces in N,
/// or powers in W.
struct OnlineSample {
  double time = 0.0;      ///< s
  double measured = 0.0;  ///< mean since the sample before
  double unit = 0.0;      ///< answer of strength 1 to the feed of that time; 0 in air
};

struct OnlineOptions {
  double noise = 0.5;  ///< standard deviation of a sample that does not grow with it, N or W
  double relative_noise = 0.05;  ///< that grows with it, as a share
  /// How strength wanders: standard deviation of its logarithm after a second. 0.5 is a tenth in
  /// 40 ms.
  double wander = 0.5;
  double offset_wander = 0.05;  ///< of the offset after a second, N or W; EKF
  /// Squared innovation over its variance beyond which the bone is taken to have changed. 9: once
  /// in 370 samples by chance, which costs the memory of a few samples.
  double jump_test = 9.0;
  double jump = 1.4;    ///< deviation of the logarithm that a jump opens: 1.4 is a factor of four
  double memory = 0.1;  ///< time constant of forgetting, s; RLS
  double least_unit = 0.0;  ///< answers below say nothing of the bone, N or W
};

/// Throws InvalidInput that names the field.
void check(const OnlineOptions& options);

struct OnlineEstimate {
  double time = 0.0;            ///< s
  double strength = 1.0;        ///< 1: as the reference law
  double standard_error = 0.0;  ///< of strength
  double offset = 0.0;          ///< what is measured without bone, N or W; EKF
  bool jumped = false;          ///< this sample was taken for a change of bone
  bool informed = false;        ///< some sample has said something of the bone
};

/// Recursive least squares with exponential forgetting of measured = strength × unit: weights fall
/// by e in `memory`, [ljung1999] eqs. 11.12. A jump forgets what was before it.
struct LeastSquaresState {
  double information = 0.0;  ///< sum of weighted unit²/variance
  double moment = 0.0;       ///< of unit × measured/variance
  double squares = 0.0;      ///< of the weights squared: what the estimate scatters by
  OnlineEstimate last;
};
LeastSquaresState update(const LeastSquaresState& state, const OnlineSample& sample,
                         const OnlineOptions& options) noexcept;

/// Extended Kalman filter of the logarithm of strength, which so stays positive, and the offset:
///   measured = offset + exp(q) unit,
/// both random walks, the noise's variance noise² + (relative_noise exp(q) unit)². The measurement
/// is linearised where its own correction lands, by iteration (iterated EKF, [bell1993]); a jump of
/// the innovation opens the variance of q. In air the offset is learned, in bone the strength.
struct KalmanState {
  double q = 0.0;
  double offset = 0.0;
  double var_q = 1.0;  ///< factor e either way
  double cov = 0.0;
  double var_offset = 0.0;
  OnlineEstimate last;
};
/// Before the first sample. @param offset_deviation what is not known of the offset, N or W
KalmanState first_state(double offset, double offset_deviation) noexcept;
KalmanState update(const KalmanState& state, const OnlineSample& sample,
                   const OnlineOptions& options) noexcept;

/// What the spindle's drive takes: electric = idle + cutting/efficiency, [plaskos2006] §6.2.1 with
/// the losses written out.
struct PowerModel {
  double idle = 0.0;            ///< W, turning in air
  double idle_deviation = 0.0;  ///< what is not known of it, W; learned in air
  double efficiency = 1.0;      ///< of the motor, 0...1
};
void check(const PowerModel& model);

}  // namespace osteomill::identify
