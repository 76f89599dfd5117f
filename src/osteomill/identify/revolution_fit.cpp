// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/revolution_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

using Eigen::Index;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kMostBins = 120;

}  // namespace

RevolutionForces gather_revolutions(const Eigen::MatrixX3d& force, const Rotation& rotation,
                                    int bins, int groups) {
  const Index samples = force.rows();
  const auto turn_of = [&](Index i) {
    return static_cast<int>(std::floor(rotation.angle[i] / kTurn + 1e-9));
  };
  const int first = samples > 0 ? static_cast<int>(std::ceil(rotation.angle[0] / kTurn - 1e-9)) : 0;
  const int revolutions = samples > 0 ? turn_of(samples - 1) - first : 0;
  if (revolutions < 2) {
    throw InvalidInput(Fault{"record", fmt::format("{} whole revolutions", revolutions),
                             "must have two whole revolutions on the plateau", ""});
  }
  if (bins == 0) {
    bins = std::clamp(static_cast<int>(samples / (revolutions + 1)), 8, kMostBins);
  }
  const int count = std::min(groups, revolutions);
  RevolutionForces result;
  Eigen::VectorXd angle = Eigen::VectorXd::Zero(bins);
  Eigen::VectorXd square = Eigen::VectorXd::Zero(bins);
  Eigen::VectorXi all = Eigen::VectorXi::Zero(bins);
  Eigen::MatrixX3d sum = Eigen::MatrixX3d::Zero(bins, 3);
  Eigen::MatrixXi each_count = Eigen::MatrixXi::Zero(bins, count);
  Eigen::MatrixXd each_angle = Eigen::MatrixXd::Zero(bins, count);
  Eigen::MatrixXd each = Eigen::MatrixXd::Zero(3 * bins, count);
  for (Index i = 0; i < samples; ++i) {
    const int turn = turn_of(i) - first;
    if (turn < 0 || turn >= revolutions) continue;
    const double within = rotation.angle[i] - kTurn * (turn + first);
    const int bin = std::clamp(static_cast<int>(within / kTurn * bins), 0, bins - 1);
    const auto group = static_cast<Index>(static_cast<std::int64_t>(turn) * count / revolutions);
    angle[bin] += within;
    square[bin] += within * within;
    ++all[bin];
    ++each_count(bin, group);
    each_angle(bin, group) += within;
    for (Index axis = 0; axis < 3; ++axis) {
      sum(bin, axis) += force(i, axis);
      each(axis * bins + bin, group) += force(i, axis);
    }
  }
  std::vector<Index> full;
  for (Index bin = 0; bin < bins; ++bin) {
    if (all[bin] > 0) full.push_back(bin);
  }
  const auto rows = static_cast<Index>(full.size());
  result.mean.resize(rows, 3);
  result.each.resize(count, 3 * rows);
  double variance = 0.0;
  for (Index row = 0; row < rows; ++row) {
    const Index bin = full[static_cast<std::size_t>(row)];
    result.angle.push_back(angle[bin] / all[bin]);
    variance += square[bin] / all[bin] - std::pow(result.angle.back(), 2);
    result.mean.row(row) = sum.row(bin) / all[bin];
  }
  for (Index row = 0; row < rows; ++row) {
    // Samples of a group lie elsewhere in the bin than the average: by the slope of the average
    // they are brought there, or the scatter would count as noise what the next group makes good.
    const Index before = (row + rows - 1) % rows;
    const Index after = (row + 1) % rows;
    const double step = std::remainder(result.angle[static_cast<std::size_t>(after)] -
                                           result.angle[static_cast<std::size_t>(before)],
                                       kTurn);
    const Eigen::RowVector3d slope =
        step > 0.0 ? Eigen::RowVector3d((result.mean.row(after) - result.mean.row(before)) / step)
                   : Eigen::RowVector3d::Zero();
    const Index bin = full[static_cast<std::size_t>(row)];
    for (Index group = 0; group < count; ++group) {
      const int here = each_count(bin, group);
      const double off =
          here > 0 ? each_angle(bin, group) / here - result.angle[static_cast<std::size_t>(row)]
                   : 0.0;
      for (Index axis = 0; axis < 3; ++axis) {
        result.each(group, axis * rows + row) =
            here > 0 ? each(axis * bins + bin, group) / here - slope[axis] * off
                     : result.mean(row, axis);
      }
    }
  }
  // Samples that are locked to the rotation lie at one angle of their bin, others all over it.
  result.width = std::sqrt(12.0 * std::max(0.0, variance / static_cast<double>(rows)));
  return result;
}

std::vector<double> filter_gains(const Butterworth& filter, double rate, double spindle_speed,
                                 double least) {
  const std::vector<Biquad> sections = design(filter, rate);
  std::vector<double> gains{1.0};
  const double turns = spindle_speed / kTurn;
  for (int h = 1; h * turns < 0.5 * rate; ++h) {
    gains.push_back(zero_phase_gain(sections, h * turns, rate));
    if (gains.back() < least) break;
  }
  return gains;
}

InstantaneousFit fit_processed(const ProcessedRecord& processed, const SignalChain& chain,
                               const cutting::Cutter& cutter, const cutting::Condition& condition,
                               const cutting::Immersion& immersion, InstantaneousOptions options) {
  if (!processed.rotation) {
    throw InvalidInput(Fault{"signal.rotation", "none",
                             "the instantaneous method needs the rotation of the spindle",
                             "record a tachometer, or state the speed"});
  }
  if (chain.average_flutes) {
    throw InvalidInput(Fault{"signal.average_flutes", "true",
                             "takes away the run-out that the instantaneous method fits",
                             "leave it out"});
  }
  const Segment& plateau = processed.segments.plateau;
  const RevolutionForces forces =
      gather_revolutions(processed.record.force.middleRows(plateau.begin, plateau.size()),
                         *processed.rotation, chain.bins);
  const double speed = processed.rotation->spindle_speed;
  if (chain.filter_order > 0) {
    const double cutoff = cutoff_of(chain, {condition.spindle_speed, cutter.flutes});
    options.harmonic_gains = filter_gains({.order = chain.filter_order, .cutoff_hz = cutoff},
                                          processed.record.rate, speed);
  }
  options.offset_deviation = baseline_deviation(processed, chain.baseline);
  cutting::Condition turning = condition;
  turning.spindle_speed = speed;
  return fit_instantaneous(forces, cutter, turning, immersion, options);
}

}  // namespace osteomill::identify
