// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "osteomill/identify/instantaneous.hpp"
#include "osteomill/identify/mean_force_fit.hpp"

/// What is known of the run-out that the cuts of mean forces were made with, and what the
/// coefficients owe to it: an edge that is farther in than the others lifts off for part of its
/// turn, and its edge force is missing from the mean.
namespace osteomill::identify {

enum class RunOutSource {
  unknown,  ///< no more than a bound
  stated,   ///< that of the cutters, with a standard error
  records,  ///< found in the revolutions of the same cuts
};

/// One independent error of the run-out: a standard deviation of it, and of whose cutters.
struct RunOutError {
  std::vector<std::size_t> experiments;
  Eigen::Vector2d step = Eigen::Vector2d::Zero();  ///< of offset times cosine and sine, m
};

struct RunOutKnowledge {
  RunOutSource source = RunOutSource::unknown;
  bool one_clamping = true;           ///< the cuts share one run-out
  double offset = 0.0;                ///< m; the mean over the cuts where they differ
  double standard_error = 0.0;        ///< of the offset, m
  std::vector<RunOutError> errors;    ///< stated and records
  double bound = 0.0;                 ///< unknown: the largest it may be, m; 0: nothing is said
  std::vector<std::string> left_out;  ///< cuts whose record does not tell it

  bool operator==(const RunOutKnowledge&) const = default;
};

/// Run-out as the cutters of the experiments have it, with a standard error of each of its two
/// components; unknown where none of them has any and no error is given.
RunOutKnowledge stated_run_out(const std::vector<Experiment>& experiments, double standard_error,
                               double bound);

/// Puts the run-out that the revolutions tell into the cutters. Cuts of one cutter are taken to
/// have been made in one clamping, their run-outs combined by their covariances, when they differ
/// by no more than their errors explain (chi squared, 1 %); otherwise each cut has its own, and
/// cuts that no fit is of keep what their cutter states. Flutes that are alike may be counted from
/// any of them: the run-outs are turned by whole pitches to fit each other.
/// @param fits  with run-out among their unknowns
/// @param of    index of the experiment of each fit
/// Returns unknown where no fit tells a run-out.
RunOutKnowledge run_out_of_records(const std::vector<InstantaneousFit>& fits,
                                   const std::vector<std::size_t>& of,
                                   std::vector<Experiment>& experiments);

/// What the run-out makes of a fit. Where it is known its errors go into the covariance, by fits
/// with each of them added; where it is not, Coefficient::shift_low and shift_high say what the
/// coefficient would change by if the cutters had the bound's run-out in whatever direction, and
/// the intervals hold that as well. Without a bound the shifts are those of `reference_offset`, and
/// the intervals stay.
void allow_for_run_out(const std::vector<Experiment>& experiments, const FitOptions& options,
                       const RunOutKnowledge& known, MeanForceFit& fit);

/// Run-out that the shifts are worked out for where no bound is given, m.
inline constexpr double kReferenceRunOut = 1e-6;

/// What the coefficients would be without run-out, for comparison: the fit with cutters that run
/// true.
MeanForceFit without_run_out(std::vector<Experiment> experiments, const ForceModel& model,
                             const FitOptions& options);

}  // namespace osteomill::identify
