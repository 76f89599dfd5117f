// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/identify/baseline.hpp"
#include "osteomill/identify/dynamometer.hpp"
#include "osteomill/identify/envelope.hpp"
#include "osteomill/identify/experiment.hpp"
#include "osteomill/identify/filter.hpp"
#include "osteomill/identify/force_record.hpp"
#include "osteomill/identify/plateau_mean.hpp"
#include "osteomill/identify/revolution.hpp"
#include "osteomill/identify/rotation.hpp"
#include "osteomill/identify/segments.hpp"

/// From a record to what identification needs: plateau, mean force with its error, and the mean
/// revolution. Each step is optional and leaves a line in `steps`.
namespace osteomill::identify {

enum class RotationSource {
  none,
  tacho,      ///< pulse of the record
  line,       ///< tooth-passing line
  speed,      ///< the nominal speed, taken as exact
  automatic,  ///< the pulse where there is one, otherwise the line
};

/// What is done to a record, in this order: compensation, segmentation and baseline, filter,
/// plateau, envelope, mean, rotation, mean revolution.
struct SignalChain {
  std::optional<DynamometerResponse> dynamometer = {};
  CompensationOptions compensation = {};

  SegmentOptions segments{.window = 0.0};  ///< window 0: three revolutions
  BaselineKind baseline = BaselineKind::none;

  int filter_order = 0;    ///< 0: no filter
  double cutoff_hz = 0.0;  ///< 0: by cutoff_over_tooth_passing
  double cutoff_over_tooth_passing =
      10.0;  ///< [plaskos2006] §3.3.2: ten for high speeds, low feeds

  bool envelope = false;  ///< of each axis on the plateau, [tian2023] Figure 6(c)

  RotationSource rotation = RotationSource::automatic;
  LineOptions line = {};
  int bins = 0;                 ///< of the mean revolution; 0: by the rate
  bool average_flutes = false;  ///< run-out treatment: mean over the pitch-shifted copies
};

/// What the record was taken at.
struct CutOfRecord {
  double spindle_speed = 0.0;  ///< nominal, rad/s
  int flutes = 1;
};

/// Cut-off frequency of the chain's filter on a cut, Hz.
double cutoff_of(const SignalChain& chain, const CutOfRecord& cut);

struct ProcessedRecord {
  ForceRecord record;  ///< whole length, compensated, without baseline, filtered
  Segmentation segments;
  Baseline baseline;
  std::vector<Envelope> envelope;   ///< of x, y, z on the plateau; empty when not asked for
  std::array<PlateauMean, 3> mean;  ///< of x, y, z on the plateau
  /// Of the samples of the plateau; empty when no rotation was asked for.
  std::optional<Rotation> rotation;
  std::optional<RevolutionAverage> revolution;  ///< over a whole turn, run-out treated if asked for
  std::vector<RotationHarmonic> harmonics;      ///< of the untreated plateau, to 3 N
  /// Largest amplitude of the run-out orders over that of the tooth-passing orders, of |F|.
  double run_out_ratio = 0.0;
  std::vector<std::string> steps;  ///< what was done, in the order it was done
  std::vector<std::string> warnings;
};

/// Runs the chain. Throws InvalidInput where a step cannot be done on this record, and names it.
ProcessedRecord process(const ForceRecord& record, const CutOfRecord& cut,
                        const SignalChain& chain);

/// Standard deviation of what the baseline leaves in each component on the plateau: the errors of
/// the means of the idle parts that it was drawn through; zero when no baseline was taken. Noise of
/// the idle parts is taken to be that of the cut.
geometry::Vector3 baseline_deviation(const ProcessedRecord& processed, BaselineKind kind);

/// The mean forces of the plateau with their standard errors: of the mean along the cut and of the
/// baseline that was taken away.
void take_means(const ProcessedRecord& processed, BaselineKind kind, Experiment& experiment);

}  // namespace osteomill::identify
