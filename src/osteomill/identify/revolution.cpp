// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/identify/revolution.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "osteomill/base/error.hpp"

namespace osteomill::identify {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Sums of the samples that fall into one bin of the angle.
struct Bin {
  double offset = 0.0;  // of the samples from the middle, bins
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  Eigen::Array3d squares = Eigen::Array3d::Zero();  // about the first sample of the bin
  Eigen::Array3d first = Eigen::Array3d::Zero();
  int count = 0;

  /// Squares about the mean from those about the first sample.
  Eigen::Array3d about_mean() const {
    return (squares - count * (sum / count - first).square()).max(0.0);
  }
};

/// Bins round the turn; the first sample lies in the middle of the first one. So no sample of a
/// rotation that is locked to the sampling lies on a border.
struct Folded {
  std::vector<Bin> bins;
  double first_angle = 0.0;
  int revolutions = 0;

  /// Mean angle of a bin's samples, rad.
  double angle(std::size_t k) const {
    return first_angle + kTurn * (static_cast<double>(k) + bins[k].offset / bins[k].count) /
                             static_cast<double>(bins.size());
  }
};

Folded fold(const Eigen::MatrixX3d& force, const Rotation& rotation, int count) {
  const Eigen::Index n = force.rows();
  if (rotation.angle.size() != n) {
    throw InvalidInput({"rotation", fmt::format("{} angles", rotation.angle.size()),
                        fmt::format("must have one for each of the {} samples", n), ""});
  }
  const double first = n > 0 ? rotation.angle[0] : 0.0;
  // The turn ends one sample's angle behind the last sample.
  const double step = n > 1 ? (rotation.angle[n - 1] - first) / static_cast<double>(n - 1) : 0.0;
  const double turned = n > 1 ? rotation.angle[n - 1] - first + step : 0.0;
  // A thousandth of a sample is rounding.
  Folded out{std::vector<Bin>(static_cast<std::size_t>(count)), first,
             static_cast<int>((turned + 1e-3 * step) / kTurn)};
  if (out.revolutions < 1) {
    throw InvalidInput({"plateau", fmt::format("{:.2f} revolutions", turned / kTurn),
                        "must hold one at least", "take a longer cut"});
  }
  const double end = first + kTurn * out.revolutions - 1e-3 * step;
  const double per_radian = count / kTurn;
  for (Eigen::Index i = 0; i < n && rotation.angle[i] < end; ++i) {
    const double place = (rotation.angle[i] - first) * per_radian;
    const auto nearest = static_cast<long>(place + 0.5);
    Bin& bin = out.bins[static_cast<std::size_t>(nearest % count)];
    const Eigen::Array3d f = force.row(i).transpose();
    if (bin.count++ == 0) bin.first = f;
    bin.offset += place - static_cast<double>(nearest);
    bin.sum += f;
    bin.squares += (f - bin.first).square();
  }
  return out;
}

/// Mean over the angle: trapezoids between the bins, round the turn.
Eigen::Vector3d mean_over_turn(const RevolutionAverage& average) {
  const Eigen::Index m = average.angle.size();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index k = 0; k < m; ++k) {
    const Eigen::Index next = (k + 1) % m;
    const double step = average.angle[next] - average.angle[k] + (next == 0 ? kTurn : 0.0);
    sum += 0.5 * step * (average.force.row(k) + average.force.row(next)).transpose();
  }
  return sum / kTurn;
}

int bins_for(const Rotation& rotation, int bins) {
  if (bins > 0) return bins;
  const auto n = static_cast<double>(rotation.angle.size());
  const double turned = n > 1 ? rotation.angle[rotation.angle.size() - 1] - rotation.angle[0] : 0.0;
  if (!(turned > 0.0)) return 1;
  return std::clamp(static_cast<int>(std::lround((n - 1.0) * kTurn / turned)), 1, 360);
}

