// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "osteomill/identify/instantaneous.hpp"
#include "osteomill/identify/rotation.hpp"
#include "osteomill/identify/signal_chain.hpp"

/// From a processed record to a fit over its revolutions.
namespace osteomill::identify {

/// Averages of all whole revolutions in bins of the angle, and of groups of consecutive
/// revolutions, at most `groups`, for the scatter. What a group has no sample of counts as the
/// average.
/// @param bins  0: as many as there are samples in a revolution, at most 120
/// Throws InvalidInput for less than two revolutions.
RevolutionForces gather_revolutions(const Eigen::MatrixX3d& force, const Rotation& rotation,
                                    int bins = 0, int groups = 64);

/// What a zero-phase filter leaves of each harmonic of the rotation, up to where it leaves less
/// than `least` or the rate ends.
std::vector<double> filter_gains(const Butterworth& filter, double rate, double spindle_speed,
                                 double least = 1e-3);

/// The instantaneous method on the plateau of a processed record: gathers its revolutions, treats
/// the model by the chain's filter, and lets each component have the constant that the baseline may
/// have left. `options.harmonic_gains` and `options.offset_deviation` are worked out here.
/// Throws InvalidInput when the chain found no rotation or averaged the flutes.
InstantaneousFit fit_processed(const ProcessedRecord& processed, const SignalChain& chain,
                               const cutting::Cutter& cutter, const cutting::Condition& condition,
                               const cutting::Immersion& immersion,
                               InstantaneousOptions options = {});

}  // namespace osteomill::identify
