// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/signal_chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/identify/record_check.hpp"

namespace osteomill::identify {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

std::string seconds(const Segment& s, double rate) {
  return fmt::format("{:.3f} … {:.3f} s", static_cast<double>(s.begin) / rate,
                     static_cast<double>(s.end) / rate);
}

void find_segments(ProcessedRecord& out, const CutOfRecord& cut, const SignalChain& chain) {
  SegmentOptions options = chain.segments;
  if (options.window <= 0.0) {
    // Three revolutions, in which a force that repeats has one level; no more than a tenth.
    options.window = cut.spindle_speed > 0.0 ? std::max(0.02, 3.0 * kTurn / cut.spindle_speed)
                                             : SegmentOptions{}.window;
    options.window = std::min(options.window, 0.1 * duration(out.record));
  }
  out.segments = segment(out.record, options);
  const Segmentation& found = out.segments;
  if (found.whole) {
    out.steps.push_back("segments: no idle part, the whole record is taken for the cut");
  } else {
    out.steps.push_back(fmt::format(
        "segments: {} cut{}, {:.3g} N rms in the cut and {:.3g} N outside (window {:.3g} s)",
        found.cuts.size(), found.cuts.size() == 1 ? "" : "s", found.cut_level, found.idle_level,
        options.window));
  }
  out.steps.push_back(fmt::format("plateau{}: {}",
                                  options.plateau ? " as given" : " of the longest cut",
                                  seconds(found.plateau, out.record.rate)));
  if (found.steady < 0.9) {
    out.warnings.push_back(fmt::format(
        "only {:.0f} % of the plateau is within {:.0f} % of its median level: the cut is not "
        "steady",
        100.0 * found.steady, 100.0 * options.settle_band));
  }
}

void take_baseline(ProcessedRecord& out, const SignalChain& chain) {
  if (chain.baseline == BaselineKind::none) return;
  out.baseline = remove_baseline(out.record, out.segments.idle, chain.baseline);
  const Eigen::Vector3d& a = out.baseline.first;
  const Eigen::Vector3d& b = out.baseline.last;
  if (chain.baseline == BaselineKind::tare) {
    const Eigen::RowVector3d offset = out.baseline.offset.row(0);
    out.steps.push_back(fmt::format("tare: ({:.3g}, {:.3g}, {:.3g}) N, mean of the idle parts",
                                    offset[0], offset[1], offset[2]));
  } else {
    out.steps.push_back(fmt::format(
        "drift: straight from ({:.3g}, {:.3g}, {:.3g}) N before to ({:.3g}, {:.3g}, {:.3g}) N "
        "behind the cut",
        a[0], a[1], a[2], b[0], b[1], b[2]));
  }
}

void filter(ProcessedRecord& out, const CutOfRecord& cut, const SignalChain& chain) {
  if (chain.filter_order == 0) return;
  const double line = cut.flutes * cut.spindle_speed / kTurn;
  const double cutoff = cutoff_of(chain, cut);
  out.record.force =
      zero_phase(design({.order = chain.filter_order, .cutoff_hz = cutoff}, out.record.rate),
                 out.record.force);
  out.steps.push_back(
      fmt::format("filter: zero-phase Butterworth, order {} forward and backward, {:.5g} Hz{}",
                  chain.filter_order, cutoff,
                  line > 0.0 ? fmt::format(" = {:.3g} × tooth passing", cutoff / line) : ""));
}

std::optional<Rotation> find_rotation(const ForceRecord& plateau, const CutOfRecord& cut,
                                      const SignalChain& chain,
                                      std::vector<std::string>& warnings) {
  switch (chain.rotation) {
    case RotationSource::none:
      return {};
    case RotationSource::tacho:
      return rotation_from_tacho(plateau.tacho, plateau.rate);
    case RotationSource::line:
      return rotation_from_line(plateau, cut.spindle_speed, cut.flutes, chain.line);
    case RotationSource::speed:
      return rotation_of_speed(plateau.force.rows(), plateau.rate, cut.spindle_speed);
    case RotationSource::automatic:
      break;
  }
  if (plateau.tacho.size() > 0) return rotation_from_tacho(plateau.tacho, plateau.rate);
  if (!(cut.spindle_speed > 0.0)) return {};
  try {
    return rotation_from_line(plateau, cut.spindle_speed, cut.flutes, chain.line);
  } catch (const InvalidInput& none) {
    warnings.push_back(fmt::format("no mean revolution: {}", none.faults().front().rule));
    return {};
  }
}

void rotate(ProcessedRecord& out, const ForceRecord& plateau, const CutOfRecord& cut,
            const SignalChain& chain) {
  out.rotation = find_rotation(plateau, cut, chain, out.warnings);
  if (!out.rotation) return;
  const Rotation& rotation = *out.rotation;
  out.steps.push_back(fmt::format(
      "rotation: {:.2f} rpm (standard deviation {:.2f} rpm), {}",
      rotation.spindle_speed / units::rpm, rotation.speed_deviation / units::rpm,
      rotation.absolute ? "from the pulse"
                        : (chain.rotation == RotationSource::speed
                               ? "as stated; the angle begins with the plateau"
                               : "from the tooth-passing line; which tooth is not known")));
  if (cut.spindle_speed > 0.0 &&
      std::abs(rotation.spindle_speed / cut.spindle_speed - 1.0) > 0.05) {
    out.warnings.push_back(fmt::format(
        "the spindle turned with {:.1f} rpm, not with {:.1f} rpm: the sampling rate or the speed "
        "is not as stated",
        rotation.spindle_speed / units::rpm, cut.spindle_speed / units::rpm));
  }
  out.revolution = chain.average_flutes
                       ? average_pitch(plateau.force, rotation, cut.flutes, chain.bins)
                       : average_revolution(plateau.force, rotation, chain.bins);
  out.steps.push_back(fmt::format(
      "mean revolution: {} revolutions in {} bins{}", out.revolution->revolutions,
      out.revolution->angle.size(),
      chain.average_flutes ? fmt::format(", averaged over {} flutes", cut.flutes) : ""));
  out.harmonics = rotation_harmonics(plateau.force, rotation, 3 * cut.flutes);
  double teeth = 0.0, run_out = 0.0;
  for (const RotationHarmonic& harmonic : out.harmonics) {
    double& larger = harmonic.order % cut.flutes == 0 ? teeth : run_out;
    larger = std::max(larger, harmonic.amplitude.norm());
  }
  out.run_out_ratio = teeth > 0.0 ? run_out / teeth : 0.0;
  if (cut.flutes > 1) {
    out.steps.push_back(fmt::format(
        "run-out: the largest line beside the tooth passing is {:.1f} % of the tooth passing "
        "({:.3g} N of {:.3g} N)",
        100.0 * out.run_out_ratio, run_out, teeth));
  }
}

}  // namespace