RevolutionAverage average_of(const Folded& folded) {
  // From angle 0 on: the bins that hold something, by their angle within the turn.
  std::vector<std::pair<double, const Bin*>> rows;
  Eigen::Array3d variances = Eigen::Array3d::Zero();
  int freedom = 0;
  for (std::size_t k = 0; k < folded.bins.size(); ++k) {
    const Bin& bin = folded.bins[k];
    if (bin.count == 0) continue;
    const double angle = folded.angle(k);
    rows.emplace_back(angle - kTurn * std::floor(angle / kTurn), &bin);
    variances += bin.about_mean();
    freedom += bin.count - 1;
  }
  const auto least = std::min_element(
      rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::rotate(rows.begin(), least, rows.end());
  const Eigen::Array3d pooled =
      freedom > 0 ? (variances / freedom).sqrt().eval() : Eigen::Array3d::Zero().eval();
  const auto filled = static_cast<Eigen::Index>(rows.size());
  RevolutionAverage out;
  out.revolutions = folded.revolutions;
  out.angle.resize(filled);
  out.force.resize(filled, 3);
  out.standard_error.resize(filled, 3);
  out.count.resize(filled);
  for (Eigen::Index k = 0; k < filled; ++k) {
    const Bin& bin = *rows[static_cast<std::size_t>(k)].second;
    out.angle[k] = rows[static_cast<std::size_t>(k)].first;
    out.force.row(k) = (bin.sum / bin.count).transpose();
    out.count[k] = bin.count;
    const double pairs = static_cast<double>(bin.count - 1) * bin.count;
    out.standard_error.row(k) =
        (bin.count > 1 ? (bin.about_mean() / pairs).sqrt().eval() : pooled).transpose();
  }
  out.mean = mean_over_turn(out);
  return out;
}

}  // namespace

RevolutionAverage average_revolution(const Eigen::MatrixX3d& force, const Rotation& rotation,
                                     int bins) {
  return average_of(fold(force, rotation, bins_for(rotation, bins)));
}

RevolutionAverage average_pitch(const Eigen::MatrixX3d& force, const Rotation& rotation, int flutes,
                                int bins) {
  require_within("cutter.flutes", flutes, 1, 64, "");
  const int pitch = std::max(1, (bins_for(rotation, bins) + flutes - 1) / flutes);
  const Folded folded = fold(force, rotation, pitch * flutes);
  const RevolutionAverage whole = average_of(folded);
  if (whole.angle.size() != static_cast<Eigen::Index>(folded.bins.size())) {
    throw InvalidInput({"signals.bins", fmt::format("{}", folded.bins.size()),
                        "some hold no sample, so the flutes cannot be averaged", "lower it"});
  }
  RevolutionAverage out = whole;
  for (int k = 0; k < pitch; ++k) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    Eigen::Array<double, 1, 3> variance = Eigen::Array<double, 1, 3>::Zero();
    double offset = 0.0;
    int count = 0;
    for (int copy = 0; copy < flutes; ++copy) {
      const int row = k + copy * pitch;
      sum += whole.force.row(row);
      variance += whole.standard_error.row(row).array().square();
      offset += whole.angle[row] - kTurn * copy / flutes;
      count += whole.count[row];
    }
    for (int copy = 0; copy < flutes; ++copy) {
      const int row = k + copy * pitch;
      out.force.row(row) = sum / flutes;
      out.standard_error.row(row) = variance.sqrt().matrix() / flutes;
      out.angle[row] = offset / flutes + kTurn * copy / flutes;
      out.count[row] = count;
    }
  }
  out.mean = mean_over_turn(out);
  return out;
}

std::vector<RotationHarmonic> rotation_harmonics(const Eigen::MatrixX3d& force,
                                                 const Rotation& rotation, int highest) {
  // Bins so fine that averaging over their width takes 1e-4 off order 100.
  const Folded folded = fold(force, rotation, 8192);
  double n = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Bin& bin : folded.bins) {
    n += bin.count;
    mean += bin.sum.matrix();
  }
  mean /= n;
  std::vector<RotationHarmonic> out;
  for (int order = 1; order <= highest; ++order) {
    Eigen::Vector3cd sum = Eigen::Vector3cd::Zero();
    for (std::size_t k = 0; k < folded.bins.size(); ++k) {
      const Bin& bin = folded.bins[k];
      if (bin.count == 0) continue;
      const auto z = std::polar(1.0, -order * folded.angle(k));
      sum += z * (bin.sum.matrix() - bin.count * mean).cast<std::complex<double>>();
    }
    RotationHarmonic harmonic{.order = order};
    harmonic.amplitude = 2.0 / n * sum.cwiseAbs();
    for (int axis = 0; axis < 3; ++axis) harmonic.phase[axis] = std::arg(sum[axis]);
    out.push_back(harmonic);
  }
  return out;
}

}  // namespace osteomill::identify
