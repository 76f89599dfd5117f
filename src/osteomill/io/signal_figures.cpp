// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/signal_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "osteomill/base/units.hpp"
#include "osteomill/identify/envelope.hpp"
#include "osteomill/identify/fourier.hpp"

namespace osteomill::io {
namespace {

using identify::ForceRecord;
using identify::ProcessedRecord;
using identify::Segment;

constexpr Eigen::Index kPoints = 2000;  // of a curve; a picture has no more columns
constexpr const char* kAxes[] = {"x", "y", "z"};

/// A stretch of a signal over time; of long ones the smallest and the largest of each piece.
Series thinned(const std::string& label, const Eigen::Ref<const Eigen::VectorXd>& values,
               double begin, double rate) {
  Series out{.label = label, .x = {}, .y = {}};
  const Eigen::Index n = values.size(), piece = std::max<Eigen::Index>(1, 2 * n / kPoints);
  const auto add = [&](Eigen::Index i) {
    out.x.push_back(begin + static_cast<double>(i) / rate);
    out.y.push_back(values[i]);
  };
  for (Eigen::Index i = 0; i < n; i += piece) {
    const auto part = values.segment(i, std::min(piece, n - i));
    Eigen::Index low = 0, high = 0;
    part.minCoeff(&low);
    part.maxCoeff(&high);
    add(i + std::min(low, high));
    if (low != high) add(i + std::max(low, high));
  }
  return out;
}

Interval interval(const Segment& segment, double rate, const std::string& label) {
  return {static_cast<double>(segment.begin) / rate, static_cast<double>(segment.end) / rate,
          label};
}

SignalFigure record_figure(const ForceRecord& raw, const ProcessedRecord& done,
                           const std::string& name) {
  SignalFigure figure{.name = "record", .caption = {}, .plot = {}};
  figure.caption =
      "The record as it was read and after the steps; the shaded part is the plateau that the "
      "means are taken from.";
  figure.plot = {.title = name + ": record", .x = {"time, s"}, .panels = {}};
  figure.plot.height = 620;
  for (int axis = 0; axis < 3; ++axis) {
    Panel panel{.y = {fmt::format("F{}, N", kAxes[axis])}, .series = {}};
    panel.series.push_back(thinned(axis == 0 ? "as read" : "", raw.force.col(axis), 0.0, raw.rate));
    panel.series.back().colour = 7;
    panel.series.push_back(
        thinned(axis == 0 ? "after the steps" : "", done.record.force.col(axis), 0.0, raw.rate));
    panel.series.back().colour = 0;
    panel.intervals.push_back(
        interval(done.segments.plateau, raw.rate, axis == 0 ? "plateau" : ""));
    figure.plot.panels.push_back(std::move(panel));
  }
  return figure;
}

/// A few revolutions in the middle of the plateau.
SignalFigure close_figure(const ForceRecord& raw, const ProcessedRecord& done,
                          const std::string& name) {
  const Segment& plateau = done.segments.plateau;
  const double turn = done.rotation ? 2.0 * M_PI / done.rotation->spindle_speed * raw.rate : 0.0;
  Segment shown = plateau;
  if (turn > 0.0 && 4.0 * turn < static_cast<double>(plateau.size())) {
    shown.begin = plateau.begin + plateau.size() / 2;
    shown.end = std::min(plateau.end, shown.begin + static_cast<Eigen::Index>(4.0 * turn));
  } else {
    shown.end = std::min(plateau.end, plateau.begin + 400);
  }
  SignalFigure figure{.name = "close", .caption = {}, .plot = {}};
  figure.caption = turn > 0.0 ? "Four revolutions in the middle of the plateau."
                              : "The beginning of the plateau.";
  figure.plot = {.title = name + ": a close look", .x = {"time, s"}, .panels = {}};
  figure.plot.height = 620;
  const double begin = static_cast<double>(shown.begin) / raw.rate;
  for (int axis = 0; axis < 3; ++axis) {
    Panel panel{.y = {fmt::format("F{}, N", kAxes[axis])}, .series = {}};
    const auto part = [&](const std::string& label, const Eigen::VectorXd& values,
                          Eigen::Index from, std::size_t colour, Mark mark) {
      panel.series.push_back(
          thinned(axis == 0 ? label : "", values.segment(from, shown.size()), begin, raw.rate));
      panel.series.back().colour = colour;
      panel.series.back().mark = mark;
    };
    part("as read", raw.force.col(axis), shown.begin, 7, Mark::line);
    part("after the steps", done.record.force.col(axis), shown.begin, 0, Mark::line);
    if (!done.envelope.empty()) {
      const auto& envelope = done.envelope[static_cast<std::size_t>(axis)];
      part("envelope", envelope.upper, shown.begin - plateau.begin, 1, Mark::dashed);
      part("", envelope.lower, shown.begin - plateau.begin, 1, Mark::dashed);
    }
    figure.plot.panels.push_back(std::move(panel));
  }
  return figure;
}

/// Amplitudes over frequency of the force on a stretch, all axes together, with a Hann window; of
/// each piece of the frequencies the largest, so that no line is lost.
Series spectrum_of(const std::string& label, const ForceRecord& record, const Segment& stretch) {
  const Eigen::Index n = stretch.size();
  const Eigen::ArrayXd turn = Eigen::ArrayXd::LinSpaced(n, 0.0, 2.0 * M_PI);
  const Eigen::ArrayXd window = 0.5 - 0.5 * turn.cos();
  const std::size_t length = identify::fast_length(static_cast<std::size_t>(n));
  std::vector<double> square(length / 2 + 1, 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::ArrayXd force = record.force.col(axis).segment(stretch.begin, n).array();
    const Eigen::VectorXd part = (window * (force - force.mean())).matrix();
    const identify::Spectrum spectrum = identify::forward(part, length);
    for (std::size_t k = 0; k < square.size(); ++k) square[k] += std::norm(spectrum[k]);
  }
  Series out{.label = label, .x = {}, .y = {}};
  const std::size_t piece = 1 + square.size() / static_cast<std::size_t>(kPoints / 2);
  for (std::size_t k = 1; k < square.size(); k += piece) {
    const auto end =
        square.begin() + static_cast<std::ptrdiff_t>(std::min(k + piece, square.size()));
    const auto largest = std::max_element(square.begin() + static_cast<std::ptrdiff_t>(k), end);
    const auto at = static_cast<double>(largest - square.begin());
    out.x.push_back(at * record.rate / static_cast<double>(length));
    out.y.push_back(2.0 * std::sqrt(*largest) / window.sum());
  }
  return out;
}

SignalFigure spectrum_figure(const ForceRecord& raw, const ProcessedRecord& done,
                             const std::string& name) {
  SignalFigure figure{.name = "spectrum", .caption = {}, .plot = {}};
  figure.caption =
      "Amplitudes of the force on the plateau, as read and after the steps: what filter and "
      "compensation of the dynamometer took away or gave back.";
  figure.plot = {
      .title = name + ": spectrum of the plateau",
      .x = {.label = "frequency, Hz", .low = 0.0, .high = 0.5 * raw.rate},
      .panels = {{.y = {.label = "amplitude of F, N", .logarithmic = true}, .series = {}}}};
  Panel& panel = figure.plot.panels[0];
  panel.series = {spectrum_of("as read", raw, done.segments.plateau),
                  spectrum_of("after the steps", done.record, done.segments.plateau)};
  panel.series[0].colour = 7;
  panel.series[1].colour = 0;
  // Four decades are what a sensor has; below them the curve of a filter runs along the edge.
  double largest = 1e-6;
  for (const Series& one : panel.series) {
    largest = std::max(largest, *std::max_element(one.y.begin(), one.y.end()));
  }
  panel.y.low = 1e-4 * largest;
  panel.y.high = 2.0 * largest;
  for (Series& one : panel.series) {
    for (double& amplitude : one.y) amplitude = std::max(amplitude, 1e-4 * largest);
  }
  return figure;
}

SignalFigure mean_figure(const ProcessedRecord& done, const std::string& name) {
  const ForceRecord plateau = identify::cut_out(done.record, done.segments.plateau);
  const double begin = static_cast<double>(done.segments.plateau.begin) / plateau.rate;
  const double end = begin + identify::duration(plateau);
  SignalFigure figure{.name = "mean", .caption = {}, .plot = {}};
  figure.caption =
      "Cumulative mean along the plateau, the regression on time through the means of whole "
      "revolutions, and the mean with its 95 % interval.";
  figure.plot = {.title = name + ": mean of the plateau", .x = {"time, s"}, .panels = {}};
  figure.plot.height = 620;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& mean = done.mean[static_cast<std::size_t>(axis)];
    Panel panel{.y = {fmt::format("F{}, N", kAxes[axis])}, .series = {}};
    // The first revolutions swing with the teeth; they would set the scale.
    const Eigen::VectorXd cumulative = identify::cumulative_mean(plateau.force.col(axis));
    const Eigen::Index skip = cumulative.size() / 20;
    panel.series.push_back(thinned(axis == 0 ? "cumulative mean" : "",
                                   cumulative.tail(cumulative.size() - skip),
                                   begin + static_cast<double>(skip) / plateau.rate, plateau.rate));
    const double half = 0.5 * (end - begin);
    panel.series.push_back({.label = axis == 0 ? "regression" : "",
                            .x = {begin, end},
                            .y = {mean.mean - half * mean.slope, mean.mean + half * mean.slope},
                            .mark = Mark::dashed});
    const double wide = 1.96 * mean.standard_error;
    panel.bands.push_back({.label = axis == 0 ? "mean, 95 %" : "",
                           .x = {begin, end},
                           .low = {mean.mean - wide, mean.mean - wide},
                           .high = {mean.mean + wide, mean.mean + wide}});
    figure.plot.panels.push_back(std::move(panel));
  }
  return figure;
}

SignalFigure revolution_figure(const ProcessedRecord& done, const std::string& name) {
  const identify::RevolutionAverage& average = *done.revolution;
  SignalFigure figure{.name = "revolution", .caption = {}, .plot = {}};
  figure.caption = fmt::format(
      "Mean over {} revolutions with its 95 % interval. Angle 0 is {}.", average.revolutions,
      done.rotation->absolute ? "the pulse" : "not a known place on the spindle");
  figure.plot = {.title = name + ": mean revolution",
                 .x = {.label = "rotation, deg", .low = 0.0, .high = 360.0},
                 .panels = {{.y = {"force, N"}, .series = {}}}};
  Panel& panel = figure.plot.panels[0];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Series series{.label = fmt::format("F{}", kAxes[axis]), .x = {}, .y = {}};
    Band band{.label = {}, .x = {}, .low = {}, .high = {}};
    for (Eigen::Index k = 0; k < average.angle.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(axis);
      const double wide = 1.96 * average.standard_error(k, column);
      series.x.push_back(average.angle[k] / units::deg);
      series.y.push_back(average.force(k, column));
      band.low.push_back(series.y.back() - wide);
      band.high.push_back(series.y.back() + wide);
    }
    band.x = series.x;
    series.colour = band.colour = axis;
    panel.series.push_back(std::move(series));
    panel.bands.push_back(std::move(band));
  }
  return figure;
}

