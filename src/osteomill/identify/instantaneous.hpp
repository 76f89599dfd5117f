// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/geometry/pose.hpp"
#include "osteomill/identify/edge_columns.hpp"

namespace osteomill::identify {

/// Forces over one revolution, the average of many: what a fit over whole revolutions reads.
struct RevolutionForces {
  std::vector<double> angle;  ///< from the index of the rotation, rad, within a turn
  Eigen::MatrixX3d mean;      ///< one row an angle, in T, N
  /// Every revolution (row), or group of them in the order of time: x at all angles, then y, then
  /// z, N. Tells what noise the mean has; empty when only the mean is known.
  Eigen::MatrixXd each;
  /// Width of angle that each value is the mean over, rad; the model is averaged alike.
  double width = 0.0;
};

/// Where a search may begin: what another cut of the same clamping had, the index of the rotation
/// being the same place of the spindle.
struct InstantaneousStart {
  cutting::RunOut run_out;
  double phase = 0.0;  ///< rad
};

struct InstantaneousOptions {
  std::vector<UnitForce> units = linear_law_units();
  bool run_out = true;  ///< offset of the axis and its direction are unknown
  bool tilt = false;    ///< and so is a lean
  /// Rotation angle, from the index, at which flute 0's tip points along +y, rad; unset: unknown.
  std::optional<double> phase;
  /// Standard deviation of a constant that tare, gravity and drift may have left in each component,
  /// N: an unknown with this much known of it. 0: none is left.
  geometry::Vector3 offset_deviation = geometry::Vector3::Zero();
  /// What filter and averaging left of the harmonics of the rotation, 0 first; the model's forces
  /// are treated alike. Empty: all of each.
  std::vector<double> harmonic_gains;
  /// Begins there in place of searching over phases and directions; where the residuals say that
  /// it led astray, the search is done all the same.
  std::optional<InstantaneousStart> start = {};
  int max_iterations = 60;
  double confidence = 0.95;  ///< of the intervals
};

enum class FitStatus { not_run, converged, iteration_limit };

/// An unknown with what the data say about it.
struct Estimate {
  std::string name;  ///< "Ktc" (Pa), "Kte" (N/m), "run_out_x" (m), "phase" (rad), "offset_x" (N)
  double value = 0.0;
  double standard_error = 0.0;
  double low = 0.0;  ///< of the interval at `confidence`
  double high = 0.0;
  /// false: other values fit the data as well; value is one of them, without error or interval.
  bool determined = true;
  /// An exponent that stands where the law ends: the data would go beyond.
  bool at_limit = false;
};

struct InstantaneousFit {
  FitStatus status = FitStatus::not_run;
  int iterations = 0;
  std::vector<UnitForce> units;  ///< that were fitted
  /// Units in their order, then their exponents, run_out_x, run_out_y (offset times cosine and sine
  /// of its angle), tilt_x, tilt_y, phase, offset_x, offset_y, offset_z as far as they are unknown.
  std::vector<Estimate> estimates;
  Eigen::MatrixXd covariance;       ///< of the estimates in their order
  double degrees_of_freedom = 0.0;  ///< of the intervals
  double condition_number = 0.0;    ///< of the Jacobian, its columns scaled to unit length
  cutting::RunOut run_out;          ///< of the cutter as fitted
  double phase = 0.0;               ///< rad, within a pitch where flutes are alike
  Eigen::MatrixX3d fitted;          ///< forces of the model at the angles, N
  geometry::Vector3 residual_rms = geometry::Vector3::Zero();  ///< N
  /// What the scatter from revolution to revolution explains of it, N; zero when not known.
  geometry::Vector3 noise_rms = geometry::Vector3::Zero();
  /// How many independent values the averaged forces are worth, of three for each angle.
  double effective_values = 0.0;
  std::vector<std::string> verdict;  ///< what the data cannot say, in sentences
};

/// Coefficients, run-out and phase from the forces over whole revolutions.
///
/// Given run-out, phase and exponents the forces are linear in the coefficients, so these are
/// eliminated (variable projection, [golub1973]; steps as [kaufman1975] simplified them) and the
/// search runs over run-out, phase and exponents alone, from several starts. A component of a power
/// or log law that would be negative is left out and said so. Standard errors come from the scatter
/// between groups of revolutions, which sees every correlation within them: of neighbouring angles
/// after a filter, of the components, of vibration. A misfit beyond that scatter widens them as if
/// it were noise with the correlation of the residuals.
///
/// Throws InvalidInput when there are fewer values than unknowns or forces are not finite.
InstantaneousFit fit_instantaneous(const RevolutionForces& forces, const cutting::Cutter& cutter,
                                   const cutting::Condition& condition,
                                   const cutting::Immersion& immersion,
                                   const InstantaneousOptions& options = {});

/// What the data do not determine, what cannot be told from zero or apart, and whether the model
/// misses more than noise explains, in sentences.
std::vector<std::string> verdict_of(const InstantaneousFit& fit, double confidence);

}  // namespace osteomill::identify