double cutoff_of(const SignalChain& chain, const CutOfRecord& cut) {
  return chain.cutoff_hz > 0.0
             ? chain.cutoff_hz
             : chain.cutoff_over_tooth_passing * cut.flutes * cut.spindle_speed / kTurn;
}

ProcessedRecord process(const ForceRecord& record, const CutOfRecord& cut,
                        const SignalChain& chain) {
  require_within("cutter.flutes", cut.flutes, 1, 64, "");
  ProcessedRecord out;
  out.warnings = sampling_warnings(record.rate, cut.spindle_speed, cut.flutes);
  if (chain.dynamometer) {
    out.record = compensate(record, *chain.dynamometer, chain.compensation);
    out.steps.push_back(fmt::format(
        "dynamometer: inverse of the measured response up to {:.5g} Hz, noise floor {:g}",
        chain.compensation.highest_hz > 0.0 ? chain.compensation.highest_hz
                                            : chain.dynamometer->frequency_hz.back(),
        chain.compensation.noise_floor));
  } else {
    out.record = record;
  }
  find_segments(out, cut, chain);
  take_baseline(out, chain);
  filter(out, cut, chain);
  const ForceRecord plateau = cut_out(out.record, out.segments.plateau);
  if (chain.envelope) {
    for (int axis = 0; axis < 3; ++axis)
      out.envelope.push_back(analytic_envelope(plateau.force.col(axis)));
    out.steps.push_back("envelope: mean ± magnitude of the analytic signal");
  }
  rotate(out, plateau, cut, chain);
  const double speed = out.rotation ? out.rotation->spindle_speed : cut.spindle_speed;
  const double period = speed > 0.0 ? kTurn / speed : 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    PlateauMean& mean = out.mean[static_cast<std::size_t>(axis)];
    mean = plateau_mean(plateau.force.col(axis), plateau.rate, period);
    const double change = mean.slope * duration(plateau);
    if (std::abs(mean.slope) > 3.0 * mean.slope_standard_error &&
        std::abs(change) > 0.1 * std::abs(mean.mean)) {
      out.warnings.push_back(
          fmt::format("F{} goes by {:.3g} N along the plateau, whose mean is {:.3g} N", "xyz"[axis],
                      change, mean.mean));
    }
  }
  out.steps.push_back(fmt::format("mean: regression on time through {} means of {}",
                                  out.mean[0].batches,
                                  period > 0.0 ? "one revolution each" : "equal pieces"));
  return out;
}

geometry::Vector3 baseline_deviation(const ProcessedRecord& processed, BaselineKind kind) {
  geometry::Vector3 deviation = geometry::Vector3::Zero();
  if (kind == BaselineKind::none || processed.segments.idle.empty()) return deviation;
  const std::vector<Segment>& idle = processed.segments.idle;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto error_of = [&](const Segment& part) {
      return plateau_mean(processed.record.force.col(axis).segment(part.begin, part.size()),
                          processed.record.rate, 0.0)
          .standard_error;
    };
    if (kind == BaselineKind::drift) {
      // The middle of a straight line has half of each end's error.
      deviation[axis] = 0.5 * std::hypot(error_of(idle.front()), error_of(idle.back()));
      continue;
    }
    double sum = 0.0;
    double samples = 0.0;
    for (const Segment& part : idle) {
      const auto size = static_cast<double>(part.size());
      sum += std::pow(size * error_of(part), 2);
      samples += size;
    }
    deviation[axis] = std::sqrt(sum) / samples;
  }
  return deviation;
}

void take_means(const ProcessedRecord& processed, BaselineKind kind, Experiment& experiment) {
  const geometry::Vector3 baseline = baseline_deviation(processed, kind);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const PlateauMean& mean = processed.mean[static_cast<std::size_t>(axis)];
    experiment.mean_force[axis] = mean.mean;
    experiment.standard_error[axis] = std::hypot(mean.standard_error, baseline[axis]);
  }
}

}  // namespace osteomill::identify