SignalFigure harmonics_figure(const ProcessedRecord& done, int flutes, const std::string& name) {
  SignalFigure figure{.name = "harmonics", .caption = {}, .plot = {}};
  figure.caption = fmt::format(
      "Lines of the force over the revolution. Multiples of {} are the tooth passing; the others "
      "come from run-out or unequal flutes: {:.1f} % of the tooth passing.",
      flutes, 100.0 * done.run_out_ratio);
  figure.plot = {.title = name + ": harmonics of the rotation",
                 .x = {.label = "order of the rotation", .low = 0.0},
                 .panels = {{.y = {.label = "amplitude of |F|, N", .low = 0.0}, .series = {}}}};
  Series teeth{.label = "tooth passing", .x = {}, .y = {}, .mark = Mark::line};
  Series others{.label = "run-out", .x = {}, .y = {}, .mark = Mark::line};
  for (const identify::RotationHarmonic& harmonic : done.harmonics) {
    Series& series = harmonic.order % flutes == 0 ? teeth : others;
    // A needle: up, down, and a gap.
    for (const double y : {0.0, harmonic.amplitude.norm(), 0.0, std::nan("")}) {
      series.x.push_back(harmonic.order);
      series.y.push_back(y);
    }
  }
  figure.plot.x.high = static_cast<double>(done.harmonics.size()) + 1.0;
  figure.plot.panels[0].series.push_back(std::move(teeth));
  if (!others.x.empty()) figure.plot.panels[0].series.push_back(std::move(others));
  return figure;
}

}  // namespace

std::vector<SignalFigure> figures_of(const ForceRecord& raw, const ProcessedRecord& processed,
                                     int flutes, const std::string& name) {
  std::vector<SignalFigure> out{
      record_figure(raw, processed, name), close_figure(raw, processed, name),
      spectrum_figure(raw, processed, name), mean_figure(processed, name)};
  if (processed.revolution) {
    out.push_back(revolution_figure(processed, name));
    out.push_back(harmonics_figure(processed, flutes, name));
  }
  return out;
}

}  // namespace osteomill::io
